//! Effects that lead together: none of them explains the largest part of the difference beside a base alone, but several explain nearly all that any base
//! and any linear model leave.

use super::{
    fitted::Fitted,
    hypothesis::{Hypothesis, LAGS, MeasurementTerm, family},
    judgement::Judgement,
    outcome::Form,
    plain_fit::{PlainFit, mean_square},
    rivals::{GREATEST_STRENGTH_RATIO, varying_strength},
    selection::StructureSelection,
    space::Space,
    trace::Trace,
    unseen::{NEARLY_NOTHING, excess, sample_counts, strengths_by_record},
};
use crate::sorting::sort_by_number;
use actuator_fmu::parameters::Model;

/// Combinations that are tried, the likeliest first.
const TRIED: usize = 3;

/// Mean square without an effect over that with it, at least, on the fit records and on the check records, for an effect that is needed.
const NEEDED: f64 = 1.5;

/// Excess without the leading effect over that of the free base, at least: it is the largest part.
const LARGEST_PART: f64 = 0.5;

/// Mean square with another member of the family over that of the lead, at most, where they are tied.
const AS_NEAR: f64 = 1.2;

impl StructureSelection<'_> {
    /// The likeliest combination that holds, its leading effect first.
    pub fn leading_combination(&self, judged: &Judgement, base: &Fitted, candidates: &[Fitted]) -> Option<Form> {
        if self.as_healthy().is_some() {
            return None;
        }
        let of_base = |one: &&Fitted| self.contains_unrecorded_load(one);
        let mut several: Vec<&Fitted> = candidates.iter().filter(|one| is_combination(one) && !of_base(one)).collect();
        several.retain(|one| {
            self.may_leave_nearly_nothing(one, judged) && self.leaves_nearly_nothing(&one.model, judged) == Some(true)
        });
        sort_by_number(&mut several, |one| one.bic);
        several.into_iter().take(TRIED).find_map(|one| {
            let needed = self.of_needed_effects(one.clone())?;
            self.led_by_its_largest(&needed, judged, base, candidates)
        })
    }

    /// Whether a load acts that no record contains: its stiffness is a shift of the base, which is free.
    fn contains_unrecorded_load(&self, one: &Fitted) -> bool {
        let is_recorded = |trace: &Trace<'_>| trace.record.load().is_some();
        one.space.hypothesis.effects.contains(&"hinge_load") && !self.fit.iter().any(is_recorded)
    }

    /// A combination without the effects that are not needed; none where one effect is left.
    fn of_needed_effects(&self, mut found: Fitted) -> Option<Fitted> {
        while is_combination(&found) {
            let effects = found.space.hypothesis.effects.clone();
            let fewer = effects.iter().filter_map(|needless| self.refit_without(&found, needless));
            let Some(least) = fewer.min_by(|one, other| one.rms().total_cmp(&other.rms())) else { break };
            if self.is_needed_beside(&found.model, &least.model)? {
                return Some(found);
            }
            found = least;
        }
        None
    }

    /// Whether a model leaves far less than another one, both on the fit records and on the check records.
    fn is_needed_beside(&self, with: &Model, without: &Model) -> Option<bool> {
        let left = |model: &Model, traces: &[Trace<'_>]| Some(PlainFit::as_it_is(model, traces)?.mean_square());
        let is_less = |traces: &[Trace<'_>]| Some(left(without, traces)? > NEEDED * left(with, traces)?);
        Some(is_less(&self.fit)? && is_less(&self.check)?)
    }

    /// A combination with the effect first that explains most, where this holds.
    fn led_by_its_largest(
        &self,
        found: &Fitted,
        judged: &Judgement,
        base: &Fitted,
        candidates: &[Fitted],
    ) -> Option<Form> {
        let effects = &found.space.hypothesis.effects;
        let without = |effect: &&'static str| {
            let model = self.refit_without(found, effect)?.model;
            let left = PlainFit::as_it_is(&model, &self.all_records())?.residuals;
            Some((*effect, self.share_of(&left, judged, 0)))
        };
        let left: Vec<(&'static str, f64)> = effects.iter().filter_map(without).collect();
        let (lead, left) = left.into_iter().max_by(|one, other| one.1.total_cmp(&other.1))?;
        if left < LARGEST_PART || LAGS.contains(&lead) {
            return None;
        }
        let others = || effects.iter().copied().filter(|effect| *effect != lead);
        let hypothesis =
            Hypothesis { effects: [lead].into_iter().chain(others()).collect(), ..found.space.hypothesis.clone() };
        let fitted = Fitted::at_start(Space::new(hypothesis, &found.model, &self.given.base, 0.0), &self.fit)?;
        let is_tied = |other: &&Fitted| {
            let members = &other.space.hypothesis.effects;
            members.len() == effects.len()
                && !members.contains(&lead)
                && others().all(|effect| members.contains(&effect))
                && members.iter().any(|effect| family(effect) == family(lead) && !effects.contains(effect))
                && self.comes_as_near_as(&found.model, &other.model) == Some(true)
        };
        let tied = candidates.iter().filter(is_tied).flat_map(|other| &other.space.hypothesis.effects);
        let mut alternatives: Vec<String> =
            tied.filter(|effect| !effects.contains(effect)).map(|effect| (*effect).to_owned()).collect();
        alternatives.sort();
        alternatives.dedup();
        let form = Form { fitted, alternatives, is_nearly_all: true };
        self.combination_holds(&form, lead, judged, base)?.then_some(form)
    }

    /// Whether another model leaves hardly more than the best one.
    fn comes_as_near_as(&self, best: &Model, other: &Model) -> Option<bool> {
        let traces = self.all_records();
        let left = |model: &Model| Some(PlainFit::as_it_is(model, &traces)?.mean_square());
        Some(left(other)? < AS_NEAR * left(best)?)
    }

    /// Whether a combination is plausible and within what the records determine, has one strength, and increases the residual of no record.
    fn combination_holds(&self, form: &Form, lead: &str, judged: &Judgement, base: &Fitted) -> Option<bool> {
        let fitted = &form.fitted;
        let traces = self.all_records();
        let plain = PlainFit::at(fitted.space.clone(), fitted.x.clone(), &traces)?;
        let strengths = strengths_by_record(&plain, lead, &traces);
        let shows = vec![true; traces.len()];
        let (noise, counts) = (self.noise.mean_squares(), sample_counts(&plain));
        let left = PlainFit::as_it_is(&fitted.model, &traces)?.mean_squares();
        let is_larger = (0..left.len()).any(|record| {
            let of =
                |squares: &[f64]| excess(&squares[record..=record], &noise[record..=record], &counts[record..=record]);
            of(&left) > of(&judged.base_left).max(noise[record] * counts[record])
        });
        Some(
            fitted.space.is_plausible(&fitted.model)
                && !fitted.space.is_base_at_bound(&fitted.x)
                && !fitted.space.effect_at_bound(&fitted.x)
                && !is_larger
                && self.passed_stop(fitted).is_none()
                && self.holds_briefly(form).is_none()
                && self.is_within_step(fitted).is_none()
                && varying_strength((lead, fitted.model.unit()), &strengths, &shows, GREATEST_STRENGTH_RATIO).is_none()
                && self.closes_and_widens_nothing(fitted, base)?,
        )
    }

    /// Whether the residual of the fit records about their levels, which is known, is as small: without the levels it is no smaller.
    fn may_leave_nearly_nothing(&self, one: &Fitted, judged: &Judgement) -> bool {
        self.share_of(&one.residuals, judged, 0) < NEARLY_NOTHING
    }

    /// Whether a model leaves nearly nothing of what the free base and the linear model leave on unseen records.
    fn leaves_nearly_nothing(&self, model: &Model, judged: &Judgement) -> Option<bool> {
        let is_little = |traces: &[Trace<'_>], first: usize| {
            let left = PlainFit::as_it_is(model, traces)?.residuals;
            Some(self.share_of(&left, judged, first) < NEARLY_NOTHING)
        };
        Some(is_little(&self.fit, 0)? && is_little(&self.check, self.fit.len())?)
    }

    /// Excess of residuals over that of the free base or of the linear model, whichever leaves less, on as many records from the first one on.
    #[allow(clippy::cast_precision_loss)] // counts of samples
    fn share_of(&self, residuals: &[Vec<f64>], judged: &Judgement, first: usize) -> f64 {
        let records = first..first + residuals.len();
        let counts: Vec<f64> = residuals.iter().map(|residual| residual.len() as f64).collect();
        let noise = self.noise.mean_squares();
        let of = |left: &[f64]| excess(left, &noise[records.clone()], &counts);
        let left: Vec<f64> = residuals.iter().map(|residual| mean_square(residual)).collect();
        let least = of(&judged.base_left[records.clone()]).min(of(&judged.linear_left[records.clone()]));
        of(&left).max(0.0) / least.max(f64::MIN_POSITIVE)
    }

    fn all_records(&self) -> Vec<Trace<'_>> {
        self.fit.iter().chain(&self.check).cloned().collect()
    }
}

