//! Single effects beside a free base, judged on unseen records, and the best of them if it is adequate.

use std::{f64::consts::TAU, slice::from_ref};

use super::{
    evidence::RIVAL_BIC_RANGE,
    fitted::{Fitted, SearchEffort},
    hypothesis::{DELAY, Hypothesis, MeasurementTerm},
    judgement::Judgement,
    late, leave_one_out,
    outcome::{CLOSES_NOTHING, FAR_BETTER_BIC, PROMISING_SHARE},
    plain_fit::PlainFit,
    selection::StructureSelection,
    space::Space,
    thinned::{Thinning, thinned},
    trace::Trace,
    wide,
};
use crate::{
    signal::record::{Record, rms},
    sorting::sort_by_number,
};
use actuator_fmu::parameters::Model;

impl StructureSelection<'_> {
    /// Single effects beside a free base, judged record by record.
    pub fn judge_wide(&self) -> Option<Judgement> {
        let records: Vec<&Record> = self.fit.iter().chain(&self.check).map(|trace| trace.record).collect();
        let records = thinned(&records, self.given.base.omega() / TAU, Thinning::COARSE);
        let coarse = |record| Trace::coarse(record, &self.given.base).part_of(self.work);
        let traces: Vec<Trace<'_>> = records.iter().map(coarse).collect();
        let wide = wide::search(self.given, &traces)?;
        leave_one_out::judge(self.given, &wide, &traces, &self.noise.mean_squares())
    }

    /// Fits the best effects of the wide search by likelihood; returns the best of them if it is adequate.
    pub fn adequate_far_from_given(
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
                let start = self.lead_on_fitted_records(&judged.fit)?.1.into_iter().next()?;
                if self.predictable(&start)?.share > PROMISING_SHARE {
                    return Some(start);
                }
                let fine = Fitted::search(start.space.clone().starting_at(&start.x)?, &self.fit, SearchEffort::Full)?;
                Some(if fine.rms() <= start.rms() { fine } else { start })
            })
            .collect();
        sort_by_number(&mut fitted, |one| one.bic);
        let best =
            fitted.iter().find(|fitted| self.is_significant(fitted, base) && self.is_adequate(Some(fitted), base));
        // Beside a free base little remains that distinguishes families.
        let is_alone = |best: &Fitted| {
            let mut others =
                fitted.iter().filter(|other| other.space.hypothesis.family() != best.space.hypothesis.family());
            others.all(|other| other.bic > best.bic + RIVAL_BIC_RANGE)
        };
        // Where a candidate near the given base is far better in BIC, the residual of this one is not noise.
        let is_behind = |best: &Fitted| candidates.iter().any(|near| near.bic + FAR_BETTER_BIC < best.bic);
        let is_told = |best: &&Fitted| {
            is_alone(best)
                && !is_behind(best)
                && self.is_within_step(best).is_none()
                && self.closes_something(best) == Some(true)
                && self.widens_unseen(best) != Some(true)
                && self.is_more_than_its_base(best, judged)
        };
        let best = best.filter(is_told).map(|best| self.with_delay_as_effect(best, judged));
        candidates.extend(fitted.iter().map(|fitted| self.with_delay_as_effect(fitted, judged)));
        best
    }

    /// A fit beside a free base, whose delay is one of its effects where a delay leads and is no small part of the lag of that base.
    fn with_delay_as_effect(&self, fitted: &Fitted, judged: &Judgement) -> Fitted {
        let hypothesis = &fitted.space.hypothesis;
        let leads = judged.delay.as_ref().is_some_and(|delay| delay.why_not.is_none());
        if !leads || hypothesis.effects.contains(&DELAY) || !late::is_no_small_part(&fitted.model, self.given) {
            return fitted.clone();
        }
        let effects = [DELAY].into_iter().chain(hypothesis.effects.iter().copied()).collect();
        let hypothesis = Hypothesis { effects, ..hypothesis.clone() };
        let space = Space::new(hypothesis, &fitted.model, &self.given.base, 0.0);
        Fitted::at_start(space, &self.fit)
            .map_or_else(|| fitted.clone(), |named| Fitted { converged: fitted.converged, ..named })
    }

    /// Whether an explanation clearly reduces the residual of the check records about the levels.
    fn closes_something(&self, found: &Fitted) -> Option<bool> {
        let left = |model: &Model| Some(PlainFit::beside_levels(model, &self.check)?.mean_square());
        Some(left(&found.model)? < CLOSES_NOTHING.powi(2) * left(self.given)?)
    }

    /// Whether an explanation without measurement terms has a larger residual than the given model on any check record, levels included, as packaged
    /// models are compared.
    pub fn widens_unseen(&self, found: &Fitted) -> Option<bool> {
        if found.space.hypothesis.effects.iter().any(|effect| MeasurementTerm::of(effect).is_some()) {
            return Some(false);
        }
        let (before, after) =
            (PlainFit::as_it_is(self.given, &self.check)?, PlainFit::as_it_is(&found.model, &self.check)?);
        let mut each = self.check.iter().zip(before.residuals.iter().zip(&after.residuals));
        let widens = |(trace, (before, after)): (&Trace<'_>, (&Vec<f64>, &Vec<f64>))| {
            self.leaves_more(found, [rms(after), rms(before)], from_ref(trace)) == Some(true)
        };
        Some(each.any(widens))
    }

    /// Whether an effect beside its own free base is significant over a free base alone, which includes a delay and levels of the records.
    fn is_more_than_its_base(&self, found: &Fitted, judged: &Judgement) -> bool {
        let PlainFit { space, x, .. } = &judged.base;
        let alone = space.clone().starting_at(x).and_then(|space| Fitted::search(space, &self.fit, SearchEffort::Full));
        alone.is_none_or(|alone| self.is_significant(found, &alone))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{measured_noise::MeasuredNoise, three_records::three_records_of},
        progress::Work,
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Base, Order, table},
    };

    /// Effects that are stated where a dead zone beside a free base explains records of an actuator with another base, a dead zone and a delay of so
    /// many lags of that base.
    fn stated(lags: f64) -> Vec<&'static str> {
        let of = |base: [f64; 4]| Model {
            order: Order::Third,
            base: Base::from_values(base).unwrap(),
            effects: Effects::default(),
            ..Model::from_set(&table()[0])
        };
        let (given, moved) = (of([1.0, 27.0, 115.0, 0.86]), of([1.0, 36.0, 130.0, 0.97]));
        let effects = [("delay", lags * late::lag_s(&moved)), ("dead_zone", 0.3)];
        let with = |all: Effects, (name, value): &(&str, f64)| all.with(find(name).unwrap(), &[*value]).unwrap();
        let truth = Model { effects: effects.iter().fold(Effects::default(), with), ..moved };
        let records = three_records_of(&truth, 5.0, 6.0);
        let (fit, check) = records.split_at(2);
        let noise = MeasuredNoise::of(&records.iter().collect::<Vec<&Record>>(), &[]);
        let work = Work::new(Vec::new(), None);
        let selection = StructureSelection::new(&given, fit, check, noise, None, &work);
        let judged = selection.judge_wide().unwrap();
        let dead_zone = judged.judged.iter().find(|judged| judged.effect == "dead_zone").unwrap();
        let fitted = selection.by_likelihood(dead_zone.fit.on(&selection.fit).unwrap()).unwrap();
        selection.with_delay_as_effect(&fitted, &judged).space.hypothesis.effects
    }

    #[test]
    fn a_delay_that_is_no_small_part_of_the_lag_is_stated_with_the_effect_beside_the_same_base() {
        assert_eq!(stated(1.8), [DELAY, "dead_zone"]);
        assert_eq!(stated(0.3), ["dead_zone"]);
    }
}
