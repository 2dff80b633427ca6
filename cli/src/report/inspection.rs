//! Inspection of records as text, as JSON and as a page.

use identification::{
    digits::significant,
    inspect::{
        Inspection,
        finding::{Finding, Severity},
        noise::Source,
        values::GREATEST,
    },
    signal::record::Record,
};
use serde_json::{Value, json};

use crate::{
    invocation::Invocation,
    report::{
        head::{FileRow, Head},
        page::{Cell, Page, Tone},
        plot::{Axis, Panel, Plot, Style},
        spectra::{decibels, label},
    },
};

/// Findings on a record as a whole, for which no particular place is shown.
const WHOLE: [&str; 5] = ["level_drift", "clock_rates", "slow_sampling", "fast_time", "held_position"];

/// Seconds shown around the first sample of a finding.
const CLOSE_S: f64 = 1.0;

/// For machines: one object for each record.
#[must_use]
pub fn json(inspections: &[Inspection]) -> Value {
    json!({ "verdict": word(gravest(inspections)), "records": inspections })
}

/// For people at a terminal.
#[must_use]
pub fn text(inspections: &[Inspection]) -> String {
    let mut lines = Vec::new();
    for inspection in inspections {
        lines.push(format!("{}: {}", inspection.name, word(inspection.severity())));
        for finding in &inspection.findings {
            let mark = match finding.severity {
                Severity::Refusal => "REFUSED  ",
                Severity::Warning => "warning  ",
                Severity::Note => "",
            };
            lines.push(format!("  {mark}{}", finding.text()));
        }
        lines.extend(summary(inspection).into_iter().map(|(name, value)| format!("  {name}: {value}")));
    }
    lines.join("\n") + "\n"
}

/// The page.
#[must_use]
pub fn html(records: &[Record], inspections: &[Inspection], invocation: &Invocation) -> String {
    let rows: Vec<_> = inspections
        .iter()
        .map(|inspection| {
            let first = inspection.findings.first().map_or(String::new(), Finding::text);
            let severity = inspection.severity();
            (tone(severity), word(severity).to_owned(), inspection.name.clone(), first, String::new())
        })
        .collect();
    let gravest = gravest(inspections);
    let head = Head {
        title: "Inspection of the records".into(),
        tone: tone(gravest),
        verdict: word(gravest).to_owned(),
        sentence: counts(inspections),
        evidence: String::new(),
        model: "none is needed".into(),
        files: records.iter().map(|record| FileRow::of(record, "inspected")).collect(),
        invocation,
    };
    let mut page = head.page().heading("Verdicts").verdicts(&rows);
    for (record, inspection) in records.iter().zip(inspections) {
        page = one(page, record, inspection);
    }
    page.html()
}

fn tone(severity: Severity) -> Tone {
    match severity {
        Severity::Note => Tone::Good,
        Severity::Warning => Tone::Open,
        Severity::Refusal => Tone::Bad,
    }
}

/// Number of records of each kind, in a sentence.
fn counts(inspections: &[Inspection]) -> String {
    let of = |severity: Severity| {
        let count = inspections.iter().filter(|inspection| inspection.severity() == severity).count();
        (count > 0).then(|| format!("{count} {}", word(severity)))
    };
    let each: Vec<String> = [Severity::Note, Severity::Warning, Severity::Refusal].into_iter().filter_map(of).collect();
    format!("of {} records, {}.", inspections.len(), each.join(", "))
}

fn one(page: Page, record: &Record, inspection: &Inspection) -> Page {
    let cells = |finding: &Finding| {
        let place = finding.time_s.map_or(String::new(), |time| format!("{time:.4}"));
        vec![
            Cell::text(severity_word(finding.severity)),
            Cell::long(finding.sentence.as_str()),
            Cell::number(finding.sample.map_or(String::new(), |sample| sample.to_string())),
            Cell::number(place),
            Cell::long(finding.remedy.as_str()),
        ]
    };
    let findings: Vec<Vec<Cell>> = inspection.findings.iter().map(cells).collect();
    let numbers: Vec<Vec<Cell>> =
        summary(inspection).into_iter().map(|(name, value)| vec![Cell::text(name), Cell::long(value)]).collect();
    page.heading(&inspection.name)
        .table(&["", "finding", "sample", "time, s", "what to do"], &findings)
        .table(&["property", "value"], &numbers)
        .plots(&pictures(record, inspection))
}