/// Whether several effects act, all of them on the motion.
fn is_combination(fitted: &Fitted) -> bool {
    let effects = &fitted.space.hypothesis.effects;
    effects.len() > 1 && effects.iter().all(|effect| MeasurementTerm::of(effect).is_none())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{
            measured_noise::MeasuredNoise,
            three_records::{behind_gear, three_records_of},
        },
        progress::Work,
        signal::record::Record,
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Base, table},
    };

    const STOP: (&str, &[f64]) = ("position_limit", &[-1.5, 1.8]);
    const FRICTION: (&str, &[f64]) = ("coulomb_friction", &[0.4]);

    /// The combination that leads where these effects act, before a sensor with an error that no effect reproduces; the candidate is fitted from a
    /// start far from it.
    fn leading(given: &Model, truth: &[(&str, &[f64])]) -> Option<Form> {
        let with = |some: &[(&str, &[f64])]| {
            let add = |effects: Effects, (name, values): &(&str, &[f64])| effects.with(find(name)?, values).ok();
            let effects = some.iter().try_fold(Effects::default(), add).unwrap();
            Model { effects, ..given.clone() }
        };
        let moving = Model { effects: with(truth).effects, ..Model::from_set(&table()[0]) };
        let records: Vec<Record> =
            three_records_of(&moving, 5.0, 6.0).iter().map(|record| behind_gear(record, 0.0)).collect();
        let (fit, check) = records.split_at(2);
        let noise = MeasuredNoise::of(&records.iter().collect::<Vec<&Record>>(), &[]);
        let work = Work::new(Vec::new(), None);
        let selection = StructureSelection::new(given, fit, check, noise, None, &work);
        let base = selection.fit(Hypothesis { base_free: true, ..Hypothesis::default() }, given)?;
        let hypothesis = Hypothesis { effects: vec![FRICTION.0, STOP.0], base_free: true, ..Hypothesis::default() };
        let start = with(&[("position_limit", &[-1.2, 2.2]), ("coulomb_friction", &[0.2])]);
        let candidate = selection.refined(selection.fit(hypothesis, &start)?);
        selection.leading_combination(&selection.judge_wide()?, &base, &[candidate])
    }

    #[test]
    fn a_stop_leads_with_friction_without_which_much_is_left() {
        let model = Model::from_set(&table()[0]);
        let [k, p, omega, zeta] = model.base.values();
        let given = Model { base: Base::from_values([0.9 * k, p, omega, zeta]).unwrap(), ..model };
        let found = leading(&given, &[STOP, FRICTION]).unwrap().fitted;
        assert_eq!(found.space.hypothesis.effects, [STOP.0, FRICTION.0]);
        for (name, values) in [STOP, FRICTION] {
            let found = found.model.effects.values_of(name).unwrap();
            assert!(found.iter().zip(values).all(|(found, value)| (found / value - 1.0).abs() < 0.1), "{found:?}");
        }
        // Alone it needs no other effect, and a base of its own explains friction alone as well.
        assert!(leading(&given, &[STOP]).is_none());
        assert!(leading(&given, &[]).is_none());
    }
}
