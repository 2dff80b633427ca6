//! What a search of the structure ends with: an explanation that leaves noise, one that leads on unseen records, or none.
//!
//! Near the given base by likelihood ([`super::search`]); where that is not adequate, on a base that may be anywhere ([`super::wide`]), judged
//! on unseen records ([`super::leave_one_out`]).

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::{
    adequacy::Misfit,
    diagnosis::Lead,
    evidence::{REQUIRED_BIC_LEAD, RIVAL_BIC_RANGE},
    fitted::{Fitted, SearchEffort},
    hypothesis::{Hypothesis, MeasurementTerm},
    leave_one_out::{self, Judgement},
    plain_fit::PlainFit,
    predictable::{ADEQUATE_SHARE, NOISE_SHARE, Predictable, predictable},
    selection::StructureSelection,
    space::Space,
    stages,
    steady_level::is_steady,
    thinned::{Thinning, thinned},
    trace::{APPROXIMATION, Trace},
    wide,
};
use crate::{
    inspect::deviation,
    signal::record::{Record, rms},
};
use actuator_fmu::{effects::find, parameters::Model};

/// What leaves more than this by plain output error, on unseen samples, leaves no noise by likelihood.
pub const PROMISING_SHARE: f64 = 3.0 * ADEQUATE_SHARE;

/// A lead in BIC of a single effect that makes up for what hold-out records say of it.
const FAR_BETTER_BIC: f64 = 200.0;

/// Share of the deviation of the fitted records' residuals that a lead leaves where it clearly falls.
const CLEAR_FALL: f64 = 0.8;

/// The same of the least fall that a likelihood may confirm: a level of each record, which leads have, is not their effect's.
const LEAST_FALL: f64 = 0.98;

/// Of the mean square that a lead leaves of the check records, what a base alone leaves where what is missing is linear first of all.
const FAR_LESS: f64 = 0.5;

/// Iterations of the refit of a lead.
const LEAD_ITERATIONS: usize = 12;

/// What an explanation is worth.
#[derive(Debug, Clone)]
pub enum Standing {
    /// It leaves noise.
    Adequate,
    /// It takes the largest part of the difference on every unseen record that shows it, and a difference stays.
    Leading {
        /// Beside several bases, in the order in which they are preferred.
        forms: Vec<Fitted>,
        /// Members of its family that come as near.
        alternatives: Vec<String>,
    },
    /// A difference stays that nothing explains.
    Inadequate,
}

/// The outcome of the search.
pub struct Outcome {
    /// The given model.
    pub given: Fitted,
    /// The given model, or that with its base refitted where that is better.
    pub base: Fitted,
    /// Best first.
    pub candidates: Vec<Fitted>,
    /// The selected hypothesis; none where the given model needs no effect.
    pub explanation: Option<Fitted>,
    /// What it is worth.
    pub standing: Standing,
    /// Misfit of the explanation.
    pub misfit: Misfit,
    /// What of the explanation's residual the motion predicts.
    pub predictable: Predictable,
    /// What was judged on unseen records, where no adequate explanation was found near the given base.
    pub judgement: Option<Judgement>,
    /// What shows only in check records.
    pub suspicions: Vec<Lead>,
    /// The search reached its time limit.
    pub was_cut: bool,
}

