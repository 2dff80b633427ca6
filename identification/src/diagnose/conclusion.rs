//! From the outcome of a search to a diagnosis: verdict, findings, rivals, notes.

use std::collections::BTreeSet;

use super::{
    adequacy,
    diagnosis::{Candidate, Diagnosis, OfRecord, Verdict},
    evidence::is_rival,
    fitted::Fitted,
    hypothesis::Term,
    search::Outcome,
    selection::Study,
    verdict,
};
use actuator_fmu::{effects::find, error::Result, parameters::Model};

impl Study<'_> {
    /// The verdict and all that goes with it. `best` is the explanation, or the given model; `checked` the same and `reference` the base on
    /// the check records.
    pub fn in_words(
        &self,
        outcome: &Outcome,
        best: &Fitted,
        checked: &Fitted,
        reference: &Fitted,
    ) -> Result<Diagnosis> {
        let Outcome { given, base, candidates, explanation, misfit, forgiven } = outcome;
        let is_rival = |other: &&Fitted| is_rival(other, best, given) && self.is_as_good_on_check(other, best);
        let rivals: Vec<Fitted> = match explanation {
            Some(_) => candidates.iter().filter(is_rival).cloned().collect(),
            None => Vec::new(),
        };
        let mut verdict = match (explanation, misfit.is_noise() || *forgiven) {
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
        if let Some(step) = self.quantisation(noise_rms)
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
        if *forgiven {
            notes.push("a smaller gap stays that no effect of the chain explains".to_owned());
        }
        notes.extend(steady_rate(&after));
        let of_records = if named {
            of_records(best).into_iter().chain(of_records(checked)).collect()
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
            candidates: self.table(candidates),
            rivals: rivals.into_iter().filter(|_| is_ambiguous).map(|rival| rival.model).collect(),
            misfit: *misfit,
            carriers: if verdict == Verdict::Unexplained { adequacy::carriers(best, &self.fit) } else { Vec::new() },
            noise_rms,
            of_records,
            starts: self.fit.iter().chain(&self.check).map(|trace| (trace.start, trace.settling)).collect(),
            residuals: base.residuals.iter().chain(&reference.residuals).cloned().collect(),
            notes,
        })
    }

    fn table(&self, candidates: &[Fitted]) -> Vec<Candidate> {
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
    Some(format!("the limit of acceleration allows no steady rate above value / (2 zeta omega) = {rate:.1} deg/s"))
}

/// Values of the terms in each record.
fn of_records(fitted: &Fitted) -> Vec<OfRecord> {
    let each = fitted.factors.iter().map(|factors| {
        let mut values = OfRecord::new();
        for (index, term) in fitted.space.terms().enumerate() {
            let [one, other] = [factors[2 * index], factors[2 * index + 1]];
            match term {
                Term::Bias => values.extend([("sensor_bias.offset", one), ("sensor_bias.drift", other)]),
                Term::Chatter => {
                    values.extend([("chatter.amplitude", one.hypot(other)), ("chatter.phase", other.atan2(one))]);
                }
            }
        }
        values
    });
    each.collect()
}
