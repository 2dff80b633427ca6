//! From the outcome of a search to a diagnosis: verdict, findings, rivals, notes.

use std::collections::BTreeSet;

use super::{
    adequacy,
    diagnosis::{Candidate, Diagnosis, RecordTerms, Verdict},
    evidence::is_rival,
    fitted::Fitted,
    hypothesis::MeasurementTerm,
    search::Outcome,
    selection::StructureSelection,
    verdict,
};
use crate::digits::significant;
use actuator_fmu::{effects::find, error::Result, parameters::Model};

impl StructureSelection<'_> {
    /// The verdict and all that goes with it. `best` is the explanation, or the given model; `checked` the same and `reference` the base on
    /// the check records.
    pub fn conclude(
        &self,
        outcome: &Outcome,
        best: &Fitted,
        checked: &Fitted,
        reference: &Fitted,
    ) -> Result<Diagnosis> {
        let Outcome { given, base, candidates, explanation, misfit, accepted_with_gap } = outcome;
        let is_rival = |other: &&Fitted| is_rival(other, best, given) && self.matches_on_hold_out(other, best);
        let rivals: Vec<Fitted> = match explanation {
            Some(_) => candidates.iter().filter(is_rival).cloned().collect(),
            None => Vec::new(),
        };
        let mut verdict = match (explanation, misfit.is_noise() || *accepted_with_gap) {
            (None, true) => Verdict::NothingMissing,
            (_, false) => Verdict::Unexplained,
            (Some(_), true) if rivals.is_empty() => Verdict::Named,
            (Some(_), true) => Verdict::Ambiguous,
        };
        let named = matches!(verdict, Verdict::Named | Verdict::Ambiguous);
        let noise_rms = adequacy::noise_rms(checked, &self.check);
        let mut findings =
            if named { verdict::findings(best, given, &rivals, candidates, &self.fit) } else { Vec::new() };
        let mut after = if named { best.model.clone() } else { self.given.clone() };
        if let Some(step) = self.significant_quantisation(noise_rms)
            && verdict != Verdict::Unexplained
        {
            findings.push(verdict::quantisation(step, &self.fit));
            if let Some(quantisation) = find("quantisation") {
                after.effects = after.effects.with(quantisation, &[step])?;
            }
            verdict = if verdict == Verdict::NothingMissing { Verdict::Named } else { verdict };
        }
        if !findings.is_empty() {
            verdict::set_errors(&mut after, best, &findings, &self.fit);
        }
        let mut notes = Vec::new();
        if *accepted_with_gap {
            notes.push("a smaller gap stays that no effect of the chain explains".to_owned());
        }
        notes.extend(steady_rate(&after));
        let record_terms = if named {
            record_terms(best).into_iter().chain(record_terms(checked)).collect()
        } else {
            vec![Vec::new(); self.fit.len() + self.check.len()]
        };
        let is_ambiguous = verdict == Verdict::Ambiguous;
        Ok(Diagnosis {
            verdict,
            findings,
            before: self.given.clone(),
            after,
            best: best.model.clone(),
            candidates: self.candidate_table(candidates),
            rivals: rivals.into_iter().filter(|_| is_ambiguous).map(|rival| rival.model).collect(),
            misfit: *misfit,
            carriers: if verdict == Verdict::Unexplained {
                adequacy::explaining_regressors(best, &self.fit)
            } else {
                Vec::new()
            },
            noise_rms,
            record_terms,
            starts: self.fit.iter().chain(&self.check).map(|trace| (trace.start, trace.settling)).collect(),
            residuals: base.residuals.iter().chain(&reference.residuals).cloned().collect(),
            notes,
        })
    }

    fn candidate_table(&self, candidates: &[Fitted]) -> Vec<Candidate> {
        let best = candidates.first().map_or(0.0, |best| best.bic);
        let row = |fitted: &Fitted| Candidate {
            name: fitted.space.hypothesis.name(),
            family: fitted.space.hypothesis.family(),
            delta_bic: fitted.bic - best,
            fit_rms: fitted.rms(),
            check_rms: fitted.on(&self.check).map_or(f64::NAN, |checked| checked.rms()),
        };
        let mut rows: Vec<Candidate> = candidates.iter().map(row).collect();
        let mut seen = BTreeSet::new();
        rows.retain(|row| seen.insert(row.name.clone()));
        rows
    }
}

/// What a limit of acceleration means for the rate: the drive is then as strong as the damping, value = 2ζω rate.
fn steady_rate(model: &Model) -> Option<String> {
    let (_, values) = model.effects.active().find(|(effect, _)| effect.name == "acceleration_limit")?;
    let rate = values[0] / (2.0 * model.base.zeta() * model.base.omega());
    let (rate, unit) = (significant(rate, 4), model.unit().of_rate());
    Some(format!("the limit of acceleration allows no steady rate above value / (2 zeta omega) = {rate} {unit}"))
}

/// Values of the terms in each record.
fn record_terms(fitted: &Fitted) -> Vec<RecordTerms> {
    let each = fitted.factors.iter().map(|factors| {
        let mut values = RecordTerms::new();
        for (index, term) in fitted.space.terms().enumerate() {
            let [one, other] = [factors[2 * index], factors[2 * index + 1]];
            match term {
                MeasurementTerm::Bias => values.extend([("sensor_bias.offset", one), ("sensor_bias.drift", other)]),
                MeasurementTerm::Chatter => {
                    values.extend([("chatter.amplitude", one.hypot(other)), ("chatter.phase", other.atan2(one))]);
                }
            }
        }
        values
    });
    each.collect()
}
