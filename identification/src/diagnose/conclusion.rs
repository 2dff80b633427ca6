//! From the outcome of a search to a diagnosis: verdict, findings, rivals, notes.

use std::collections::BTreeSet;

use super::{
    adequacy,
    as_likely::is_lag_or_base,
    detectable::detectable,
    diagnosis::{Candidate, Diagnosis, Finding, Lead, Parts, RecordTerms, Verdict},
    evidence::is_rival,
    fitted::Fitted,
    held,
    hypothesis::{Hypothesis, MeasurementTerm, PARAMETER_SHIFT, family},
    judgement::Judgement,
    leading_oscillation::CHATTER,
    measured_noise::is_whole,
    notes::{BESIDE_WIDE_BASE, behind, beside_wide_base, coloured, has_same_base, level},
    outcome::{Form, Objections, Outcome, Standing},
    plain_fit::PlainFit,
    predictable::predictable,
    quantisation::QUANTISATION,
    selection::StructureSelection,
    space::Space,
    steady_rate::steady_rate,
    trace::Trace,
    unseen::{self, Judged},
    verdict,
};
use crate::inspect::noise::{Noise, Source};
use actuator_fmu::{
    effects::find,
    error::{Error, Result},
};

impl StructureSelection<'_> {
    /// The diagnosis of an outcome.
    ///
    /// # Errors
    /// A model whose motion diverges on the check records.
    pub fn diagnosis(&self, outcome: &Outcome) -> Result<Diagnosis> {
        let acting = outcome.explanation.as_ref().map(|found| self.without_idle_sides(found, &outcome.standing));
        let best = acting.as_ref().unwrap_or(&outcome.given);
        let on_check = best.on(&self.check).zip(outcome.base.on(&self.check));
        let Some((checked, reference)) = on_check else {
            return Err(Error::new("model", "a diverging motion on the check records", "a stable actuator"));
        };
        let apart = self.record_apart(best, &checked);
        if apart.is_some() && matches!(outcome.standing, Standing::Adequate) {
            let given = &outcome.given;
            let none = Outcome { explanation: None, standing: Standing::Inadequate, ..outcome.clone() };
            return self.conclude(&none, given, &given.on(&self.check).unwrap_or(checked), &reference, apart);
        }
        self.conclude(outcome, best, &checked, &reference, apart)
    }

    /// The verdict and all that goes with it. `best` is the explanation, or the given model; `checked` is `best`, and `reference` the base, on the
    /// check records; `apart` is the note on a record that stands apart.
    fn conclude(
        &self,
        outcome: &Outcome,
        best: &Fitted,
        checked: &Fitted,
        reference: &Fitted,
        apart: Option<String>,
    ) -> Result<Diagnosis> {
        let Outcome { given, base, candidates, explanation, standing, misfit, predictable, judgement, .. } = outcome;
        let is_rival = |other: &&Fitted| {
            is_rival(other, best, given)
                && self.matches_on_hold_out(other, best)
                && !self.starts_contradict(other, best)
        };
        let rivals: Vec<Fitted> = match (explanation, standing) {
            (Some(_), Standing::Adequate) => candidates.iter().filter(is_rival).cloned().collect(),
            _ => Vec::new(),
        };
        let mut verdict = match (explanation, standing) {
            (_, Standing::Inadequate) => Verdict::Unexplained,
            (_, Standing::Leading { .. }) => Verdict::Leading,
            (None, Standing::Adequate) => Verdict::NothingMissing,
            (Some(_), Standing::Adequate) if rivals.is_empty() => Verdict::Named,
            (Some(_), Standing::Adequate) => Verdict::Ambiguous,
        };
        let named = matches!(verdict, Verdict::Named | Verdict::Ambiguous | Verdict::Leading);
        // The measured noise contains a line that leads.
        let is_apart = matches!(standing, Standing::Adequate) || best.space.hypothesis.effects == [CHATTER];
        let noise = self.noise_of_check(checked, is_apart);
        let noise_rms = noise.rms;
        let mut findings =
            if named { verdict::findings(best, given, &rivals, candidates, &self.fit) } else { Vec::new() };
        if let (Standing::Leading { forms }, Some(finding)) = (standing, findings.first_mut()) {
            let leads = |form: &&Form| form.fitted.space.hypothesis.effects.contains(&finding.name);
            let form = forms.iter().find(leads).or_else(|| forms.first().filter(|_| finding.name == PARAMETER_SHIFT));
            finding.alternatives = form.map_or_else(Vec::new, |form| form.alternatives.clone());
            if is_lag_or_base(best) {
                finding.alternatives.extend(self.lags_as_likely(best, candidates));
                finding.alternatives.sort();
                finding.alternatives.dedup();
            }
        }
        let record_terms: Vec<RecordTerms> = record_terms(best).into_iter().chain(record_terms(checked)).collect();
        self.estimate_on_each_record(best, &record_terms, &mut findings);
        let mut after = if named { best.model.clone() } else { self.given.clone() };
        if let Some(step) = self.significant_quantisation(noise_rms)
            && (!matches!(verdict, Verdict::Unexplained | Verdict::Leading)
                || (findings.is_empty() && self.is_mostly_rounding(step)))
        {
            findings.push(verdict::quantisation(step, &self.fit));
            if let Some(quantisation) = find(QUANTISATION) {
                after.effects = after.effects.with(quantisation, &[step])?;
            }
            verdict = match verdict {
                Verdict::NothingMissing => Verdict::Named,
                Verdict::Unexplained => Verdict::Leading,
                other => other,
            };
        }
        if !findings.is_empty() {
            verdict::set_errors(&mut after, best, &findings, &self.fit);
        }
        let mut notes = Vec::new();
        // The values of a finding are stated with it.
        let beside: Vec<&str> = BESIDE_WIDE_BASE
            .into_iter()
            .filter(|effect| !findings.iter().any(|finding| finding.name == *effect))
            .collect();
        if best.space.hypothesis.wide && named && !has_same_base(&after, self.given, &beside) {
            notes.push(beside_wide_base(&after, &beside));
        }
        notes.extend(self.fit.iter().chain(&self.check).filter_map(|trace| level(&after, trace)));
        notes.extend(apart);
        if outcome.was_cut {
            notes.push("the search reached its time limit: this is the best result so far".to_owned());
        }
        let parts = self.parts(noise_rms);
        let is_linear = parts.linear > parts.nonlinear && judgement.as_ref().is_some_and(Judgement::is_linear);
        if verdict == Verdict::Unexplained && is_linear {
            let share = 100.0 * parts.linear;
            notes.push(format!("the larger part of the difference, {share:.0} % of its variance, is linear: the actuator differs from the base in structure, for example by a delay, integral action or a resonance"));
        }
        let slow = coloured(best).filter(|_| matches!(standing, Standing::Adequate));
        let leaves_slow_rest = slow.is_some();
        notes.extend(slow);
        let traces: Vec<Trace<'_>> = self.fit.iter().chain(&self.check).cloned().collect();
        notes.extend(steady_rate(&after, &traces));
        notes.extend(outcome.note.clone().filter(|_| verdict == Verdict::Leading));
        if verdict == Verdict::Leading && self.healthy_share.is_none() {
            let of_lead = |judged: &&Judged| findings.first().is_some_and(|finding| finding.name == judged.effect);
            notes.extend(judgement.iter().flat_map(|judgement| &judgement.judged).find(of_lead).and_then(held::note));
        }
        let record_terms = if named { record_terms } else { vec![RecordTerms::new(); record_terms.len()] };
        let is_ambiguous = verdict == Verdict::Ambiguous;
        let is_rounded = findings.iter().any(|finding| finding.name == QUANTISATION);
        let rounding = if is_rounded { None } else { self.rounding(noise_rms) };
        let judged =
            || rounding.clone().into_iter().chain(self.leads(judgement.as_ref(), &outcome.objections, &findings));
        let leads = {
            let shown = if verdict == Verdict::Unexplained { &outcome.shown[..] } else { &[] };
            let first = || outcome.suspicions.iter().chain(shown);
            let is_said = |lead: &Lead| first().any(|other| other.name == lead.name);
            match verdict {
                Verdict::Unexplained | Verdict::Leading => {
                    first().cloned().chain(judged().filter(|lead| !is_said(lead))).collect()
                }
                _ => Vec::new(),
            }
        };
        Ok(Diagnosis {
            verdict,
            findings,
            before: self.given.clone(),
            after,
            best: best.model.clone(),
            candidates: self.candidate_table(candidates),
            rivals: rivals.into_iter().filter(|_| is_ambiguous).map(|rival| rival.model).collect(),
            misfit: *misfit,
            predictable: *predictable,
            carriers: if verdict == Verdict::Unexplained {
                adequacy::explaining_regressors(best, &self.fit)
            } else {
                Vec::new()
            },
            noise,
            parts,
            leads,
            detectable: if verdict == Verdict::NothingMissing { detectable(base, &self.fit) } else { Vec::new() },
            record_terms,
            starts: self.fit.iter().chain(&self.check).map(|trace| (trace.start, trace.settling)).collect(),
            residuals: base.residuals.iter().chain(&reference.residuals).cloned().collect(),
            leaves_slow_rest,
            notes,
            searches: self.work.searches(),
        })
    }

    /// Noise of the check records: as measured, where the source covers all of it; otherwise the part of the residual that no function of the motion
    /// explains, beside an adequate explanation; otherwise an upper bound.
    fn noise_of_check(&self, checked: &Fitted, adequate: bool) -> Noise {
        let measured = self.noise.together(self.fit.len());
        // Noise over the residual of an explanation, at most: the residual is below the noise only by chance.
        const CHANCE: f64 = 1.1;
        if is_whole(measured.source) && measured.rms < CHANCE * checked.rms() {
            return measured;
        }
        if adequate {
            return Noise { rms: adequacy::noise_rms(checked, &self.check), source: Source::Assumed };
        }
        // The residual is an upper bound as well.
        Noise { rms: measured.rms.min(checked.rms()), ..measured }
    }

    /// Strengths fitted to each record by itself, all else held; for a measurement term its value in each record.
    fn estimate_on_each_record(&self, best: &Fitted, terms: &[RecordTerms], findings: &mut [Finding]) {
        let traces: Vec<Trace<'_>> = self.fit.iter().chain(&self.check).cloned().collect();
        let Some(plain) = PlainFit::at(best.space.clone(), best.x.clone(), &traces) else { return };
        for finding in findings {
            let values = unseen::of_records(&plain, finding.name, &traces);
            for (parameter, values) in finding.parameters.iter_mut().zip(values) {
                let name = format!("{}.{}", finding.name, parameter.name);
                let of_term =
                    |terms: &RecordTerms| terms.iter().find(|(term, _)| *term == name).map(|(_, value)| *value);
                parameter.of_records = terms.iter().map(of_term).collect::<Option<_>>().unwrap_or(values);
            }
        }
    }

    /// The parts of the difference, over all records.
    fn parts(&self, noise_rms: f64) -> Parts {
        let traces: Vec<Trace<'_>> = self.fit.iter().chain(&self.check).cloned().collect();
        let space = Space::new(Hypothesis::default(), self.given, &self.given.base, 0.0);
        let given = PlainFit::at(space, Vec::new(), &traces);
        given.map_or(Parts { linear: 0.0, nonlinear: 0.0, noise: 0.0 }, |given| {
            let found = predictable(self.given, &given.residuals, &traces);
            let noise = (noise_rms / found.rms.max(f64::MIN_POSITIVE)).powi(2).min(1.0);
            let linear = found.linear_share.min(1.0 - noise);
            Parts { linear, nonlinear: 1.0 - linear - noise, noise }
        })
    }

    /// The effects judged on unseen records, without the named ones.
    fn leads(&self, judgement: Option<&Judgement>, objections: &Objections, findings: &[Finding]) -> Vec<Lead> {
        const SHOWN: usize = 4;
        let judged = judgement.map_or(&[][..], |judgement| &judgement.judged);
        let delay = judgement.and_then(|judgement| judgement.delay.as_ref());
        let mut all: Vec<&Judged> = judged.iter().collect();
        if let Some(delay) = delay {
            let comes_after =
                |other: &&Judged| delay.why_not.is_some() && other.remaining_share < delay.remaining_share;
            all.insert(all.iter().take_while(|other| comes_after(other)).count(), delay);
        }
        let no_first = || {
            "it ranks behind another effect, which explains at least as much of unseen records and was rejected"
                .to_owned()
        };
        all.iter()
            .filter(|judged| !findings.iter().any(|finding| finding.name == judged.effect))
            .take(SHOWN)
            .map(|judged| {
                let values = judged.fit.model.effects.values_of(judged.effect).unwrap_or_default();
                let parameters = find(judged.effect).map_or(&[][..], |effect| effect.parameters);
                Lead {
                    name: judged.effect,
                    family: family(judged.effect),
                    share: Some(1.0 - judged.remaining_share),
                    nonlinear_share: judged.nonlinear_share.map(|left| 1.0 - left),
                    check_rms: Some(judged.rms_of(self.fit.len()..)),
                    parameters: parameters.iter().map(|parameter| parameter.name).zip(values.iter().copied()).collect(),
                    only_in: None,
                    why_not: judged.why_not.clone().unwrap_or_else(|| {
                        let reason =
                            || findings.first().map_or_else(no_first, |first| behind(judged, first.name, &all));
                        objections.get(judged.effect).cloned().unwrap_or_else(reason)
                    }),
                }
            })
            .collect()
    }

    fn candidate_table(&self, candidates: &[Fitted]) -> Vec<Candidate> {
        let best = candidates.first().map_or(0.0, |best| best.bic);
        let row = |fitted: &Fitted| Candidate {
            name: fitted.space.hypothesis.name(),
            family: fitted.space.hypothesis.family(),
            delta_bic: fitted.bic - best,
            fit_rms: fitted.rms(),
            check_rms: fitted.on(&self.check).map_or(f64::NAN, |checked| checked.rms()),
            converged: fitted.converged,
        };
        let mut rows: Vec<Candidate> = candidates.iter().map(row).collect();
        let mut seen = BTreeSet::new();
        rows.retain(|row| seen.insert(row.name.clone()));
        rows
    }
}

