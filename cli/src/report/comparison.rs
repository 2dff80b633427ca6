//! A comparison as text, as a page and as pictures.

mod figures;
mod page;
mod wording;

use std::fmt::Write as _;

pub use figures::{Figure, difference_plots, figures};
pub use page::differences;

use super::head::FileRow;
use crate::invocation::Invocation;
use actuator_fmu::error::{Error, Result};
use identification::compare::{
    Comparison, Difference, LIMITS,
    experiment::{Experiment, experiments},
};
use wording::{count_sentence, interval, left_out, order_sentence, passed, sections, worst_order};

/// Seed of the generated records in figures: arbitrary, but fixed for reproducible figures.
const SEED: u64 = 1;

/// All files of a comparison: figures, `compare.json` and, last, `compare.html`. `models` are the files of the given models.
///
/// # Errors
/// None for the sets of the tables; see [`experiments`].
pub fn files(comparison: &Comparison, models: Vec<FileRow>, invocation: &Invocation) -> Result<Vec<(String, Vec<u8>)>> {
    // Only the report has figures of experiments, and only its sets need generated ones in their place.
    let of_tables = !comparison.statements.is_empty();
    let experiments: Vec<Experiment> = if of_tables { experiments(comparison, SEED)? } else { Vec::new() };
    let figures = figures(comparison, &experiments);
    let mut files: Vec<(String, Vec<u8>)> =
        figures.iter().map(|figure| (format!("{}.svg", figure.file), figure.svg().into_bytes())).collect();
    let json = serde_json::to_string_pretty(comparison)
        .map_err(|error| Error::new("JSON", error.to_string(), "values that JSON can hold"))?;
    files.push(("compare.json".into(), format!("{json}\n").into_bytes()));
    files.push(("compare.html".into(), page::page(comparison, &figures, models, invocation).into_bytes()));
    Ok(files)
}

/// Wear and load, or all against the first, for a terminal.
#[must_use]
pub fn differences_text(comparison: &Comparison) -> String {
    sections(comparison).map(|(title, differences)| table(title, differences)).collect()
}

/// Summary for a terminal.
#[must_use]
pub fn text(comparison: &Comparison) -> String {
    let mut text = differences_text(comparison);
    for sentence in left_out(comparison) {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{sentence}\n");
    }
    if let Some(worst) = worst_order(comparison) {
        let _ = writeln!(text, "{}\n", order_sentence(comparison, worst));
    }
    if !comparison.statements.is_empty() {
        let _ = writeln!(text, "{}\n", count_sentence(&comparison.statements));
        for statement in &comparison.statements {
            let _ = writeln!(text, "{:<17} {} ({})", statement.verdict.text(), statement.claim, statement.section);
            let _ = writeln!(text, "{:<17} {}", "", statement.finding);
        }
    }
    text
}

fn table(title: &str, differences: &[Difference]) -> String {
    let width = differences.iter().flat_map(|pair| [pair.from.len(), pair.to.len()]).max().unwrap_or(0);
    let mut text = format!("{title}\n");
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "{:<width$}  {:<width$}  {:-^35} {:-^33} {:-^14}",
        "", "", " magnitude, 0.5-12 Hz ", " phase, 0.5-12 Hz ", " 3-5 Hz "
    );
    let _ = writeln!(
        text,
        "{:<width$}  {:<width$}  {:>13} {:>8} {:>12} {:>11} {:>8} {:>12} {:>7} {:>6}",
        "from", "to", "max", "at Hz", "> 0.1 from", "max deg", "at Hz", "> 3 deg from", "max", "deg"
    );
    for pair in differences {
        let (all, inner) = (&pair.data_band, &pair.aeroelastic_band);
        let _ = writeln!(
            text,
            "{:<width$}  {:<width$}  {:>13} {:>8.2} {:>12} {:>11} {:>8.2} {:>12} {:>7.4} {:>6.2}{}",
            pair.from,
            pair.to,
            format!("{:.4}{}", all.magnitude.max, interval(&all.magnitude, 4)),
            all.magnitude.at_hz,
            passed(all.magnitude.first_passed_hz),
            format!("{:.2}{}", all.phase_deg.max, interval(&all.phase_deg, 2)),
            all.phase_deg.at_hz,
            passed(all.phase_deg.first_passed_hz),
            inner.magnitude.max,
            inner.phase_deg.max,
            if all.within_limits { "" } else { "  beyond" }
        );
    }
    let beyond = differences.iter().filter(|pair| !pair.data_band.within_limits).count();
    let inner = differences.iter().filter(|pair| !pair.aeroelastic_band.within_limits).count();
    let _ = writeln!(
        text,
        "{beyond} of {} exceed {} or {} deg within 0.5-12 Hz, {inner} within 3-5 Hz\n",
        differences.len(),
        LIMITS.magnitude,
        LIMITS.phase_deg
    );
    text
}
