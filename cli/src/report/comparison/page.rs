//! `compare.html`: numbers, statements, figures, tables.

use super::{
    figures::Figure,
    wording::{
        beyond_limits, count_sentence, interval, left_out, limits_sentence, order_sentence, passed, sections,
        worst_order,
    },
};
use crate::{
    invocation::Invocation,
    report::{
        head::{FileRow, Head},
        page::{Cell, Page, Tone},
    },
};
use actuator_fmu::parameters::{Base, LoadCase};
use identification::{
    compare::{Comparison, Difference, LIMITS, Set, Verdict},
    digits::significant,
};

pub(super) fn page(
    comparison: &Comparison,
    figures: &[Figure],
    models: Vec<FileRow>,
    invocation: &Invocation,
) -> String {
    let is_within = beyond_limits(comparison).0 == 0;
    let is_of_conditions = comparison.against_first.is_empty();
    let title = if is_of_conditions {
        "Wear and load of actuators: differences of frequency responses"
    } else {
        "Differences of frequency responses"
    };
    let head = Head {
        title: title.into(),
        tone: if is_within { Tone::Good } else { Tone::Bad },
        verdict: (if is_within { "within the limits" } else { "beyond the limits" }).into(),
        sentence: format!("{}.", limits_sentence(comparison)),
        evidence: String::new(),
        model: comparison.source.clone(),
        files: models,
        invocation,
    };
    let mut page = head.page().paragraph(&format!(
        "Allowed are {} deg/deg in magnitude and {} deg in phase. A difference of phase is the angle of H_to conj(H_from). A limit is \
         exceeded from the first hundredth of a hertz beyond it.",
        LIMITS.magnitude, LIMITS.phase_deg
    ));
    page = differences(page, comparison);
    for sentence in left_out(comparison) {
        page = page.paragraph(&sentence);
    }
    if let Some(worst) = worst_order(comparison) {
        page = page.heading("Order").paragraph(&format!("{}.", order_sentence(comparison, worst)));
    }
    if !comparison.statements.is_empty() {
        let rows: Vec<_> = comparison
            .statements
            .iter()
            .map(|statement| {
                let tone = match statement.verdict {
                    Verdict::Agrees => Tone::Good,
                    Verdict::Contradicted => Tone::Bad,
                    Verdict::CannotBeChecked => Tone::Open,
                };
                (
                    tone,
                    statement.verdict.text().to_owned(),
                    statement.claim.to_owned(),
                    statement.finding.clone(),
                    statement.section.to_owned(),
                )
            })
            .collect();
        page = page
            .heading("What the report says, against its own tables")
            .paragraph(&format!("{}. Claims are paraphrased.", count_sentence(&comparison.statements)))
            .verdicts(&rows);
    }
    page = tables(page, comparison);
    page = page.heading("Figures");
    // Differences of one chart are side by side.
    for group in figures.chunk_by(|a, b| a.plots.len() == 1 && b.plots.len() == 1) {
        match group {
            [several] if several.plots.len() != 1 => {
                page = page.subheading(&several.title);
                if !several.note.is_empty() {
                    page = page.remark(&several.note);
                }
                page = page.plots(&several.plots);
            }
            singles => {
                let plots = singles.iter().flat_map(|figure| {
                    figure.plots.iter().map(|plot| (figure.title.as_str(), figure.note.as_str(), plot))
                });
                page = page.figures(plots);
            }
        }
    }
    page.html()
}

/// Wear and load, or all against the first.
#[must_use]
pub fn differences(mut page: Page, comparison: &Comparison) -> Page {
    for (title, differences) in sections(comparison) {
        let magnitude = format!("|\u{2060}Δ\u{a0}magnitude|, {}", comparison.gain_unit());
        let phase = "|\u{2060}Δ\u{a0}phase|, deg";
        let [magnitude_from, phase_from] =
            [format!("> {} from, Hz", LIMITS.magnitude), format!("> {} deg from, Hz", LIMITS.phase_deg)];
        let (inner_magnitude, inner_phase) = (format!("3-5 Hz: {magnitude}"), format!("3-5 Hz: {phase}"));
        let heads = [
            "from",
            "to",
            &magnitude,
            "at, Hz",
            &magnitude_from,
            phase,
            "at, Hz",
            &phase_from,
            &inner_magnitude,
            &inner_phase,
        ];
        page = page.heading(title).table(&heads, &differences.iter().map(row).collect::<Vec<_>>());
    }
    page
}

fn row(pair: &Difference) -> Vec<Cell> {
    let (all, inner) = (&pair.data_band, &pair.aeroelastic_band);
    let beyond = |extreme: &identification::compare::Extreme| extreme.first_passed_hz.is_some();
    vec![
        Cell::text(&pair.from),
        Cell::text(&pair.to),
        Cell::judged(format!("{:.4}{}", all.magnitude.max, interval(&all.magnitude, 4)), beyond(&all.magnitude)),
        Cell::number(format!("{:.2}", all.magnitude.at_hz)),
        Cell::number(passed(all.magnitude.first_passed_hz)),
        Cell::judged(format!("{:.2}{}", all.phase_deg.max, interval(&all.phase_deg, 2)), beyond(&all.phase_deg)),
        Cell::number(format!("{:.2}", all.phase_deg.at_hz)),
        Cell::number(passed(all.phase_deg.first_passed_hz)),
        Cell::judged(format!("{:.4}{}", inner.magnitude.max, interval(&inner.magnitude, 4)), beyond(&inner.magnitude)),
        Cell::judged(format!("{:.2}{}", inner.phase_deg.max, interval(&inner.phase_deg, 2)), beyond(&inner.phase_deg)),
    ]
}

/// Tables 1 and 2: parameters of the sets by load case; of sets without a condition in one table.
fn tables(mut page: Page, comparison: &Comparison) -> Page {
    let heads: Vec<String> = ["set".to_owned()]
        .into_iter()
        .chain(Base::PARAMETERS.iter().map(|parameter| {
            let unit = if parameter.name == "k" { comparison.gain_unit() } else { parameter.unit };
            format!("{}, {unit}", parameter.name)
        }))
        .collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    // Models compared with a first one are in one table.
    let table_of = |set: &&Set| {
        set.condition.as_ref().filter(|_| comparison.against_first.is_empty()).map(|condition| condition.load_case)
    };
    let titles = [
        (Some(LoadCase::Unloaded), "Table 1: parameters without aerodynamic load"),
        (Some(LoadCase::Loaded), "Table 2: parameters with aerodynamic load"),
        (None, "Parameters"),
    ];
    for (load_case, title) in titles {
        let rows: Vec<Vec<Cell>> = comparison
            .sets
            .iter()
            .filter(|set| table_of(set) == load_case)
            .map(|set| {
                let mut row = vec![Cell::text(&set.label)];
                for (value, error) in set.model.base.values().iter().zip(set.model.std_errors) {
                    let value = if *value > 1e6 { format!("{value:e}") } else { format!("{:.5}", value) };
                    let value = value.trim_end_matches('0').trim_end_matches('.');
                    row.push(Cell::number(
                        error.map_or_else(|| value.to_owned(), |error| format!("{value} ± {}", significant(error, 2))),
                    ));
                }
                row
            })
            .collect();
        if !rows.is_empty() {
            page = page.heading(title).table(&heads, &rows);
        }
    }
    page
}
