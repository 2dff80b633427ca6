//! A diagnosis as a page, as JSON and as text.

mod charts;
mod dependence;
pub mod files;
mod page;
mod phrases;

use serde::Serialize;
use serde_json::{Value, json};

pub(super) use phrases::{effect, plain, tone, words};
use phrases::{introduction, is_acting, is_met, percent, spoken};

use super::head::file_name;
use crate::{gap::Gap, workflow::account::Account};
use actuator_fmu::{
    effects::find,
    parameters::{Base, Model},
};
use identification::{
    diagnose::{Diagnosis, Finding, Lead, Parts, Verdict, rms_left},
    digits::{significant, with_unit},
    inspect::whole_record,
};

/// Maximum rms of a residual that counts as noise, relative to the noise.
const AS_NOISE: f64 = 1.1;

/// Maximum mean square of the free base without the effect, relative to that of the given model, for the base to explain the largest part.
const MOST_LEFT: f64 = 0.5;

/// Rms of a residual relative to that of the given model from which on it does not shrink: beside a lead, of which a difference remains, and
/// beside a name, whose whole excess over the noise may be less.
const STAYS_BESIDE_LEAD: f64 = 0.95;
const STAYS: f64 = 0.99;

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

    /// How far the excess over the noise was reduced, if there is one.
    fn closed_words(&self) -> String {
        if self.diagnosis.verdict == Verdict::NothingMissing || self.before.gap.check_rms <= self.diagnosis.noise.rms {
            return "no excess over the noise".to_owned();
        }
        format!("excess reduced by {:.1} %", (1000.0 * self.closed()).round() / 10.0 + 0.0)
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
            "searches": diagnosis.searches,
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
                    "name": file_name(record.source()), "source": record.source(), "role": role, "sha256": record.sha256(), "samples": record.len(),
                    "initial_position": start, "samples_not_counted": settling, "own_values": free,
                    "warnings": self.warnings.iter().filter(|warning| warning.starts_with(&whole_record(record.source()))).collect::<Vec<_>>(),
                })
            })
            .collect()
    }

    /// Whether a base of its own takes most of the difference without the effect that leads beside it.
    fn is_largely_of_base(&self) -> bool {
        let Diagnosis { before, after, findings, .. } = &self.diagnosis;
        if findings.iter().any(|finding| find(finding.name).is_none()) {
            return false; // the base is what was found
        }
        let of_findings = findings.iter().filter_map(|finding| find(finding.name));
        let effects = of_findings.fold(after.effects.clone(), |effects, effect| effects.without(effect));
        let without = Model { effects, ..after.clone() };
        let left = |model: &Model| rms_left(model, &self.check);
        let takes_most = |(without, before): (f64, f64)| without.powi(2) < MOST_LEFT * before.powi(2);
        after.base != before.base && left(&without).zip(left(before)).is_some_and(takes_most)
    }

    /// The verdict in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Diagnosis { verdict, findings, noise, .. } = &self.diagnosis;
        let (before, after) = (&self.before.gap, &self.after.gap);
        let (unit, noise) = (self.unit(), significant(noise.rms, 3));
        let names: Vec<String> = findings.iter().map(spoken).collect();
        let names = names.join(" and ");
        let shrunk = self.shrunk();
        match verdict {
            Verdict::NothingMissing => {
                let left = with_unit(before.check_rms, 3, unit);
                if self.diagnosis.leaves_slow_rest {
                    format!(
                        "Nothing that follows the command is missing: the residual, {left} rms, is slow sensor noise or an unrecorded disturbance."
                    )
                } else {
                    format!("Nothing is missing: the residual, {left} rms, is noise.")
                }
            }
            Verdict::Named => format!("{}: {names}; {shrunk}.", introduction(findings)),
            Verdict::Leading => {
                let others: Vec<&str> =
                    findings.iter().flat_map(|finding| finding.alternatives.iter().map(String::as_str)).collect();
                let family = findings.first().map_or("", |finding| finding.family);
                let names = match others.as_slice() {
                    [] => names,
                    _ => format!("{names} (or another of the family {family}: {})", others.join(", ")),
                };
                if let [rounding] = findings.as_slice()
                    && rounding.name == "quantisation"
                {
                    return self.mostly_rounding(rounding);
                }
                let (records, before, after) = if self.shows_in_fit_alone(STAYS_BESIDE_LEAD) {
                    ("fit records, which alone show what is missing", before.fit_rms, after.fit_rms)
                } else {
                    ("check records", before.check_rms, after.check_rms)
                };
                let taken = if self.is_largely_of_base() {
                    format!("another base, and most of the rest by {names}")
                } else {
                    names
                };
                format!(
                    "A residual of {} rms remains on {records} (noise {noise}); {} of the difference, {} rms, is explained by {taken}{}.",
                    with_unit(after, 3, unit),
                    part_taken(before, after),
                    significant(before, 3),
                    self.shown_alone()
                )
            }
            Verdict::Ambiguous => {
                let mut others: Vec<&str> = Vec::new();
                for other in findings.iter().flat_map(|finding| &finding.alternatives) {
                    if !others.contains(&other.as_str()) {
                        others.push(other);
                    }
                }
                format!("{}: {names}, or equally likely {}; {shrunk}.", introduction(findings), others.join(", "))
            }
            Verdict::Unexplained => {
                let suspicion = self.shown_alone();
                // A difference that check records do not show.
                let is_of_check =
                    before.check_rms > self.diagnosis.noise.rms * AS_NOISE || before.fit_rms <= before.check_rms;
                let (records, rms) = if is_of_check { ("check", before.check_rms) } else { ("fit", before.fit_rms) };
                let rms = with_unit(rms, 3, unit);
                format!(
                    "No effect explains the difference of {rms} rms on {records} records (noise {noise}){suspicion}."
                )
            }
        }
    }

    /// How far the residual is reduced. No model reduces rounding.
    fn shrunk(&self) -> String {
        let (before, after) = (&self.before.gap, &self.after.gap);
        let noise = significant(self.diagnosis.noise.rms, 3);
        let (records, before, after) = if self.shows_in_fit_alone(STAYS) {
            ("fit records, which alone show it,", before.fit_rms, after.fit_rms)
        } else {
            ("check records", before.check_rms, after.check_rms)
        };
        let left = with_unit(after, 3, self.unit());
        let is_rounding = matches!(self.diagnosis.findings.as_slice(), [finding] if finding.name == "quantisation");
        if is_rounding && after >= STAYS * before {
            return format!(
                "the residual on {records}, {left} rms, remains (noise {noise}): no model removes rounding"
            );
        }
        format!("the residual on {records} goes from {} to {left} rms (noise {noise})", significant(before, 3))
    }

    /// Whether the residual shrinks on the fit records, and not on the check records: an effect may act in the former alone.
    fn shows_in_fit_alone(&self, stays: f64) -> bool {
        let (before, after) = (&self.before.gap, &self.after.gap);
        after.check_rms >= stays * before.check_rms && after.fit_rms < stays * before.fit_rms
    }

    /// What shows in a check record alone, and how much of it an effect would take there; nothing where there is none.
    fn shown_alone(&self) -> String {
        let mut leads = self.diagnosis.leads.iter();
        let suspicion = leads.find_map(|lead| Some((lead, lead.only_in.as_ref()?)));
        suspicion.map_or_else(String::new, |(lead, record)| {
            // Of the variance; what takes less closes nothing.
            const CLOSES: f64 = 0.9;
            let share = lead.share.map(|share| share.clamp(0.0, 1.0)).filter(|share| *share < CLOSES);
            let lead = self.lead(lead);
            share.map_or_else(
                || format!("; the part seen in {record} alone would be explained by {lead}"),
                |share| {
                    format!("; {:.0} % of the part seen in {record} alone would be explained by {lead}", 100.0 * share)
                },
            )
        })
    }

    /// That most of a difference is rounding, which no model closes.
    fn mostly_rounding(&self, rounding: &Finding) -> String {
        let step = rounding.parameters.first().map_or(0.0, |step| step.value);
        let unit = self.unit();
        format!(
            "Most of the difference of {} rms on check records is rounding, which no model removes: the positions are multiples of {} ({} rms).",
            with_unit(self.before.gap.check_rms, 3, unit),
            with_unit(step, 4, unit),
            with_unit(step / 12.0_f64.sqrt(), 3, unit)
        )
    }

    /// Leads for people: those that take a part in a hundred of the excess at least, where that is known, or show in one record alone.
    pub(super) fn stated_leads(&self) -> impl Iterator<Item = &Lead> {
        let is_stated = |lead: &&Lead| lead.only_in.is_some() || lead.share.is_none_or(|share| share >= 0.01);
        self.diagnosis.leads.iter().filter(is_stated)
    }

    /// A lead with its numbers.
    fn lead(&self, lead: &Lead) -> String {
        effect(lead.name, self.numbers(lead))
    }

    /// Numbers of a lead: name, value, unit.
    pub(super) fn numbers(&self, lead: &Lead) -> impl Iterator<Item = (&'static str, f64, &'static str)> {
        let position = self.diagnosis.before.unit();
        let of_effect = find(lead.name).map_or(&[][..], |effect| effect.parameters).iter();
        let of_effect = of_effect.map(|parameter| (parameter.name, parameter.unit));
        let of_base = Base::PARAMETERS.iter().filter(|_| find(lead.name).is_none());
        let parameters = of_effect.chain(of_base.map(|parameter| (parameter.name, parameter.unit)));
        parameters.filter_map(move |(name, unit)| Some((name, *lead.parameters.get(name)?, position.derived(unit))))
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
                .filter(|parameter| is_acting(parameter.value))
                .map(|parameter| {
                    let is_met = is_met(finding, parameter);
                    let error = parameter.std_error.filter(|_| is_met);
                    let error = error.map_or(String::new(), |error| format!(" +- {}", significant(error, 2)));
                    let unit = if parameter.unit == "1" { String::new() } else { format!(" {}", parameter.unit) };
                    let note = if is_met { "" } else { " (not determined)" };
                    format!("{} {}{error}{unit}{note}", parameter.name, significant(parameter.value, 5))
                })
                .collect();
            let parameters = if parameters.is_empty() { "no longer acts".to_owned() } else { parameters.join(", ") };
            // A lead is judged on unseen records; a likelihood, which takes the remainder for noise, may be against it.
            let evidence = if finding.delta_bic > 0.0 {
                format!("; BIC difference {:.0}", finding.delta_bic)
            } else {
                String::new()
            };
            lines.push(format!("  {} ({}): {parameters}{evidence}", finding.name, finding.family));
        }
        lines.extend(self.locations.iter().take(3).map(|location| format!("where: {}", location.sentence)));
        lines.extend(self.diagnosis.carriers.iter().take(3).map(|carrier| format!("regressor: {}", carrier.sentence)));
        let (before, after) = (&self.before.gap, &self.after.gap);
        lines.push(format!(
            "residual rms on the FMUs: fit {} -> {}, check {} -> {}; {}",
            significant(before.fit_rms, 4),
            significant(after.fit_rms, 4),
            significant(before.check_rms, 4),
            with_unit(after.check_rms, 4, self.unit()),
            self.closed_words()
        ));
        lines.extend(self.stated_leads().take(2).map(|lead| {
            let takes = lead
                .share
                .map_or(String::new(), |share| format!(" explains {} of the excess", percent(share.clamp(0.0, 1.0))));
            format!("lead: {}{takes}; not named: {}", self.lead(lead), lead.why_not)
        }));
        lines.extend(self.next_test.as_ref().map(|test| format!("next: {}", test.sentence)));
        lines.extend(self.warnings.iter().map(|warning| format!("warning: {warning}")));
        lines.extend(self.notes.iter().map(|note| format!("note: {note}")));
        lines.join("\n") + "\n"
    }
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

/// The explained part of a mean square in words, from the rms before and after.
fn part_taken(before: f64, after: f64) -> String {
    let taken = 1.0 - (after / before).powi(2);
    if taken < 0.5 { format!("{:.0} % of the variance", 100.0 * taken) } else { "the largest part".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_takes_less_than_half_is_not_called_the_largest_part() {
        assert_eq!(part_taken(0.335, 0.288), "26 % of the variance");
        assert_eq!(part_taken(0.335, 0.1), "the largest part");
    }
}