impl StructureSelection<'_> {
    /// Base, single effects and forward selection near the given base; where that is not adequate, single effects on a base that may be
    /// anywhere, pairs, and at last what leads on unseen records.
    pub fn select(&self) -> Option<Outcome> {
        self.work.begin(stages::BASE);
        let given = self.fit(Hypothesis::default(), self.given)?;
        let free = self.fit(Hypothesis { base_free: true, ..Hypothesis::default() }, self.given)?;
        let base = if free.bic < given.bic { &free } else { &given };
        self.work.begin(stages::SINGLES);
        let first = self.with_one_more_effect(base);
        let mut candidates: Vec<Fitted> = vec![given.clone(), free.clone()];
        candidates.extend(first.iter().cloned());
        self.work.begin(stages::FORWARD);
        let significant = self.first_significant(&first, base);
        let mut explanation = self.select_from_singles(&first, significant, base, &mut candidates);
        if explanation.is_none() && (self.is_significant(&free, &given) || self.base_shift_suffices(&free, &given)?) {
            explanation = Some(free.clone());
        }
        explanation = explanation.map(|found| self.pole_instead_of_lag(found, &mut candidates));
        let mut judgement = None;
        let mut suspicions = Vec::new();
        let mut standing = Standing::Adequate;
        let is_inadequate = !self.is_adequate(explanation.as_ref(), base);
        if is_inadequate {
            standing = Standing::Inadequate;
            let near = explanation.as_ref().unwrap_or(base);
            suspicions = self.suspicions(near);
        }
        if is_inadequate && self.is_over() {
            explanation = None;
        } else if is_inadequate {
            self.work.begin(stages::WIDE);
            let judged = self.judge_wide()?;
            let single = self
                .adequate_shift(&judged, explanation.as_ref(), base)
                .or_else(|| self.adequate_far_from_given(&judged, base, &mut candidates));
            let lead = if single.is_some() { None } else { self.standing_lead(&judged, &given, base) };
            let found = single.or_else(|| {
                let current = explanation.as_ref().unwrap_or(base);
                let hopeless = judged.is_linear() || lead.is_some() || self.is_over();
                if hopeless {
                    return None;
                }
                self.work.begin(stages::PAIRS);
                self.adequate_pair(base, current, &mut candidates)
            });
            if let Some(found) = found {
                standing = Standing::Adequate;
                explanation = Some(found);
            } else if let Some((form, leading)) = lead {
                explanation = Some(form);
                standing = leading;
            } else {
                explanation = None;
            }
            judgement = Some(judged);
        }
        self.work.begin(stages::CONCLUSION);
        candidates.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let last = explanation.as_ref().unwrap_or(base);
        let (misfit, predictable) = (self.misfit(last)?, self.predictable(last)?);
        let base = base.clone();
        Some(Outcome {
            given,
            base,
            candidates,
            explanation,
            standing,
            misfit,
            predictable,
            judgement,
            suspicions,
            was_cut: self.is_over(),
        })
    }

    /// Forward selection from the significant single effect, or from one that is far better on the fitted records: where two effects act, the
    /// base beside one of them is bent, so that records that were not fitted tell nothing about it.
    fn select_from_singles(
        &self,
        first: &[Fitted],
        significant: Option<Fitted>,
        base: &Fitted,
        candidates: &mut Vec<Fitted>,
    ) -> Option<Fitted> {
        let other = significant.as_ref().unwrap_or(base);
        let better = first.first().filter(|single| single.bic + FAR_BETTER_BIC < other.bic);
        let found = better.and_then(|single| self.select_forward(single.clone(), candidates));
        match found {
            Some(found) if self.is_adequate(Some(&found), base) && self.is_significant(&found, base) => Some(found),
            _ => significant.and_then(|single| self.select_forward(single, candidates)),
        }
    }

    /// The outcome of a search on parts of these records: what was found there, refined on the whole records and judged on them.
    pub fn transferred(&self, outcome: Outcome) -> Option<Outcome> {
        let on_whole = |fitted: &Fitted| {
            let there = Fitted::at(fitted.space.clone(), fitted.x.clone(), &self.fit)?;
            Some(Fitted { converged: fitted.converged, ..there })
        };
        let refined = |fitted: &Fitted| {
            let at = on_whole(fitted)?;
            let space = at.space.clone().starting_at(&at.x)?;
            let fine = Fitted::search(space, &self.fit, SearchEffort::Continued);
            Some(fine.filter(|fine| fine.bic <= at.bic).unwrap_or(at))
        };
        // Those that a table shows.
        const KEPT: usize = 14;
        let given = on_whole(&outcome.given)?;
        let base = refined(&outcome.base)?;
        let mut standing = outcome.standing.clone();
        let explanation = match (&outcome.explanation, &outcome.standing) {
            // What gains on parts of the records may not on the whole ones.
            (Some(_), Standing::Leading { forms, .. }) => {
                forms.iter().filter_map(on_whole).find(|form| self.stands(form, &given, &base))
            }
            (Some(found), _) => Some(refined(found)?),
            (None, _) => None,
        };
        if outcome.explanation.is_some() && explanation.is_none() {
            standing = Standing::Inadequate;
        }
        let mut candidates: Vec<Fitted> = outcome.candidates.par_iter().take(KEPT).filter_map(on_whole).collect();
        candidates.extend(explanation.clone());
        candidates.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let last = explanation.as_ref().unwrap_or(&base);
        let (misfit, predictable) = (self.misfit(last)?, self.predictable(last)?);
        Some(Outcome { given, base, candidates, explanation, standing, misfit, predictable, ..outcome })
    }

    /// Whether what was found on parts of these records leaves noise on the whole ones, if it did there.
    pub fn holds(&self, outcome: &Outcome) -> bool {
        !matches!(outcome.standing, Standing::Adequate) || self.is_adequate(outcome.explanation.as_ref(), &outcome.base)
    }

    /// Whether an explanation, or the base without one, leaves noise.
    pub fn is_adequate(&self, explanation: Option<&Fitted>, base: &Fitted) -> bool {
        let current = explanation.unwrap_or(base);
        let most = if explanation.is_some() { ADEQUATE_SHARE } else { NOISE_SHARE };
        !current.space.is_base_at_bound(&current.x)
            && self.misfit(current).is_some_and(|misfit| misfit.is_noise())
            && self.predictable(current).is_some_and(|predictable| predictable.share < most)
            && self.bias_is_steady(current)
    }

    /// Whether a bias of the sensor, if there is one, is the same in the fitted and in the check records.
    fn bias_is_steady(&self, fitted: &Fitted) -> bool {
        let has_bias = fitted.space.terms().any(|term| term == MeasurementTerm::Bias);
        !has_bias
            || fitted.on(&self.check).is_some_and(|there| is_steady(&[(fitted, &self.fit), (&there, &self.check)]))
    }

    /// The lead in the first of its forms that stands, if any does, and its standing.
    fn standing_lead(&self, judged: &Judgement, given: &Fitted, base: &Fitted) -> Option<(Fitted, Standing)> {
        let (lead, alternatives) = judged.lead()?;
        let forms = self.forms_of_lead(&lead.fit)?;
        let form = forms.iter().find(|form| self.stands(form, given, base))?.clone();
        Some((form, Standing::Leading { forms, alternatives }))
    }

    /// Whether a lead gains on the fitted records, leaves no check record with more, and these not with far more than a base without it does.
    fn stands(&self, lead: &Fitted, given: &Fitted, base: &Fitted) -> bool {
        let without = if lead.space.hypothesis.base_free { base } else { given };
        gains(lead, without) && self.grows(lead) == Some(false) && self.is_beaten_by(lead, base) == Some(false)
    }

    /// Whether a base alone leaves far less of the check records than a lead.
    fn is_beaten_by(&self, lead: &Fitted, base: &Fitted) -> Option<bool> {
        let left = |model: &Model| Some(PlainFit::at(self.as_it_is(model), Vec::new(), &self.check)?.mean_square());
        Some(!self.check.is_empty() && left(&base.model)? < FAR_LESS * left(&lead.model)?)
    }

    /// Whether any check record, or those to be fitted together, are left with more than by the given model.
    fn grows(&self, fitted: &Fitted) -> Option<bool> {
        let left = |model: &Model, traces: &[Trace<'_>]| PlainFit::at(self.as_it_is(model), Vec::new(), traces);
        let is_more = |after: f64, before: f64| after > (1.0 + APPROXIMATION) * before;
        let (given, after) = (left(self.given, &self.check)?, left(&fitted.model, &self.check)?);
        let mut checks = after.residuals.iter().zip(&given.residuals);
        let (given_fit, after_fit) = (left(self.given, &self.fit)?, left(&fitted.model, &self.fit)?);
        let fit_grows = is_more(after_fit.mean_square(), given_fit.mean_square());
        Some(fit_grows || checks.any(|(after, before)| is_more(rms(after), rms(before))))
    }

    /// A model without anything free.
    fn as_it_is(&self, model: &Model) -> Space {
        Space::new(Hypothesis::default(), model, &self.given.base, 0.0)
    }

    /// What the motion predicts of a residual, over all records.
    fn predictable(&self, fitted: &Fitted) -> Option<Predictable> {
        let there = fitted.on(&self.check)?;
        let traces: Vec<Trace<'_>> = self.fit.iter().chain(&self.check).cloned().collect();
        let residuals: Vec<Vec<f64>> = fitted.residuals.iter().chain(&there.residuals).cloned().collect();
        Some(predictable(&fitted.model, &residuals, &traces))
    }

    /// The same on the records that it was fitted to.
    pub fn predictable_when_fitted(&self, fitted: &Fitted) -> Predictable {
        predictable(&fitted.model, &fitted.residuals, &self.fit)
    }

    /// Single effects on a wide base, judged record by record.
    fn judge_wide(&self) -> Option<Judgement> {
        let records: Vec<&Record> = self.fit.iter().chain(&self.check).map(|trace| trace.record).collect();
        let records = thinned(&records, self.given.base.omega() / TAU, Thinning::COARSE);
        let coarse = |record| Trace::coarse(record, &self.given.base).part_of(self.work);
        let traces: Vec<Trace<'_>> = records.iter().map(coarse).collect();
        let wide = wide::search(self.given, &traces)?;
        leave_one_out::judge(self.given, &wide, &traces, &self.noise.mean_squares())
    }

    /// The best effects of the wide search fitted by likelihood; the best of them, if it leaves noise.
    fn adequate_far_from_given(
        &self,
        judged: &Judgement,
        base: &Fitted,
        candidates: &mut Vec<Fitted>,
    ) -> Option<Fitted> {
        const FITTED: usize = 3;
        let plausible =
            judged.judged.iter().filter(|judged| judged.beats_linear && wide::implausible(&judged.fit).is_none());
        let mut fitted: Vec<Fitted> = plausible
            .take(FITTED)
            .filter_map(|judged| {
                let (_, [start, _]) = self.lead_on_fitted_records(&judged.fit)?;
                if self.predictable(&start)?.share > PROMISING_SHARE {
                    return Some(start);
                }
                let fine = Fitted::search(start.space.clone().starting_at(&start.x)?, &self.fit, SearchEffort::Full)?;
                Some(if fine.rms() <= start.rms() { fine } else { start })
            })
            .collect();
        fitted.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let best =
            fitted.iter().find(|fitted| self.is_significant(fitted, base) && self.is_adequate(Some(fitted), base));
        // Beside a base that may be anywhere little is left to tell families apart.
        let is_alone = |best: &Fitted| {
            let mut others =
                fitted.iter().filter(|other| other.space.hypothesis.family() != best.space.hypothesis.family());
            others.all(|other| other.bic > best.bic + RIVAL_BIC_RANGE)
        };
        let best = best.filter(|best| is_alone(best)).cloned();
        candidates.extend(fitted);
        best
    }

    /// A pair or triple that leaves noise.
    fn adequate_pair(&self, base: &Fitted, current: &Fitted, candidates: &mut Vec<Fitted>) -> Option<Fitted> {
        let found = self.search_pairs(base, current, candidates)?;
        self.is_adequate(Some(&found), base).then_some(found)
    }

    /// The forms of a lead in the order in which they are preferred: beside a base of its own and beside the given one; beside a base of its own
    /// as the FMU is stepped; and its effect in the given model as it is.
    fn forms_of_lead(&self, lead: &PlainFit) -> Option<Vec<Fitted>> {
        let (own, [first, second]) = self.lead_on_fitted_records(lead)?;
        let stepped = PlainFit::search_from(own.space.clone().without_levels(), &own.x, &self.fit, LEAD_ITERATIONS)?;
        let in_given = self.in_given_model(&own)?;
        let unchanged = PlainFit::at(in_given.clone(), in_given.start(), &self.fit)?;
        Some(vec![first, second, self.by_likelihood(stepped)?, self.by_likelihood(unchanged)?])
    }

    /// A fit of all records refitted to those to be fitted, so that check records stay unseen; and that beside its own base and beside the given
    /// one, the better one of these records first.
    fn lead_on_fitted_records(&self, lead: &PlainFit) -> Option<(PlainFit, [Fitted; 2])> {
        let own = PlainFit::search_from(lead.space.clone(), &lead.x, &self.fit, LEAD_ITERATIONS)?;
        let beside_given = PlainFit::search(self.in_given_model(&own)?, &self.fit, LEAD_ITERATIONS)?;
        // Twice the negative logarithm of the likelihood with a variance in each record, as the FMU is measured: without levels of the
        // records' own. A quiet record counts as much as a loud one.
        let deviance = |model: &Model| {
            let left = PlainFit::at(self.as_it_is(model), Vec::new(), &self.fit)?.mean_squares();
            Some(left.iter().map(|square| square.max(f64::MIN_POSITIVE).ln()).sum::<f64>())
        };
        let is_given_better = deviance(&beside_given.model)? < deviance(&own.model)?;
        let (fitted, beside_given) = (self.by_likelihood(own.clone())?, self.by_likelihood(beside_given)?);
        Some((own, if is_given_better { [beside_given, fitted] } else { [fitted, beside_given] }))
    }

    /// The effect of an explanation in the given model, its numbers free.
    fn in_given_model(&self, lead: &PlainFit) -> Option<Space> {
        let hypothesis = Hypothesis { base_free: false, ..lead.space.hypothesis.clone() };
        let effect = find(wide::effect_of(lead))?;
        let values = lead.model.effects.values_of(effect.name)?;
        let start = Model { effects: self.given.effects.with(effect, values).ok()?, ..self.given.clone() };
        Some(Space::new(hypothesis, &start, &self.given.base, 0.0))
    }

    /// As it is, with the noise of the records.
    fn by_likelihood(&self, fit: PlainFit) -> Option<Fitted> {
        let fitted = Fitted::at(fit.space, fit.x, &self.fit)?;
        Some(Fitted { converged: fit.converged, ..fitted })
    }
}

