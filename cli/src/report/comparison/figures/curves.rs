//! Curves over frequency: responses of models and of generated records, and differences against the limits.

use nalgebra::Complex;

use crate::report::plot::{Axis, Dash, Panel, Plot, Style};
use actuator_fmu::parameters::{LoadCase, Model, Order, Stage, Surface};
use identification::{
    compare::{AEROELASTIC_BAND_HZ, Comparison, Difference, LIMITS, Set, experiment::Experiment},
    frequency::{BAND_HZ, FrequencyPoint, phase_deg},
};

/// Inputs of the figures.
pub struct Content<'a> {
    pub comparison: &'a Comparison,
    pub experiments: &'a [Experiment],
}

/// Responses of one chart: label, style, whether as marks, points.
pub type Curves = Vec<(String, Style, bool, Vec<(f64, Complex<f64>)>)>;

/// Points of a curve: one for every two units of the picture's width.
const POINTS: u32 = 180;

fn frequencies() -> impl Iterator<Item = f64> {
    (0..=POINTS).map(|index| BAND_HZ[0] + (BAND_HZ[1] - BAND_HZ[0]) * f64::from(index) / f64::from(POINTS))
}

fn points(set: &Set) -> Vec<(f64, Complex<f64>)> {
    frequencies().map(|frequency| (frequency, set.response(frequency))).collect()
}

/// Early, middle, late: distinguished by colour and dash.
fn stage_style(stage: Stage) -> Style {
    match stage {
        Stage::Early => Style::colour(0),
        Stage::Middle => Style::colour(1).dash(Dash::Dashed),
        Stage::Late => Style::colour(2).dash(Dash::Dotted),
    }
}

impl Content<'_> {
    fn experiment(&self, set: &Set) -> Option<Vec<(f64, Complex<f64>)>> {
        let found = self.experiments.iter().find(|experiment| experiment.label == set.label)?;
        let sure = |point: &&FrequencyPoint| {
            let (magnitude, phase) = (point.magnitude_std_error, point.phase_std_error_deg);
            point.excited && magnitude < LIMITS.magnitude && phase < LIMITS.phase_deg
        };
        let inside = found.response.inside(BAND_HZ).filter(sure);
        Some(inside.map(|point| (point.frequency_hz, point.response)).collect())
    }

    /// Experiment and model of one set.
    pub fn both(&self, surface: Surface, stage: Stage, load_case: LoadCase) -> Curves {
        let Some(set) = self.comparison.set(surface, stage, load_case) else { return Vec::new() };
        let experiment =
            self.experiment(set).map(|points| ("experiment (generated)".into(), Style::colour(5), true, points));
        let model = ("model".into(), Style::colour(0), false, points(set));
        experiment.into_iter().chain([model]).collect()
    }

    /// Models early, in the middle and late.
    pub fn models_by_stage(&self, surface: Surface, load_case: LoadCase) -> Curves {
        let stages =
            Stage::ALL.iter().filter_map(|&stage| Some((stage, self.comparison.set(surface, stage, load_case)?)));
        stages.map(|(stage, set)| (stage.name().into(), stage_style(stage), false, points(set))).collect()
    }

    /// All models of one surface, distinguished by colour; those under load are dashed.
    pub fn models_of(&self, surface: &str) -> Curves {
        let own = self.comparison.sets.iter().filter_map(|set| {
            let condition = set.condition.as_ref().filter(|condition| condition.surface == surface)?;
            let dash = if condition.load_case == LoadCase::Loaded { Dash::Dashed } else { Dash::Solid };
            Some((format!("{}, {}", condition.stage, condition.load_case.name()), dash, set))
        });
        own.enumerate()
            .map(|(at, (label, dash, set))| (label, Style::colour(at).dash(dash), false, points(set)))
            .collect()
    }

    /// All models in one chart, whatever is known of them.
    pub fn models(&self) -> Curves {
        let dash = |at: usize| [Dash::Solid, Dash::Dashed, Dash::Dotted][at % 3];
        let all = self.comparison.sets.iter().enumerate();
        all.map(|(at, set)| (set.label.clone(), Style::colour(at).dash(dash(at)), false, points(set))).collect()
    }

    /// Experiments early, in the middle and late.
    pub fn experiments_by_stage(&self, surface: Surface, load_case: LoadCase) -> Curves {
        let stages =
            Stage::ALL.iter().filter_map(|&stage| Some((stage, self.comparison.set(surface, stage, load_case)?)));
        stages
            .filter_map(|(stage, set)| Some((stage.name().into(), stage_style(stage), false, self.experiment(set)?)))
            .collect()
    }

    /// Models without and with load.
    pub fn models_by_load(&self, surface: Surface, stage: Stage) -> Curves {
        let styles = [Style::colour(0), Style::colour(1).dash(Dash::Dashed)];
        LoadCase::ALL
            .iter()
            .zip(styles)
            .filter_map(|(&load_case, style)| {
                let set = self.comparison.set(surface, stage, load_case)?;
                Some((load_case.name().into(), style, false, points(set)))
            })
            .collect()
    }
}

fn frequency_axis() -> Axis {
    Axis::linear("frequency, Hz", BAND_HZ[0], BAND_HZ[1]).ticks(&[0.5, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0])
}

