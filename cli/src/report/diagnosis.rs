//! A diagnosis as a page, as JSON and as text.

mod charts;
pub mod files;

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Value, json};

use crate::{
    gap::Gap,
    report::page::{Cell, Page, Tone},
    workflow::account::Account,
};
use actuator_fmu::parameters::Base;
use identification::{
    diagnose::{Candidate, Detectable, Diagnosis, Finding, Parts, REQUIRED_BIC_LEAD, RIVAL_BIC_RANGE, Verdict},
    digits::{significant, with_unit},
    signal::record::Record,
};

#[derive(Serialize)]
struct GapJson<'a> {
    before: &'a Gap,
    after: &'a Gap,
    noise_rms: f64,
    closed: f64,
    parts: Parts,
}

impl Account {
    fn gaps(&self) -> GapJson<'_> {
        GapJson {
            before: &self.before.gap,
            after: &self.after.gap,
            noise_rms: self.diagnosis.noise.rms,
            closed: self.closed(),
            parts: self.diagnosis.parts,
        }
    }

    fn unit(&self) -> &'static str {
        self.fit[0].unit().name()
    }

    /// Everything for machines.
    #[must_use]
    pub fn json(&self) -> Value {
        let diagnosis = &self.diagnosis;
        let mut json = json!({
            "verdict": diagnosis.verdict,
            "sentence": self.sentence(),
            "effects": diagnosis.findings.iter().map(finding).collect::<Vec<Value>>(),
            "where": self.locations,
            "gap": self.gaps(),
            "unit": self.unit(),
            "noise": diagnosis.noise,
            "candidates": diagnosis.candidates,
            "leads": diagnosis.leads,
            "detectable": diagnosis.detectable,
            "reproduce": { "version": env!("CARGO_PKG_VERSION"), "command": self.command },
            "predictable": diagnosis.predictable,
            "misfit": { "share": diagnosis.misfit.share, "f": diagnosis.misfit.f, "critical": diagnosis.misfit.critical },
            "carriers": diagnosis.carriers,
            "base": base(diagnosis),
            "records": self.records(),
            "notes": self.notes,
            "warnings": self.warnings,
        });
        if let Some(test) = &self.next_test {
            json["next_test"] = json!({ "sentence": test.sentence, "command": "next_test.csv" });
        }
        json
    }

    fn records(&self) -> Vec<Value> {
        let all =
            self.fit.iter().map(|record| (record, "fit")).chain(self.check.iter().map(|record| (record, "check")));
        all.enumerate()
            .map(|(index, (record, role))| {
                let (start, settling) = self.diagnosis.starts[index];
                let free: serde_json::Map<String, Value> = self.diagnosis.record_terms[index]
                    .iter()
                    .map(|(name, value)| ((*name).to_owned(), json!(value)))
                    .collect();
                json!({
                    "name": name(record), "source": record.source(), "role": role, "sha256": record.sha256(), "samples": record.len(),
                    "initial_position": start, "samples_not_counted": settling, "own_values": free,
                    "warnings": self.warnings.iter().filter(|warning| warning.starts_with(&file(record))).collect::<Vec<_>>(),
                })
            })
            .collect()
    }

    /// The verdict in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Diagnosis { verdict, findings, noise, .. } = &self.diagnosis;
        let (before, after) = (&self.before.gap, &self.after.gap);
        let (unit, noise) = (self.unit(), significant(noise.rms, 3));
        let names: Vec<String> = findings.iter().map(spoken).collect();
        let names = names.join(" and ");
        let shrunk = format!(
            "the gap on check records goes from {} to {} rms, with noise of {noise}",
            significant(before.check_rms, 3),
            with_unit(after.check_rms, 3, unit)
        );
        match verdict {
            Verdict::NothingMissing => {
                format!(
                    "Nothing is missing: what the model leaves, {} rms, is noise.",
                    significant(before.check_rms, 3)
                )
            }
            Verdict::Named => format!("Missing: {names}; with it {shrunk}."),
            Verdict::Leading => {
                let others: Vec<&str> =
                    findings.iter().flat_map(|finding| finding.alternatives.iter().map(String::as_str)).collect();
                let family = findings.first().map_or("", |finding| finding.family);
                let names = match others.as_slice() {
                    [] => names,
                    _ => format!("{names} (or another of the family {family}: {})", others.join(", ")),
                };
                format!(
                    "A gap of {} rms stays on check records, with noise of {noise}; the largest part of what the model leaves, {} rms, is taken by {names}.",
                    with_unit(after.check_rms, 3, unit),
                    significant(before.check_rms, 3)
                )
            }
            Verdict::Ambiguous => {
                let mut others: Vec<&str> =
                    findings.iter().flat_map(|finding| finding.alternatives.iter().map(String::as_str)).collect();
                others.dedup();
                format!("Missing: {names}, or as likely {}; {shrunk}.", others.join(", "))
            }
            Verdict::Unexplained => format!(
                "Unexplained: a gap of {} rms on check records, with noise of {noise}, that no effect of the chain closes.",
                with_unit(before.check_rms, 3, unit)
            ),
        }
    }

    /// For people at a terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let diagnosis = &self.diagnosis;
        let mut lines = vec![self.sentence()];
        for finding in &diagnosis.findings {
            let parameters: Vec<String> = finding
                .parameters
                .iter()
                .map(|parameter| {
                    let error =
                        parameter.std_error.map_or(String::new(), |error| format!(" +- {}", significant(error, 2)));
                    let unit = if parameter.unit == "1" { String::new() } else { format!(" {}", parameter.unit) };
                    format!("{} {}{error}{unit}", parameter.name, significant(parameter.value, 5))
                })
                .collect();
            lines.push(format!(
                "  {} ({}): {}; evidence {:.0} (BIC)",
                finding.name,
                finding.family,
                parameters.join(", "),
                finding.delta_bic
            ));
        }
        lines.extend(self.locations.iter().take(3).map(|location| format!("where: {}", location.sentence)));
        lines.extend(self.diagnosis.carriers.iter().take(3).map(|carrier| format!("carried by: {}", carrier.sentence)));
        let (before, after) = (&self.before.gap, &self.after.gap);
        lines.push(format!(
            "gap on the FMUs: fitted {} -> {}, check {} -> {}; {:.1} % closed",
            significant(before.fit_rms, 4),
            significant(after.fit_rms, 4),
            significant(before.check_rms, 4),
            with_unit(after.check_rms, 4, self.unit()),
            100.0 * self.closed()
        ));
        lines.extend(diagnosis.leads.iter().take(2).map(|lead| {
            format!("lead: {} takes {:.0} % of the excess; not named: {}", lead.name, 100.0 * lead.share, lead.why_not)
        }));
        lines.extend(self.next_test.as_ref().map(|test| format!("next: {}", test.sentence)));
        lines.extend(self.warnings.iter().map(|warning| format!("warning: {warning}")));
        lines.extend(self.notes.iter().map(|note| format!("note: {note}")));
        lines.join("\n") + "\n"
    }

    /// The page.
    #[must_use]
    pub fn html(&self) -> String {
        let diagnosis = &self.diagnosis;
        let tone = match diagnosis.verdict {
            Verdict::NothingMissing | Verdict::Named => Tone::Good,
            Verdict::Ambiguous | Verdict::Leading => Tone::Open,
            Verdict::Unexplained => Tone::Bad,
        };
        let evidence = match diagnosis.findings.as_slice() {
            [] => String::new(),
            findings => {
                let each = findings.iter().map(|finding| format!("{} {:.0}", finding.name, finding.delta_bic));
                format!("Evidence (BIC lead): {}.", each.collect::<Vec<String>>().join(", "))
            }
        };
        let records = format!("{} fitted and {} check records", self.fit.len(), self.check.len());
        let mut page = Page::new("What is missing in the model").verdicts(&[(
            tone,
            words(diagnosis.verdict).to_owned(),
            self.sentence(),
            evidence,
            records,
        )]);
        page = self.parameters(page);
        page = self.shrinking(page);
        page = self.places(page);
        page = self.evidence(page);
        page = self.what_would_change(page);
        page = self.record_list(page);
        page.html()
    }

    /// Which records, and what they were for.
    fn record_list(&self, page: Page) -> Page {
        let row = |record: &Record, role: &str| {
            vec![
                Cell::text(name(record)),
                Cell::text(role),
                Cell::number(record.len().to_string()),
                Cell::number(significant(record.duration_s(), 5)),
                Cell::text(record.sha256()),
            ]
        };
        let fitted = self.fit.iter().map(|record| row(record, "fitted"));
        let rows: Vec<Vec<Cell>> = fitted.chain(self.check.iter().map(|record| row(record, "check"))).collect();
        page.heading("Records").table(&["record", "role", "samples", "duration, s", "SHA-256"], &rows)
    }

    fn parameters(&self, page: Page) -> Page {
        let row = |what: &str, name: &str, value: f64, error: Option<f64>, unit: &str, bound: bool| {
            vec![
                Cell::text(what),
                Cell::text(name),
                Cell::number(significant(value, 6)),
                Cell::number(error.filter(|error| *error > 0.0).map_or("-".into(), |error| format!("{error:.1e}"))),
                Cell::text(unit),
                Cell::text(if bound { "at its bound" } else { "" }),
            ]
        };
        let named = self.diagnosis.findings.iter().flat_map(|finding| {
            finding.parameters.iter().map(|parameter| {
                row(
                    finding.name,
                    parameter.name,
                    parameter.value,
                    parameter.std_error,
                    parameter.unit,
                    parameter.at_bound,
                )
            })
        });
        let after = &self.diagnosis.after;
        let values = after.base.values();
        let base = Base::PARAMETERS.iter().zip(values).zip(after.std_errors).map(|((parameter, value), error)| {
            row("base", parameter.name, value, error, after.unit().derived(parameter.unit), false)
        });
        let rows: Vec<Vec<Cell>> = named.chain(base).collect();
        page.heading("The model")
            .table(&["effect", "parameter", "value", "standard error", "unit", ""], &rows)
            .remark("model.toml holds these numbers, model.fmu starts with them.")
    }

    fn shrinking(&self, page: Page) -> Page {
        let row = |name: &str, of: &dyn Fn(&Gap) -> Option<f64>| {
            let cell = |gap: &Gap| Cell::number(of(gap).map_or("-".into(), |value| significant(value, 4)));
            vec![Cell::text(name), cell(&self.before.gap), cell(&self.after.gap)]
        };
        let unit = self.unit();
        let rows = vec![
            row(&format!("fitted records, {unit} rms"), &|gap| Some(gap.fit_rms)),
            row(&format!("check records, {unit} rms"), &|gap| Some(gap.check_rms)),
            row("greatest magnitude difference", &|gap| gap.magnitude_max),
            row("greatest phase difference, deg", &|gap| gap.phase_max_deg),
        ];
        let noise = with_unit(self.diagnosis.noise.rms, 4, unit);
        let page = page
            .heading("Gap before and after")
            .paragraph(&format!(
                "Measured on the two packaged FMUs, stepped through an importer. Noise: {noise} rms. Closed on the check records: {:.1} %.",
                100.0 * self.closed()
            ))
            .table(&["gap", "before", "after"], &rows);
        let figures = charts::gap(self);
        let shown = figures.iter().map(|(caption, remark, plot)| (caption.as_str(), remark.as_str(), plot));
        page.figures(shown)
    }

    fn places(&self, page: Page) -> Page {
        let mut page = page.heading("Where the gap was");
        if self.locations.is_empty() {
            return page.paragraph("It is spread as chance would spread it.");
        }
        for location in self.locations.iter().take(3) {
            page = page.paragraph(&format!("{}.", location.sentence));
        }
        let plots: Vec<_> = self.locations.iter().take(6).map(charts::location).collect();
        page.plots(&plots)
            .remark("Density of the squared gap over that of the record along each axis; 1 is as chance has it.")
    }

    fn evidence(&self, page: Page) -> Page {
        // The rest is far behind.
        const SHOWN: usize = 14;
        let row = |candidate: &Candidate| {
            vec![
                Cell::text(&candidate.name),
                Cell::text(candidate.family),
                Cell::number(format!("{:.1}", candidate.delta_bic)),
                Cell::number(significant(candidate.fit_rms, 4)),
                Cell::number(significant(candidate.check_rms, 4)),
            ]
        };
        let rows: Vec<Vec<Cell>> = self.diagnosis.candidates.iter().take(SHOWN).map(row).collect();
        page.heading("Candidates")
            .table(&["added to the model", "family", "BIC behind", "fitted, rms", "check, rms"], &rows)
            .remark(
                "Every effect of the chain was tried with the base free; those that a first look left far behind are not listed. \
                 parameter_shift: the base refitted, nothing added. none: the model as given.",
            )
    }

    fn what_would_change(&self, page: Page) -> Page {
        let diagnosis = &self.diagnosis;
        let mut page = page.heading("What would change this");
        page = page.paragraph(&match diagnosis.verdict {
            Verdict::NothingMissing => format!(
                "An effect that leads by more than {REQUIRED_BIC_LEAD} in BIC on these records and gains on records it was not fitted to; larger motions or less noise would show weaker ones."
            ),
            Verdict::Named => format!(
                "Another explanation within {RIVAL_BIC_RANGE} in BIC, or records on which the named one does not gain."
            ),
            Verdict::Ambiguous => "A record on which the alternatives differ.".to_owned(),
            Verdict::Leading => "A model of what stays, or records on which the lead does not gain.".to_owned(),
            Verdict::Unexplained => "A record of the signal that carries the gap, or an effect that the chain does not have.".to_owned(),
        });
        if let Some(test) = &self.next_test {
            page = page.paragraph(&format!("Next: {} (next_test.csv).", test.sentence));
        }
        page = self.leads(page);
        for carrier in &diagnosis.carriers {
            page = page.paragraph(&format!("{}.", carrier.sentence));
        }
        for warning in &self.warnings {
            page = page.remark(&format!("Warning: {warning}."));
        }
        for note in &self.notes {
            page = page.remark(&format!("{note}."));
        }
        page
    }
}

