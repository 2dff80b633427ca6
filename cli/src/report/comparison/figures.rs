//! Figures 6 to 13 and A1 to A10 of the report, and two additional ones: all differences of wear and of load against the limits. Figures of
//! the appendix have the report's axes: 0 to 1.5 deg/deg, -50 to 0 deg, 0.5 to 12 Hz, linear.

mod curves;
mod parameters;

use crate::report::plot::{Plot, aligned, row};
use actuator_fmu::parameters::{LoadCase, Stage, Surface};
use curves::{Content, difference, order_error, response, several};
use identification::compare::{
    Comparison,
    experiment::{Experiment, NOTE},
};
use parameters::bars;

/// One figure: its charts are side by side.
#[derive(Debug, Clone)]
pub struct Figure {
    /// File name without extension.
    pub file: String,
    /// Title.
    pub title: String,
    /// Origin of the curves, if not the sets alone.
    pub note: String,
    /// (a), (b), (c).
    pub plots: Vec<Plot>,
}

impl Figure {
    /// As a standalone picture.
    #[must_use]
    pub fn svg(&self) -> String {
        row(&self.plots)
    }
}

/// Lower end of the report's phase axis [deg].
const REPORT_PHASE_DEG: f64 = -50.0;

/// All figures possible with these sets, in the order of the report.
#[must_use]
pub fn figures(comparison: &Comparison, experiments: &[Experiment]) -> Vec<Figure> {
    use LoadCase::{Loaded, Unloaded};
    use Stage::{Early, Late};
    use Surface::{LowerSpoiler, TrailingEdge, UpperSpoiler};
    let all = Content { comparison, experiments };
    let mut figures = Vec::new();
    let mut add = |number: &str, title: String, note: &str, plots: Vec<Option<Plot>>| {
        let plots = aligned(plots.into_iter().flatten().collect());
        if !plots.is_empty() {
            let title = if number.is_empty() { title } else { format!("Figure {number}. {title}") };
            let file = if number.is_empty() { file_name(&title) } else { format!("figure-{number}") };
            if note == NOTE && experiments.is_empty() {
                return;
            }
            figures.push(Figure { file, title, note: note.into(), plots });
        }
    };
    add(
        "6",
        "Experiment and model, upper spoiler late in the test under load".into(),
        NOTE,
        vec![response(&all.both(UpperSpoiler, Late, Loaded), "Upper spoiler, late, loaded", -60.0)],
    );
    add(
        "7",
        "Third order minus second order, lower spoiler early without load".into(),
        "",
        vec![order_error(comparison, LowerSpoiler, Early, Unloaded)],
    );
    let stages = "Parameters through the test, without load";
    add("8", format!("{stages}: frequency ω"), "", vec![bars(comparison, 2, &parameters::by_stage())]);
    add("9", format!("{stages}: damping ratio ζ"), "", vec![bars(comparison, 3, &parameters::by_stage())]);
    add(
        "10",
        "Effect of time on the trailing edge, without load".into(),
        "",
        vec![several(&all.models_by_stage(TrailingEdge, Unloaded), "Trailing edge, unloaded", REPORT_PHASE_DEG)],
    );
    let loads = "Parameters early in the test";
    add("11", format!("{loads}: frequency ω"), "", vec![bars(comparison, 2, &parameters::by_load())]);
    add("12", format!("{loads}: damping ratio ζ"), "", vec![bars(comparison, 3, &parameters::by_load())]);
    add(
        "13",
        "Effect of load on the trailing edge, early".into(),
        "",
        vec![several(&all.models_by_load(TrailingEdge, Early), "Trailing edge, early", REPORT_PHASE_DEG)],
    );
    for (number, load_case, measured) in
        [("A1", Unloaded, true), ("A2", Loaded, true), ("A3", Unloaded, false), ("A4", Loaded, false)]
    {
        let plot = |surface: &Surface| {
            let curves = if measured {
                all.experiments_by_stage(*surface, load_case)
            } else {
                all.models_by_stage(*surface, load_case)
            };
            several(&curves, &format!("{}, {}", readable(surface.name()), load_case.name()), REPORT_PHASE_DEG)
        };
        let (what, note) = if measured { ("Experiment", NOTE) } else { ("Models", "") };
        add(number, format!("{what}, {}", load_case.name()), note, Surface::ALL.iter().map(plot).collect());
    }
    for (load_case, numbers) in [(Unloaded, ["A5", "A6", "A7"]), (Loaded, ["A8", "A9", "A10"])] {
        for (surface, number) in Surface::ALL.iter().zip(numbers) {
            let plot = |stage: &Stage| {
                let title = format!("{}, {}, {}", readable(surface.name()), stage.name(), load_case.name());
                response(&all.both(*surface, *stage, load_case), &title, REPORT_PHASE_DEG)
            };
            let title = format!("Experiment and model, {}, {}", surface.name().replace('_', " "), load_case.name());
            add(number, title, NOTE, Stage::ALL.iter().map(plot).collect());
        }
    }
    if !comparison.against_first.is_empty() {
        add("", "Responses".into(), "", vec![response(&all.models(), "Responses", REPORT_PHASE_DEG)]);
    } else if comparison.statements.is_empty() {
        let of = |surface: &str| response(&all.models_of(surface), &readable(surface), REPORT_PHASE_DEG);
        add("", "Responses".into(), "", comparison.surfaces().into_iter().map(of).collect());
    }
    add("", "Differences over time against the limits".into(), "", differences(comparison, &comparison.wear, "time"));
    add("", "Differences under load against the limits".into(), "", differences(comparison, &comparison.load, "load"));
    add(
        "",
        "Differences against the first set".into(),
        "",
        vec![difference(comparison, &comparison.against_first.iter().collect::<Vec<_>>(), "Against the first set")],
    );
    figures
}

fn file_name(title: &str) -> String {
    title.to_lowercase().replace(' ', "-")
}

/// Differences of wear and of load over frequency, one chart for each surface.
#[must_use]
pub fn difference_plots(comparison: &Comparison) -> Vec<Plot> {
    let wear = differences(comparison, &comparison.wear, "time").into_iter().flatten();
    aligned(wear.chain(differences(comparison, &comparison.load, "load").into_iter().flatten()).collect())
}

fn differences(
    comparison: &Comparison,
    pairs: &[identification::compare::Difference],
    what: &str,
) -> Vec<Option<Plot>> {
    let plot = |surface: &str| {
        let own = |pair: &&identification::compare::Difference| {
            pair.conditions.as_ref().is_some_and(|[from, _]| from.surface == surface)
        };
        difference(comparison, &pairs.iter().filter(own).collect::<Vec<_>>(), &format!("{}, {what}", readable(surface)))
    };
    comparison.surfaces().into_iter().map(plot).collect()
}

/// `trailing_edge` as "Trailing edge".
fn readable(word: &str) -> String {
    let spaced = word.replace('_', " ");
    let mut letters = spaced.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