/// Whether fitted records show a lead at all. One that shows in check records alone is a suspicion. Beside a base of another structure a
/// likelihood may take what is left for noise that it whitens: a clear fall about the level of each record is one whatever the likelihood says.
fn gains(lead: &Fitted, without: &Fitted) -> bool {
    let left = pooled_deviation(&lead.residuals) / pooled_deviation(&without.residuals);
    left < CLEAR_FALL || (left < LEAST_FALL && lead.bic + REQUIRED_BIC_LEAD < without.bic)
}

/// Root mean square of several columns together, each about its own mean.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn pooled_deviation(columns: &[Vec<f64>]) -> f64 {
    let count: usize = columns.iter().map(Vec::len).sum();
    let sum: f64 = columns.iter().map(|column| column.len() as f64 * deviation(column).powi(2)).sum();
    (sum / count.max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::pooled_deviation;

    #[test]
    fn a_level_of_each_record_is_no_deviation() {
        let about = |level: f64| [1.0, -1.0, 1.0, -1.0].map(|value| value + level).to_vec();
        assert!((pooled_deviation(&[about(3.0), about(-7.0)]) - 1.0).abs() < 1e-12);
        // Longer records count for more.
        assert!((pooled_deviation(&[about(5.0), vec![2.0; 12]]) - 0.5).abs() < 1e-12);
    }
}