impl Account {
    /// What takes part of the gap and is not named, and what would have been seen.
    fn leads(&self, mut page: Page) -> Page {
        let diagnosis = &self.diagnosis;
        let numbers = |parameters: &BTreeMap<&'static str, f64>| -> String {
            let each = parameters.iter().map(|(name, value)| format!("{name} {}", significant(*value, 4)));
            each.collect::<Vec<String>>().join(", ")
        };
        if !diagnosis.leads.is_empty() {
            let rows: Vec<Vec<Cell>> = diagnosis
                .leads
                .iter()
                .map(|lead| {
                    vec![
                        Cell::text(lead.name),
                        Cell::text(lead.family),
                        Cell::text(numbers(&lead.parameters)),
                        Cell::number(format!("{:.0} %", 100.0 * lead.share)),
                        Cell::text(&lead.why_not),
                    ]
                })
                .collect();
            page = page
                .heading("Leads")
                .table(&["effect", "family", "numbers", "takes of the excess", "why it is not named"], &rows)
                .remark("Fitted to all records but one and judged on that one; the excess is what the base alone leaves above the noise.");
        }
        if !diagnosis.detectable.is_empty() {
            let row = |effect: &Detectable| {
                let value = Cell::number(significant(effect.value, 3));
                vec![Cell::text(effect.name), Cell::text(effect.parameter), value, Cell::text(effect.unit)]
            };
            let rows: Vec<Vec<Cell>> = diagnosis.detectable.iter().map(row).collect();
            page = page
                .heading("What would have been seen")
                .table(&["effect", "parameter", "from", "unit"], &rows)
                .remark("With these motions and this noise.");
        }
        page
    }
}

