//! The page of a diagnosis.

use super::{
    charts, dependence,
    phrases::{acts_or_did, before, is_acting, is_met, percent, plain, tone, words},
};
use crate::{
    gap::Gap,
    report::{
        head::{FileRow, Head},
        page::{Cell, Page},
    },
    workflow::account::{Account, Origin},
};
use actuator_fmu::parameters::{Base, Order};
use identification::{
    diagnose::{Candidate, Detectable, Lead, REQUIRED_BIC_LEAD, RIVAL_BIC_RANGE, Verdict},
    digits::{significant, with_unit},
    signal::record::Record,
};

impl Account {
    /// The page.
    #[must_use]
    pub fn html(&self) -> String {
        let diagnosis = &self.diagnosis;
        let evidence = match diagnosis.findings.as_slice() {
            findings if findings.iter().all(|finding| finding.delta_bic <= 0.0) => String::new(),
            findings => {
                let each = findings.iter().map(|finding| format!("{} {:.0}", finding.name, finding.delta_bic));
                format!("BIC difference: {}.", each.collect::<Vec<String>>().join(", "))
            }
        };
        let Origin { model, invocation } = &self.origin;
        let of_role = |records: &[Record], role: &str| -> Vec<FileRow> {
            records.iter().map(|record| FileRow::of(record, role)).collect()
        };
        let head = Head {
            title: "What is missing in the model".into(),
            tone: tone(diagnosis.verdict),
            verdict: words(diagnosis.verdict).to_owned(),
            sentence: self.sentence(),
            evidence,
            model: model.clone(),
            files: [of_role(&self.fit, "fit"), of_role(&self.check, "check")].concat(),
            invocation,
        };
        let mut page = head.page();
        page = self.parameters(page);
        page = self.shrinking(page);
        page = self.places(page);
        page = self.evidence(page);
        page = self.what_would_change(page);
        page.html()
    }

    fn parameters(&self, page: Page) -> Page {
        let number = |value: f64| if is_acting(value) { significant(value, 6) } else { "none".to_owned() };
        let row = |what: &str, name: &str, value: String, error: Option<f64>, unit: &str, note: &str| {
            vec![
                Cell::text(what),
                Cell::text(if plain(name) == name { name.to_owned() } else { format!("{} ({name})", plain(name)) }),
                Cell::number(value),
                Cell::number(error.filter(|error| *error > 0.0).map_or("-".into(), |error| significant(error, 2))),
                Cell::text(unit),
                Cell::text(note),
            ]
        };
        let named = self.diagnosis.findings.iter().flat_map(|finding| {
            finding.parameters.iter().filter(|parameter| acts_or_did(parameter)).map(|parameter| {
                let is_met = is_met(finding, parameter);
                let found = match (parameter.at_bound, is_met) {
                    (true, _) => "at its bound",
                    (false, false) => "not determined",
                    (false, true) => "",
                };
                let was = before(parameter).map(|was| format!("was {}", number(was)));
                let note: Vec<String> =
                    was.into_iter().chain([found.to_owned()]).filter(|word| !word.is_empty()).collect();
                let error = parameter.std_error.filter(|_| is_met);
                row(finding.name, parameter.name, number(parameter.value), error, parameter.unit, &note.join(", "))
            })
        });
        let after = &self.diagnosis.after;
        let values = after.base.values();
        let base = Base::PARAMETERS.iter().zip(values).zip(after.std_errors);
        let base = base.filter(|((parameter, _), _)| after.order == Order::Third || parameter.name != "p");
        let base = base.map(|((parameter, value), error)| {
            row("base", parameter.name, significant(value, 6), error, after.unit().derived(parameter.unit), "")
        });
        let rows: Vec<Vec<Cell>> = named.chain(base).collect();
        page.heading("The model")
            .table(&["effect", "parameter", "value", "standard error", "unit", ""], &rows)
            .remark("model.toml contains these values, model.fmu starts with them.")
    }

    fn shrinking(&self, page: Page) -> Page {
        let row = |name: &str, of: &dyn Fn(&Gap) -> Option<f64>| {
            let cell = |gap: &Gap| Cell::number(of(gap).map_or("-".into(), |value| significant(value, 4)));
            vec![Cell::text(name), cell(&self.before.gap), cell(&self.after.gap)]
        };
        let unit = self.unit();
        let rows = vec![
            row(&format!("fit records, {unit} rms"), &|gap| Some(gap.fit_rms)),
            row(&format!("check records, {unit} rms"), &|gap| Some(gap.check_rms)),
            row("largest difference in magnitude", &|gap| gap.magnitude_max),
            row("largest difference in phase, deg", &|gap| gap.phase_max_deg),
        ];
        let noise = with_unit(self.diagnosis.noise.rms, 4, unit);
        let page = page
            .heading("Difference before and after")
            .paragraph(&format!(
                "Measured on the two packaged FMUs, stepped through an importer. Noise: {noise} rms. On the check records: {}.",
                self.closed_words()
            ))
            .table(&["difference", "before", "after"], &rows);
        page.captioned(&charts::gap(self)).subheading("Dependence on the motion").captioned(&dependence::pictures(self))
    }