/// Values of the measurement terms in each record.
fn record_terms(fitted: &Fitted) -> Vec<RecordTerms> {
    let each = fitted.factors.iter().map(|factors| {
        let mut values = RecordTerms::new();
        let of_effects = fitted.space.terms().filter(|term| *term != MeasurementTerm::Level);
        for (index, term) in of_effects.enumerate() {
            let [one, other] = [factors[2 * index], factors[2 * index + 1]];
            match term {
                MeasurementTerm::Level => {}
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

#[cfg(test)]
mod tests {
    use crate::{
        diagnose::{
            Verdict, diagnose,
            three_records::{measured_as, three_records_of},
        },
        signal::record::Record,
    };
    use actuator_fmu::parameters::{Model, table};

    #[test]
    fn a_bias_that_is_named_has_its_value_in_each_record() {
        let given = Model::from_set(&table()[0]);
        let levels = [0.5, 0.4, 0.45];
        let of_level = |(record, level): (&Record, f64)| measured_as(record, |_, position| position + level);
        let records: Vec<Record> = three_records_of(&given, 3.0, 6.0).iter().zip(levels).map(of_level).collect();
        let diagnosis = diagnose(&given, &records[..2], &records[2..], &[], None).unwrap();
        assert_eq!((diagnosis.verdict, diagnosis.findings[0].name), (Verdict::Named, "sensor_bias"));
        let of_records = &diagnosis.findings[0].parameters[0].of_records;
        assert!(of_records.iter().zip(levels).all(|(found, level)| (found - level).abs() < 0.02), "{of_records:?}");
    }
}
