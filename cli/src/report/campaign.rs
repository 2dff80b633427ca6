//! A campaign as text and as a page.

mod charts;
mod missing;

use std::fmt::Write as _;

use super::{
    comparison,
    head::{FileRow, Head},
    page::{Cell, Page, Tone},
};
use crate::{
    campaign::{
        Campaign, ConditionOutcome, ConditionResult, FitSummary, RecordOutcome, differences::Differences,
        record::JUDGED_BAND_HZ,
    },
    invocation::Invocation,
};
use identification::{
    compare::{Extreme, LIMITS},
    digits::{significant, with_unit},
};

/// Half width of a 95 % interval in standard errors.
const TWO_SIDED_95: f64 = 1.96;

/// Summary for a terminal.
#[must_use]
pub fn text(campaign: &Campaign) -> String {
    let mut text = format!("{}\n\n", counts(campaign));
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "{:<24} {:>7} {:>20} {:>14} {:>20} {:>20} {:>12} {:>7}",
        "condition", "records", "k", "p, 1/s", "omega, rad/s", "zeta", "rms", "scatter"
    );
    for outcome in &campaign.conditions {
        let name = outcome.condition.to_string();
        match &outcome.result {
            None => {
                let _ = writeln!(text, "{name:<24} {}", outcome.failure.as_deref().unwrap_or("no result"));
            }
            Some(result) => {
                let fit = &result.estimate;
                let _ = writeln!(
                    text,
                    "{name:<24} {:>7} {:>20} {:>14} {:>20} {:>20} {:>12} {:>7}",
                    result.records.len(),
                    value(fit, 0, 4),
                    pole(fit),
                    value(fit, 2, 2),
                    value(fit, 3, 4),
                    with_unit(fit.residual_rms, 3, fit.unit.name()),
                    result.scatter.map_or_else(|| "-".into(), |scatter| format!("{scatter:.2}"))
                );
            }
        }
    }
    for outcome in &campaign.conditions {
        let remarks = outcome.result.as_ref().map_or_else(Vec::new, |result| remarks(&result.estimate));
        if !remarks.is_empty() {
            let _ = writeln!(text, "{}: {}", outcome.condition, remarks.join("; "));
        }
    }
    let _ = writeln!(text, "(± standard error; scatter: of the records' own fits, in their standard errors)\n");
    for (condition, sentence) in missing::sentences(campaign) {
        let _ = writeln!(text, "{condition}: {sentence}");
    }
    text.push_str(&comparison::differences_text(&campaign.comparison));
    if let Some(sentence) = truth(campaign) {
        let _ = writeln!(text, "{sentence}");
    }
    for record in campaign.records.iter().filter(|record| record.failure.is_some()) {
        let _ =
            writeln!(text, "failed: {} (manifest line {})", record.failure.as_deref().unwrap_or_default(), record.line);
    }
    text
}

fn counts(campaign: &Campaign) -> String {
    let failed = campaign.records.iter().filter(|record| record.result.is_none()).count();
    let reused = campaign.records.iter().filter(|record| record.reused).count();
    let conditions = campaign.conditions.iter().filter(|condition| condition.result.is_some()).count();
    format!(
        "{}: {} records under {} conditions; {failed} failed, {reused} taken over from an earlier run; {conditions} with a model",
        campaign.name,
        campaign.records.len(),
        campaign.conditions.len()
    )
}

fn value(fit: &FitSummary, index: usize, decimals: usize) -> String {
    match fit.std_errors[index] {
        Some(error) => format!("{:.decimals$} ± {error:.decimals$}", fit.values[index]),
        None => format!("{:.decimals$}", fit.values[index]),
    }
}

/// p, or its bound if only that is known.
fn pole(fit: &FitSummary) -> String {
    match (fit.pole_above, fit.order) {
        (Some(bound), _) => format!("above {bound:.0}"),
        (None, 3) => value(fit, 1, 0),
        (None, _) => "not identified".into(),
    }
}

/// Notes on the numbers. The uncertainty of p is given in place of p.
fn remarks(fit: &FitSummary) -> Vec<String> {
    let mut remarks = Vec::new();
    if fit.delay_s > 0.0 {
        remarks.push(format!("delay {:.2} ms", 1e3 * fit.delay_s));
    }
    if !fit.converged {
        remarks.push(fit.ending.clone());
    }
    if !fit.at_bound.is_empty() {
        remarks.push(format!("at a bound: {}", fit.at_bound.join(", ")));
    }
    remarks.extend(fit.not_identifiable.iter().filter(|text| !text.starts_with("p:")).cloned());
    remarks
}