/// Magnitude and phase over frequency; `None` without curves.
pub fn response(curves: &Curves, title: &str, lowest_phase_deg: f64) -> Option<Plot> {
    if curves.is_empty() {
        return None;
    }
    let mut magnitude = Panel::new(Axis::linear("magnitude", 0.0, 1.5));
    let mut phase = Panel::new(Axis::linear("phase, deg", lowest_phase_deg, 0.0));
    let mut leaves = false;
    for (label, style, marks, points) in curves {
        let of_magnitude = points.iter().map(|(frequency, response)| [*frequency, response.norm()]).collect();
        let of_phase: Vec<[f64; 2]> =
            points.iter().map(|(frequency, response)| [*frequency, phase_deg(*response)]).collect();
        leaves |= of_phase.last().is_some_and(|[_, phase]| *phase < lowest_phase_deg);
        let draw = if *marks { Panel::marks } else { Panel::line };
        magnitude = draw(magnitude, *style, label, of_magnitude);
        phase = draw(phase, *style, label, of_phase);
    }
    let note = if leaves { "The phase leaves the report's axes." } else { "" };
    Some(Plot::new(title, frequency_axis()).note(note).panel(magnitude).panel(phase))
}

/// As [`response`], for curves that show a difference: at least two are needed.
pub fn several(curves: &Curves, title: &str, lowest_phase_deg: f64) -> Option<Plot> {
    if curves.len() < 2 { None } else { response(curves, title, lowest_phase_deg) }
}

/// Figure 7: the effect of omitting the pole of a set.
pub fn order_error(comparison: &Comparison, surface: Surface, stage: Stage, load_case: LoadCase) -> Option<Plot> {
    let set = comparison.set(surface, stage, load_case).filter(|set| set.model.order == Order::Third)?;
    let second = Set { model: Model { order: Order::Second, ..set.model.clone() }, ..set.clone() };
    let pairs: Vec<_> = points(set).into_iter().zip(points(&second)).collect();
    // In millionths, so that the axis has digits to show.
    let magnitude: Vec<[f64; 2]> =
        pairs.iter().map(|((f, third), (_, second))| [*f, 1e6 * (third.norm() - second.norm())]).collect();
    let phase: Vec<[f64; 2]> =
        pairs.iter().map(|((f, third), (_, second))| [*f, phase_deg(third * second.conj())]).collect();
    let of_magnitude = Axis::around(
        format!("Δ magnitude, 1e-6 {}", comparison.gain_unit()),
        magnitude.iter().map(|point| point[1]).chain([0.0]),
    );
    let of_phase = Axis::around("Δ phase, deg", phase.iter().map(|point| point[1]).chain([0.0]));
    Some(
        Plot::new(format!("{}: equation (1) minus equation (6)", set.label), frequency_axis())
            .panel(Panel::new(of_magnitude).line(Style::colour(0), "", magnitude))
            .panel(Panel::new(of_phase).line(Style::colour(0), "", phase)),
    )
}

/// |Δ magnitude| and |Δ phase| of pairs over frequency, with the limits; `None` without pairs.
pub fn difference(comparison: &Comparison, pairs: &[&Difference], title: &str) -> Option<Plot> {
    let set = |label: &str| comparison.sets.iter().find(|set| set.label == label);
    let curves: Vec<_> = pairs
        .iter()
        .enumerate()
        .filter_map(|(index, pair)| {
            let (from, to) = (points(set(&pair.from)?), points(set(&pair.to)?));
            let magnitude: Vec<[f64; 2]> =
                from.iter().zip(&to).map(|((f, a), (_, b))| [*f, (b.norm() - a.norm()).abs()]).collect();
            let phase: Vec<[f64; 2]> =
                from.iter().zip(&to).map(|((f, a), (_, b))| [*f, phase_deg(b * a.conj()).abs()]).collect();
            let dash = if index < 3 { Dash::Solid } else { Dash::Dashed };
            Some((short(pair), Style::colour(index % 3).dash(dash), magnitude, phase))
        })
        .collect();
    if curves.is_empty() {
        return None;
    }
    let top = |values: f64, limit: f64| [0.0, values.max(1.2 * limit)];
    let greatest = |of: fn(&Difference) -> f64| pairs.iter().map(|pair| of(pair)).fold(0.0, f64::max);
    let of_magnitude = top(greatest(|pair| pair.data_band.magnitude.max), LIMITS.magnitude);
    let of_phase = top(greatest(|pair| pair.data_band.phase_deg.max), LIMITS.phase_deg);
    let [first, last] = AEROELASTIC_BAND_HZ;
    let mut magnitude = Panel::new(Axis::around(format!("|Δ magnitude|, {}", comparison.gain_unit()), of_magnitude))
        .span(first, last, "3-5 Hz");
    let mut phase = Panel::new(Axis::around("|Δ phase|, deg", of_phase)).span(first, last, "");
    for (label, style, of_magnitude, of_phase) in curves {
        magnitude = magnitude.line(style, &label, of_magnitude);
        phase = phase.line(style, &label, of_phase);
    }
    // Last, so that their text is in front of the curves.
    magnitude = magnitude.limit(LIMITS.magnitude, format!("limit {}", LIMITS.magnitude));
    phase = phase.limit(LIMITS.phase_deg, format!("limit {} deg", LIMITS.phase_deg));
    Some(Plot::new(title, frequency_axis()).panel(magnitude).panel(phase))
}

/// The difference between two sets, in words.
fn short(pair: &Difference) -> String {
    match &pair.conditions {
        Some([from, to]) if from.load_case != to.load_case => format!("{}: loaded", from.stage),
        Some([from, to]) => format!("{}-{}, {}", from.stage, to.stage, from.load_case.name()),
        None => pair.to.clone(),
    }
}