fn pictures(record: &Record, inspection: &Inspection) -> Vec<Plot> {
    let (time, unit) = (record.time(), record.unit().name());
    let points = |values: &[f64]| -> Vec<[f64; 2]> { time.iter().zip(values).map(|(t, v)| [*t, *v]).collect() };
    let both = || record.command().iter().chain(record.position()).copied().filter(|value| value.is_finite());
    let over_time = |title: &str, from: f64, to: f64| {
        let panel = Panel::new(Axis::around(unit, both()))
            .line(Style::colour(5), "command", points(record.command()))
            .line(Style::colour(0), "position", points(record.position()))
            .height(220.0);
        Plot::new(title, Axis::linear("time, s", from, to)).panel(panel)
    };
    let (first, last) = (time[0], time[time.len() - 1]);
    let mut plots = vec![over_time("The record", first, last)];
    let graver = inspection
        .findings
        .iter()
        .filter(|finding| finding.severity > Severity::Note && !WHOLE.contains(&finding.kind));
    if let Some(place) = graver.filter_map(|finding| finding.time_s).next() {
        plots.push(over_time(
            "Close to its first finding",
            (place - 0.5 * CLOSE_S).max(first),
            (place + 0.5 * CLOSE_S).min(last),
        ));
    }
    let spectrum = |values: &[f64]| -> Vec<[f64; 2]> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let about: Vec<f64> = values.iter().map(|value| value - mean).collect();
        decibels(&[about], inspection.sampling.interval_s)
    };
    let (command, position) = (spectrum(record.command()), spectrum(record.position()));
    let highest = (4.0 * inspection.excited_band.highest_hz).min(0.5 * inspection.sampling.rate_hz);
    if highest > 0.0 && both().all(|value| value.abs() < GREATEST) {
        let shown = command.iter().chain(&position).filter(|point| point[0] <= highest).map(|point| point[1]);
        let panel = Panel::new(Axis::around(label(unit), shown))
            .line(Style::colour(5), "command", command.clone())
            .line(Style::colour(0), "position", position.clone())
            .height(220.0);
        plots.push(Plot::new("Spectra", Axis::linear("frequency, Hz", 0.0, highest)).panel(panel));
    }
    let loop_panel = Panel::new(Axis::around(format!("position, {unit}"), record.position().iter().copied()))
        .line(Style::colour(0), "", record.command().iter().zip(record.position()).map(|(c, p)| [*c, *p]).collect())
        .height(220.0);
    let command = Axis::around(format!("command, {unit}"), record.command().iter().copied());
    plots.push(Plot::new("Position against command", command).panel(loop_panel));
    plots
}

/// Properties in words.
fn summary(inspection: &Inspection) -> Vec<(&'static str, String)> {
    let unit = &inspection.unit;
    let band = &inspection.excited_band;
    let mut rows = vec![
        (
            "excited band",
            format!("{:.4} to {:.4} Hz hold 99 % of the command's power", band.lowest_hz, band.highest_hz),
        ),
        ("follows", format!("{:.2} % of the position, by a flexible linear model", 100.0 * inspection.following_share)),
        ("gain", format!("{:.5}, explained position over command, rms", inspection.gain)),
        ("lag", format!("{:.5} s, correlation {:.4}", inspection.lag_s, inspection.correlation)),
        (
            "noise",
            format!("{} {unit} rms, {}", significant(inspection.noise.rms, 4), source_words(inspection.noise.source)),
        ),
    ];
    if let Some(period) = inspection.period_s {
        rows.push(("period", format!("{period:.5} s")));
    }
    if inspection.quiet_share > 0.0 {
        rows.push(("quiet", format!("{:.1} % of the samples", 100.0 * inspection.quiet_share)));
    }
    for (name, step) in [("step of positions", inspection.position_step), ("step of commands", inspection.command_step)]
    {
        if step > 0.0 {
            rows.push((name, format!("{} {unit}", significant(step, 6))));
        }
    }
    rows
}

/// How the noise was estimated, in words.
fn source_words(source: Source) -> &'static str {
    match source {
        Source::Repeats => "from repeats of the motion",
        Source::Periods => "from the periods of the command",
        Source::Quiet => "from the parts at rest",
        Source::AboveBand => {
            "from the spectrum above the band of the command, assumed white: it may be more in the band, and less with play or friction"
        }
        Source::Assumed => "residual of a flexible linear model: an upper bound",
    }
}

fn gravest(inspections: &[Inspection]) -> Severity {
    inspections.iter().map(Inspection::severity).max().unwrap_or(Severity::Note)
}

fn word(severity: Severity) -> &'static str {
    match severity {
        Severity::Note => "usable",
        Severity::Warning => "usable with care",
        Severity::Refusal => "refused",
    }
}

fn severity_word(severity: Severity) -> &'static str {
    match severity {
        Severity::Note => "note",
        Severity::Warning => "warning",
        Severity::Refusal => "refused",
    }
}