fn truth(campaign: &Campaign) -> Option<String> {
    let worst = |name: &str| {
        let own = campaign.truth.iter().filter(|deviation| deviation.parameter == name);
        100.0 * own.map(|deviation| deviation.relative.abs()).fold(0.0, f64::max)
    };
    let scaled: Vec<f64> = campaign.truth.iter().filter_map(|deviation| deviation.in_std_errors).collect();
    let inside = scaled.iter().filter(|deviation| deviation.abs() <= TWO_SIDED_95).count();
    (!campaign.truth.is_empty()).then(|| {
        format!(
            "Against the truth: k within {:.2} %, omega within {:.2} %, zeta within {:.2} %; {inside} of {} inside their 95 % intervals",
            worst("k"),
            worst("omega"),
            worst("zeta"),
            scaled.len()
        )
    })
}

/// The page. `differences` are those before and after the diagnoses of the conditions, in their order.
#[must_use]
pub fn html(campaign: &Campaign, differences: &[Option<Differences>], invocation: &Invocation) -> String {
    let (tone, verdict, sentence) = missing::summary(campaign);
    let head = Head {
        title: campaign.name.clone(),
        tone,
        verdict,
        sentence,
        evidence: format!("{}.", counts(campaign)),
        model: "one is fitted for each condition: models/CONDITION.toml".into(),
        files: campaign.records.iter().map(file_row).collect(),
        invocation,
    };
    let mut page = head.page();
    if let Some(sentence) = truth(campaign) {
        page = page.paragraph(&format!("This campaign is generated. {sentence}."));
    }
    page = failures(page, campaign);
    page = missing::section(page, campaign, differences);
    page = conditions(page, campaign);
    page = comparison::differences(page, &campaign.comparison);
    let differences_over_frequency = comparison::difference_plots(&campaign.comparison);
    if !differences_over_frequency.is_empty() {
        page = page.heading("Differences against the limits").plots(&differences_over_frequency);
    }
    page = against_tables(page, campaign);
    page = page
        .heading("Responses and models")
        .remark("Dots: measured, in one colour for each record, where standard errors are below 0.1 and 3 deg. Line: the model of the condition.");
    page = page.plots(&charts::conditions(campaign));
    records(page, campaign).html()
}

/// A record in the list of inputs of the page.
fn file_row(record: &RecordOutcome) -> FileRow {
    let result = record.result.as_ref();
    FileRow {
        name: record.name.clone(),
        role: format!("{} {}", if result.is_some() { "fit" } else { "refused" }, record.condition),
        samples: result.map(|result| result.samples),
        duration_s: result.map(|result| result.duration_s),
        sha256: result.map(|result| result.sha256.clone()),
    }
}

fn failures(page: Page, campaign: &Campaign) -> Page {
    let of_record = |record: &RecordOutcome| {
        let place = format!("line {} of the manifest", record.line);
        Some((Tone::Bad, "refused".to_owned(), record.name.clone(), record.failure.clone()?, place))
    };
    let of_condition = |outcome: &ConditionOutcome| {
        let name = outcome.condition.to_string();
        Some((Tone::Bad, "no model".to_owned(), name, outcome.failure.clone()?, String::new()))
    };
    let records = campaign.records.iter().filter_map(of_record);
    let rows: Vec<_> = records.chain(campaign.conditions.iter().filter_map(of_condition)).collect();
    if rows.is_empty() {
        return page;
    }
    page.heading("Refused").verdicts(&rows)
}

fn conditions(page: Page, campaign: &Campaign) -> Page {
    let results =
        || campaign.conditions.iter().filter_map(|outcome| Some((&outcome.condition, outcome.result.as_ref()?)));
    let unit = shared(results().map(|(_, result)| result.estimate.unit.name()));
    let rms_head = head_with("rms", unit);
    let rows: Vec<Vec<Cell>> =
        results().map(|(condition, result)| condition_row(&condition.to_string(), result, unit.is_some())).collect();
    let heads = [
        "condition",
        "Mach",
        "dynamic pressure, psf",
        "records",
        "how",
        "k",
        "p, 1/s",
        "ω, rad/s",
        "ζ",
        "delay, ms",
        "order",
        &rms_head,
        "scatter",
        "remarks",
    ];
    page.heading("Parameters").table(&heads, &rows).remark(
        "± standard error. p above a bound: a lower limit only. Scatter is Birge's ratio: about 1 where the records of a condition differ as \
         their standard errors predict.",
    )
}

/// The common value, if there is one.
fn shared<'a>(mut units: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    units.next().filter(|first| units.all(|other| other == *first))
}

/// The head of a column, with the unit common to all of its numbers.
fn head_with(name: &str, unit: Option<&str>) -> String {
    unit.map_or_else(|| name.to_owned(), |unit| format!("{name}, {unit}"))
}

/// Three digits, and the unit if the head of the column does not state it.
fn in_column(value: f64, unit: &str, named_above: bool) -> Cell {
    Cell::number(if named_above { significant(value, 3) } else { with_unit(value, 3, unit) })
}

