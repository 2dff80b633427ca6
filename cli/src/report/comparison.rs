//! A comparison as text, as a page and as pictures.

mod figures;
mod page;

use std::fmt::Write as _;

pub use figures::{Figure, difference_plots, figures};
pub use page::differences;

use actuator_fmu::error::{Error, Result};
use identification::compare::{
    Comparison, Difference, Extreme, LIMITS, Statement, Verdict,
    experiment::{Experiment, experiments},
};

/// Seed of the generated records in figures: any number would do, and a fixed one draws the same pictures each time.
const SEED: u64 = 1;

/// All files of a comparison: figures, `compare.json` and, last, `compare.html`.
///
/// # Errors
/// None for the sets of the tables; see [`experiments`].
pub fn files(comparison: &Comparison) -> Result<Vec<(String, Vec<u8>)>> {
    // Only the report has figures of experiments, and only its sets need generated ones in their place.
    let of_tables = !comparison.statements.is_empty();
    let experiments: Vec<Experiment> = if of_tables { experiments(comparison, SEED)? } else { Vec::new() };
    let figures = figures(comparison, &experiments);
    let mut files: Vec<(String, Vec<u8>)> =
        figures.iter().map(|figure| (format!("{}.svg", figure.file), figure.svg().into_bytes())).collect();
    let json = serde_json::to_string_pretty(comparison)
        .map_err(|error| Error::new("JSON", error.to_string(), "values that JSON can hold"))?;
    files.push(("compare.json".into(), format!("{json}\n").into_bytes()));
    files.push(("compare.html".into(), page::page(comparison, &figures).into_bytes()));
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
    if let Some(worst) = worst_order(comparison) {
        // Writing to a String cannot fail.
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

/// The tables that have rows, with their titles.
fn sections(comparison: &Comparison) -> impl Iterator<Item = (&'static str, &[Difference])> {
    [
        ("Wear: a later stage against an earlier one", comparison.wear.as_slice()),
        ("Load: loaded against unloaded", &comparison.load),
        ("Against the first", &comparison.against_first),
    ]
    .into_iter()
    .filter(|(_, differences)| !differences.is_empty())
}

fn passed(first: Option<f64>) -> String {
    first.map_or_else(|| "-".into(), |frequency| format!("{frequency:.2}"))
}

/// ± half width of the 95 % interval, where the sets are estimated.
fn interval(extreme: &Extreme, decimals: usize) -> String {
    extreme.std_error.map_or_else(String::new, |error| format!("±{:.decimals$}", TWO_SIDED_95 * error))
}

/// Half width of a 95 % interval in standard errors.
const TWO_SIDED_95: f64 = 1.96;

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
        "{beyond} of {} pass {} or {} deg within 0.5-12 Hz, {inner} within 3-5 Hz\n",
        differences.len(),
        LIMITS.magnitude,
        LIMITS.phase_deg
    );
    text
}

fn worst_order(comparison: &Comparison) -> Option<&Difference> {
    comparison.order.iter().max_by(|a, b| a.data_band.phase_deg.max.total_cmp(&b.data_band.phase_deg.max))
}

/// Figure 7 in a sentence; the set it shows, where it is there, and the worst.
fn order_sentence(comparison: &Comparison, worst: &Difference) -> String {
    let shown = comparison.order.iter().find(|pair| pair.from == "ls-early-unloaded");
    let part = |pair: &Difference| {
        let (phase, magnitude) = (&pair.data_band.phase_deg, &pair.data_band.magnitude);
        format!("{} {:.3} deg at {:.2} Hz and {:.1e} deg/deg", pair.from, phase.max, phase.at_hz, magnitude.max)
    };
    let shown = shown.map_or_else(String::new, |pair| format!("{} (figure 7); at most ", part(pair)));
    format!("Second order instead of third: {shown}{}", part(worst))
}

fn count_sentence(statements: &[Statement]) -> String {
    let count = |verdict| statements.iter().filter(|statement| statement.verdict == verdict).count();
    format!(
        "Statements of the report against its own tables: {} agree, {} are contradicted, {} cannot be checked",
        count(Verdict::Agrees),
        count(Verdict::Contradicted),
        count(Verdict::CannotBeChecked)
    )
}