    fn places(&self, page: Page) -> Page {
        let mut page = page.heading("Where the difference lies");
        if self.locations.is_empty() {
            return page.paragraph("It is not concentrated anywhere beyond chance.");
        }
        for location in self.locations.iter().take(3) {
            page = page.paragraph(&format!("{}.", location.sentence));
        }
        let plots: Vec<_> = self.locations.iter().take(6).map(charts::location).collect();
        page.plots(&plots).remark(
            "Density of the squared difference relative to that of the record along each axis; 1: evenly spread.",
        )
    }

    fn evidence(&self, page: Page) -> Page {
        // The rest is far behind.
        const SHOWN: usize = 14;
        let row = |candidate: &Candidate| {
            vec![
                Cell::text(format!("{}{}", candidate.name, if candidate.converged { "" } else { " *" })),
                Cell::text(candidate.family),
                Cell::number(format!("{:.1}", candidate.delta_bic)),
                Cell::number(significant(candidate.fit_rms, 4)),
                Cell::number(significant(candidate.check_rms, 4)),
            ]
        };
        let rows: Vec<Vec<Cell>> = self.diagnosis.candidates.iter().take(SHOWN).map(row).collect();
        let rms_of = |what: &str| format!("{what}, {} rms", self.diagnosis.after.unit());
        page.heading("Candidates")
            .plots(&dependence::evidence(self))
            .table(&["added to the model", "family", "BIC difference", &rms_of("fit"), &rms_of("check")], &rows)
            .remark(
                "Every effect of the chain was tried with a refitted base; those far behind in screening are not listed. parameter_shift: the refitted base \
                 alone. none: the given model. *: search not converged, or made on stretches of long records alone.",
            )
    }

    fn what_would_change(&self, page: Page) -> Page {
        let diagnosis = &self.diagnosis;
        let mut page = page.heading("What would change the verdict");
        page = page.paragraph(&match diagnosis.verdict {
            Verdict::NothingMissing => format!(
                "An effect better by more than {REQUIRED_BIC_LEAD} in BIC on these records that also predicts unseen records better; larger motion or less noise would show weaker ones."
            ),
            Verdict::Named => format!(
                "Another explanation within {RIVAL_BIC_RANGE} in BIC, or records that the named one does not predict better."
            ),
            Verdict::Ambiguous => "A record on which the alternatives differ.".to_owned(),
            Verdict::Leading => "A model of the remaining residual, or records that the lead does not predict better.".to_owned(),
            Verdict::Unexplained => "A record of the signal that causes the difference, or an effect that is not in the chain.".to_owned(),
        });
        if let Some(test) = &self.next_test {
            page = page.paragraph(&format!("Next: {} (next_test.csv).", test.sentence));
        }
        for carrier in &diagnosis.carriers {
            page = page.paragraph(&format!("{}.", carrier.sentence));
        }
        page = self.leads(page);
        for warning in &self.warnings {
            page = page.remark(&format!("Warning: {warning}."));
        }
        for note in &self.notes {
            page = page.remark(&format!("{note}."));
        }
        page
    }

    /// What takes part of the gap and is not named, and what would have been seen.
    fn leads(&self, mut page: Page) -> Page {
        let diagnosis = &self.diagnosis;
        let numbers = |lead: &Lead| -> String {
            let each =
                self.numbers(lead).map(|(name, value, unit)| format!("{} {}", plain(name), with_unit(value, 4, unit)));
            each.collect::<Vec<String>>().join(", ")
        };
        let row = |lead: &Lead| {
            vec![
                Cell::text(lead.name),
                Cell::text(lead.family),
                Cell::text(numbers(lead)),
                Cell::number(lead.share.map_or_else(|| "-".to_owned(), |share| percent(share.clamp(0.0, 1.0)))),
                Cell::text(&lead.why_not),
            ]
        };
        let rows: Vec<Vec<Cell>> = self.stated_leads().map(row).collect();
        if !rows.is_empty() {
            page = page
                .heading("Leads")
                .table(&["effect", "family", "numbers", "excess explained", "why it is not named"], &rows)
                .remark("Fitted to all records but one and judged on that one; excess: that of the base alone over the noise.");
        }
        if !diagnosis.detectable.is_empty() {
            let row = |effect: &Detectable| {
                let value = Cell::number(significant(effect.value, 3));
                vec![Cell::text(effect.name), Cell::text(plain(effect.parameter)), value, Cell::text(effect.unit)]
            };
            let rows: Vec<Vec<Cell>> = diagnosis.detectable.iter().map(row).collect();
            page = page
                .heading("Detectable effects")
                .table(&["effect", "parameter", "from", "unit"], &rows)
                .remark("With this motion and noise.");
        }
        page
    }
}