fn condition_row(name: &str, result: &ConditionResult, unit_named: bool) -> Vec<Cell> {
    let fit = &result.estimate;
    let range = |range: Option<[f64; 2]>| match range {
        None => "-".into(),
        Some([least, greatest]) if least == greatest => least.to_string(),
        Some([least, greatest]) => format!("{least} to {greatest}"),
    };
    vec![
        Cell::text(name),
        Cell::number(range(result.mach)),
        Cell::number(range(result.dynamic_pressure_psf)),
        Cell::number(result.records.len().to_string()),
        Cell::text(result.how.word()),
        Cell::number(value(fit, 0, 4)),
        Cell::number(pole(fit)),
        Cell::number(value(fit, 2, 2)),
        Cell::number(value(fit, 3, 4)),
        Cell::number(if fit.delay_s > 0.0 { format!("{:.2}", 1e3 * fit.delay_s) } else { "-".into() }),
        Cell::number(fit.order.to_string()),
        in_column(fit.residual_rms, fit.unit.name(), unit_named),
        Cell::judged(
            result.scatter.map_or_else(|| "-".into(), |scatter| format!("{scatter:.2}")),
            result.scatter.is_some_and(|scatter| scatter > MUCH_SCATTER),
        ),
        Cell::long(remarks(fit).join("; ")),
    ]
}

/// Records that differ by twice their standard errors are not from one actuator, or the model is wrong.
const MUCH_SCATTER: f64 = 2.0;

fn extreme(extreme: &Extreme, decimals: usize) -> Cell {
    let error = extreme.std_error.map_or_else(String::new, |error| format!(" ± {:.decimals$}", TWO_SIDED_95 * error));
    Cell::judged(format!("{:.decimals$}{error}", extreme.max), extreme.first_passed_hz.is_some())
}

fn against_tables(page: Page, campaign: &Campaign) -> Page {
    let rows: Vec<Vec<Cell>> = campaign
        .conditions
        .iter()
        .filter_map(|outcome| {
            let difference = outcome.result.as_ref()?.against_table.as_ref()?;
            Some(vec![
                Cell::text(outcome.condition.to_string()),
                extreme(&difference.data_band.magnitude, 4),
                extreme(&difference.data_band.phase_deg, 2),
                extreme(&difference.aeroelastic_band.magnitude, 4),
                extreme(&difference.aeroelastic_band.phase_deg, 2),
            ])
        })
        .collect();
    if rows.is_empty() {
        return page;
    }
    let magnitude = format!("|\u{2060}Δ\u{a0}magnitude|, {}", campaign.comparison.gain_unit());
    page.heading("Against tables 1 and 2 of the report")
        .table(
            &[
                "condition",
                &magnitude,
                "|\u{2060}Δ\u{a0}phase|, deg",
                &format!("3-5 Hz: {magnitude}"),
                "3-5 Hz: |\u{2060}Δ\u{a0}phase|, deg",
            ],
            &rows,
        )
        .remark("± half width of the 95 % interval.")
}

fn records(page: Page, campaign: &Campaign) -> Page {
    let [from, to] = JUDGED_BAND_HZ;
    let difference_heads = [("magnitude", String::new()), ("phase", ", deg".to_owned())]
        .map(|(what, unit)| format!("{from}-{to} Hz: |\u{2060}Δ\u{a0}{what}|{unit}"));
    let results = campaign.records.iter().filter_map(|record| record.result.as_ref());
    let unit = shared(results.map(|result| result.unit.as_str()));
    let rms_head = head_with("rms", unit);
    let rows: Vec<Vec<Cell>> = campaign
        .records
        .iter()
        .filter_map(|record| {
            let result = record.result.as_ref()?;
            let number = |value: Option<f64>| Cell::number(value.map_or_else(|| "-".into(), |value| value.to_string()));
            let gap = |index: usize, limit: f64, decimals: usize| match result.gap {
                None => Cell::number("-"),
                Some(gap) => Cell::judged(format!("{:.decimals$}", gap[index]), gap[index] > limit),
            };
            Some(vec![
                Cell::text(&record.name),
                Cell::name(record.condition.to_string()),
                number(record.mach),
                number(record.dynamic_pressure_psf),
                Cell::number(format!("{:.1}", result.duration_s)),
                Cell::number(value(&result.fit, 0, 4)),
                Cell::number(pole(&result.fit)),
                Cell::number(value(&result.fit, 2, 2)),
                Cell::number(value(&result.fit, 3, 4)),
                in_column(result.fit.residual_rms, &result.unit, unit.is_some()),
                gap(0, LIMITS.magnitude, 4),
                gap(1, LIMITS.phase_deg, 2),
            ])
        })
        .collect();
    let heads = [
        "record",
        "condition",
        "Mach",
        "dynamic pressure, psf",
        "duration, s",
        "k",
        "p, 1/s",
        "ω, rad/s",
        "ζ",
        &rms_head,
        &difference_heads[0],
        &difference_heads[1],
    ];
    page.heading("Records, each alone").table(&heads, &rows)
}