/// The file that a record, or a segment of one, was read from.
fn file(record: &Record) -> String {
    let source = record.source().display().to_string();
    source.split(", segment ").next().unwrap_or_default().to_owned()
}

/// A record without its folder.
fn name(record: &Record) -> String {
    let source = record.source();
    source.file_name().map_or_else(|| source.display().to_string(), |name| name.to_string_lossy().into_owned())
}

/// A verdict in words.
pub(super) fn words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NothingMissing => "nothing missing",
        Verdict::Named => "named",
        Verdict::Leading => "leading",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Unexplained => "unexplained",
    }
}

fn spoken(finding: &Finding) -> String {
    effect(finding.name, finding.parameters.iter().map(|parameter| (parameter.name, parameter.value, parameter.unit)))
}

/// An effect with its parameters: name, value, unit.
pub(super) fn effect<'a>(name: &str, parameters: impl Iterator<Item = (&'a str, f64, &'a str)>) -> String {
    let parameters: Vec<String> =
        parameters.map(|(name, value, unit)| format!("{name} {}", with_unit(value, 4, unit))).collect();
    format!("{name} ({})", parameters.join(", "))
}

fn finding(finding: &Finding) -> Value {
    let parameters: serde_json::Map<String, Value> =
        finding.parameters.iter().map(|parameter| (parameter.name.to_owned(), json!(parameter))).collect();
    json!({
        "name": finding.name, "family": finding.family, "parameters": parameters,
        "delta_bic": finding.delta_bic, "alternatives": finding.alternatives,
    })
}

fn base(diagnosis: &Diagnosis) -> Value {
    let of = |model: &actuator_fmu::parameters::Model| -> serde_json::Map<String, Value> {
        let values = Base::PARAMETERS.iter().zip(model.base.values());
        values.map(|(parameter, value)| (parameter.name.to_owned(), json!(value))).collect()
    };
    json!({ "before": of(&diagnosis.before), "after": of(&diagnosis.after) })
}
