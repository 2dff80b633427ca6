//! A base with wrong parameters, and what it would be taken for: a wrong pole for a lag, the model of another actuator for an effect.

use std::f64::consts::FRAC_1_SQRT_2;

use super::{
    evidence::{MOVED_POLE, REQUIRED_BIC_LEAD, pooled_deviation},
    fitted::{Fitted, SearchEffort},
    hypothesis::{Hypothesis, LAGS, MeasurementTerm},
    judgement::Judgement,
    outcome::PROMISING_SHARE,
    plain_fit::PlainFit,
    selection::StructureSelection,
    space::{STRUCTURAL_MODE, Space},
    steady_level::level_and_deviation,
    trace::Trace,
};
use crate::sorting::sort_by_number;
use actuator_fmu::{
    effects::{Effect, find},
    parameters::{Base, Model, Order},
};

/// p over ω of the given model above which its fit did not identify the pole.
const UNSEEN_POLE_RATIO: f64 = 300.0;

/// Deviation of the residual with a shifted base over that of the given model, above which the shift is negligible.
const LEAST_FALL: f64 = 0.98;

/// Effects that the level of each record may be.
const LEVELS: [&str; 2] = ["sensor_bias", "hinge_load"];

/// A coarse search whose BIC is higher by less than this is refined.
const WORTH_REFINING_BIC: f64 = 60.0;

impl StructureSelection<'_> {
    /// The same explanation with a delay or a lag beside the given base, at the same total lag, if that is likelier: beside a base that has taken up
    /// part of the lag the other one may be likelier.
    pub fn lag_beside_given_base(&self, found: Fitted, candidates: &mut Vec<Fitted>) -> Fitted {
        let hypothesis = &found.space.hypothesis;
        let Some(present) = hypothesis.lag() else { return found };
        let late_s = |base: &Base| (1.0 / base.p()) + 2.0 * base.zeta() / base.omega();
        let own_s = found.model.effects.values_of(present.name).map_or(0.0, |values| values[0]);
        let lag_s = own_s + late_s(&found.model.base) - late_s(&self.given.base);
        let [k, ..] = found.model.base.values();
        let [_, p, omega, zeta] = self.given.base.values();
        let Ok(base) = Base::from_values([k, p, omega, zeta]) else { return found };
        // Where both are present, neither replaces the other.
        let is_free = |lag: &&str| *lag == present.name || !hypothesis.effects.contains(lag);
        let mut best = found.clone();
        for lag in LAGS.into_iter().filter(is_free).filter_map(find) {
            let Ok(effects) = found.model.effects.without(present).with(lag, &[lag_s]) else { continue };
            let start = Model { base, effects, ..found.model.clone() };
            let effects =
                hypothesis.effects.iter().map(|effect| if *effect == present.name { lag.name } else { effect });
            let hypothesis = Hypothesis { effects: effects.collect(), base_free: true, ..hypothesis.clone() };
            let space = Space::new(hypothesis, &start, &self.given.base, found.space.chatter_hz(&found.x));
            let coarse = Fitted::search(space, &self.fit, SearchEffort::Coarse);
            let Some(coarse) = coarse.filter(|coarse| coarse.bic < best.bic + WORTH_REFINING_BIC) else { continue };
            let other = self.refined(coarse);
            candidates.push(other.clone());
            if other.bic < best.bic {
                best = other;
            }
        }
        best
    }

    /// The same explanation with other poles of the base instead of a delay, a lag or a mode, if that is clearly better: the actuator then has
    /// neither, but its model has a wrong p or, if of second order, a wrong ω.
    #[allow(clippy::cast_precision_loss)] // counts of parameters and samples
    pub fn base_instead_of_lag(&self, found: Fitted, candidates: &mut Vec<Fitted>) -> Fitted {
        let hypothesis = &found.space.hypothesis;
        let mode = || find(STRUCTURAL_MODE).filter(|mode| hypothesis.effects.contains(&mode.name));
        let Some(linear) = hypothesis.lag().or_else(mode) else { return found };
        let effects: Vec<&str> = hypothesis.effects.iter().copied().filter(|effect| *effect != linear.name).collect();
        let is_third = self.given.order == Order::Third;
        let without = found.model.effects.without(linear);
        let starts = self.bases_without(linear, &found.model).into_iter();
        let starts: Vec<Model> =
            starts.map(|base| Model { base, effects: without.clone(), ..found.model.clone() }).collect();
        let search = |wide: bool| {
            let hypothesis = Hypothesis {
                effects: effects.clone(),
                base_free: true,
                pole_free: !wide,
                wide,
                ..Hypothesis::default()
            };
            let fits = starts.iter().filter_map(|start| {
                let space = Space::new(hypothesis.clone(), start, &self.given.base, found.space.chatter_hz(&found.x));
                // Levels that are free beside the base alone, and slow noise in them, are no evidence against the lag.
                Fitted::search(space.with_levels_as_in(&found.space), &self.fit, SearchEffort::Full)
            });
            fits.min_by(|a, b| a.bic.total_cmp(&b.bic))
        };
        // A pole that the fit of the given model did not identify, or that was moved, is unknown: the lag may be due to it. One near the given pole
        // only means that the given one is inaccurate.
        let given = self.given.base.p();
        let is_off_by = |pole: f64, factor: f64| (pole / given).ln().abs() > factor.ln();
        let is_unknown = given > UNSEEN_POLE_RATIO * self.given.base.omega()
            || starts.iter().any(|start| is_off_by(start.base.p(), MOVED_POLE));
        // Parameters of the base that are free with the pole and not with the lag are no evidence against the pole.
        let numbers = |fitted: &Fitted| fitted.x.len() as f64;
        let samples = self.fit.iter().map(Trace::evaluated_samples).sum::<usize>() as f64;
        let penalty = |other: &Fitted| (numbers(other) - numbers(&found)).max(0.0) * samples.ln();
        let lead = |other: &Fitted| {
            // A mode that is no better than a free base is none: what rings is not imitated by one.
            if linear.name == STRUCTURAL_MODE {
                return -REQUIRED_BIC_LEAD;
            }
            let is_shift = is_unknown || !is_off_by(other.model.base.p(), MOVED_POLE);
            if is_third && is_shift && !other.space.hypothesis.wide {
                -REQUIRED_BIC_LEAD - penalty(other)
            } else {
                REQUIRED_BIC_LEAD
            }
        };
        // A free base imitates a lag: it has to be clearly better.
        let reaches: &[bool] = if is_third { &[false, true] } else { &[true] };
        for &wide in reaches {
            let Some(other) = search(wide) else { continue };
            // It may be a rival of what was found.
            candidates.push(other.clone());
            let is_as_likely = (other.bic - found.bic).abs() < REQUIRED_BIC_LEAD;
            if other.bic + lead(&other) < found.bic || is_as_likely && self.predicts_better(&other, &found) {
                // Effects beside the lag may have compensated for its error.
                return self.eliminate_backward(other, 0, candidates);
            }
        }
        found
    }

    /// Start values of a base in place of which a delay, a lag or a mode was found: with the same lag 1/p + 2ζ/ω, if of second order with its own
    /// damping ratio and with that of most actuators; for a mode, which is no lag, the base beside it and the given one.
    fn bases_without(&self, linear: &Effect, found: &Model) -> Vec<Base> {
        let [k, p, omega, zeta] = found.base.values();
        let bases = if linear.name == STRUCTURAL_MODE {
            vec![found.base.values(), self.given.base.values()]
        } else {
            let lag_s = found.effects.values_of(linear.name).map_or(0.0, |values| values[0]);
            if self.given.order == Order::Third {
                vec![[k, 1.0 / (1.0 / p + lag_s), omega, zeta]]
            } else {
                let late_s = 2.0 * zeta / omega + lag_s;
                [zeta, FRAC_1_SQRT_2].map(|zeta| [k, p, 2.0 * zeta / late_s, zeta]).to_vec()
            }
        };
        bases.into_iter().filter_map(|values| Base::from_values(values).ok()).collect()
    }

    /// Whether one hypothesis has a clearly smaller residual on the check records than another.
    fn predicts_better(&self, one: &Fitted, other: &Fitted) -> bool {
        const CLEARLY: f64 = 0.99;
        let left = one.on(&self.check).zip(other.on(&self.check));
        left.is_some_and(|(one, other)| one.rms() < CLEARLY * other.rms())
    }

    /// The same explanation without a hinge load whose load was not recorded, if a base further off is as likely: the stiffness of such a load is
    /// equivalent to another base.
    ///
    /// ```text
    /// k' = k / (1 + s),  ω' = ω √(1 + s),  ζ' = ζ / √(1 + s),    s the stiffness
    /// ```
    pub fn base_instead_of_stiffness(&self, found: Fitted, candidates: &mut Vec<Fitted>) -> Fitted {
        let hypothesis = &found.space.hypothesis;
        let load = find("hinge_load").filter(|load| hypothesis.effects.contains(&load.name));
        let is_recorded = self.fit.iter().any(|trace| trace.record.load().is_some());
        let values = load.and_then(|load| Some((load, found.model.effects.values_of(load.name)?)));
        let Some((load, &[stiffness, _])) = values.filter(|_| !is_recorded) else { return found };
        let effects = hypothesis.effects.iter().copied().filter(|effect| *effect != load.name).collect();
        let [k, p, omega, zeta] = found.model.base.values();
        let root = (1.0 + stiffness).max(f64::MIN_POSITIVE).sqrt();
        let base = Base::from_values([k / (root * root), p, omega * root, zeta / root]);
        let Ok(base) = base else { return found };
        let start = Model { base, effects: found.model.effects.without(load), ..found.model.clone() };
        let hypothesis = Hypothesis { effects, base_free: true, wide: true, ..Hypothesis::default() };
        let space = Space::new(hypothesis, &start, &self.given.base, found.space.chatter_hz(&found.x));
        // Levels of the records would be a steady load.
        let space = space.without_levels();
        let Some(other) = Fitted::search(space, &self.fit, SearchEffort::Full) else { return found };
        candidates.push(other.clone());
        if other.bic < found.bic + REQUIRED_BIC_LEAD { other } else { found }
    }

    /// The base of an explanation without its effects, refitted from there, if these are not significant over it; measurement terms and effects of
    /// the given model stay. The search of a base alone begins at the given one: far from the best base its residual is slow and taken for noise, and
    /// whitening removes with it what identifies the base.
    pub fn base_instead_of_effects(&self, found: Fitted, candidates: &mut Vec<Fitted>) -> Fitted {
        let hypothesis = &found.space.hypothesis;
        let stays = |effect: &&'static str| MeasurementTerm::of(effect).is_some() || self.is_given(effect);
        let (effects, others): (Vec<&'static str>, Vec<&'static str>) =
            hypothesis.effects.iter().copied().partition(stays);
        if others.is_empty() || !hypothesis.base_free || hypothesis.wide {
            return found;
        }
        let without = |model: Model, name: &&str| match find(name) {
            Some(effect) => Model { effects: model.effects.without(effect), ..model },
            None => model,
        };
        let start = others.iter().fold(found.model.clone(), without);
        let hypothesis = Hypothesis { effects, ..hypothesis.clone() };
        let space = Space::new(hypothesis, &start, &self.given.base, found.space.chatter_hz(&found.x));
        let Some(alone) = Fitted::search(space, &self.fit, SearchEffort::Full) else { return found };
        candidates.push(alone.clone());
        if !self.is_significant(&found, &alone) && self.is_adequate(Some(&alone), &alone) { alone } else { found }
    }

    /// The base with all its parameters refitted, p among them, if that is adequate: the given model is that of another actuator, however far off.
    /// Hum of the sensor is kept.
    pub fn adequate_shift(
        &self,
        judged: &Judgement,
        near: Option<&Fitted>,
        base: &Fitted,
        candidates: &mut Vec<Fitted>,
    ) -> Option<Fitted> {
        if judged.base_predictable.share > PROMISING_SHARE {
            return None;
        }
        let of_sensor = |effect: &&str| MeasurementTerm::of(effect) == Some(MeasurementTerm::Chatter);
        let effects = near
            .map_or_else(Vec::new, |near| near.space.hypothesis.effects.iter().copied().filter(of_sensor).collect());
        let chatter_hz = near.map_or(0.0, |near| near.space.chatter_hz(&near.x));
        let (found, given) = (&judged.base.model, self.given.base.values());
        // The base without the delay that was free with it: with its own pole, or with one that has this lag as well.
        let [k, p, omega, zeta] = found.base.values();
        let delay_s = found.effects.active_values_of("delay").map_or(0.0, |values| values[0]);
        let poles = if self.given.order == Order::Third { vec![p, 1.0 / (1.0 / p + delay_s)] } else { vec![p] };
        let fitted = poles.into_iter().filter_map(|p| {
            let start = Model { base: Base::from_values([k, p, omega, zeta]).ok()?, ..self.given.clone() };
            let hypothesis =
                Hypothesis { effects: effects.clone(), base_free: true, wide: true, ..Hypothesis::default() };
            let space = Space::new(hypothesis, &start, &self.given.base, chatter_hz);
            Fitted::search(space, &self.fit, SearchEffort::Full)
        });
        let fitted = fitted.min_by(|a, b| a.bic.total_cmp(&b.bic))?;
        // Factor in k beyond which it is a unit or another channel.
        const NEAR: f64 = 2.5;
        let is_near = (fitted.model.base.k() / given[0]).abs().ln().abs() < NEAR.ln();
        // Where a base near the given one leaves more than noise, one that leaves noise needs no confirmation by check records.
        let is_better = || fitted.bic + REQUIRED_BIC_LEAD < base.bic && !self.is_adequate(None, base);
        let is_shift =
            is_near && self.is_adequate(Some(&fitted), base) && (self.is_significant(&fitted, base) || is_better());
        if is_shift && self.is_off_by_level(&fitted) {
            return self.level_beside_shift(&fitted, base, candidates);
        }
        is_shift.then_some(fitted)
    }

    /// A bias of the sensor or a steady load, which are the same to most records, beside a shifted base, p among its parameters, where levels of the
    /// records are mainly what that base leaves.
    fn level_beside_shift(&self, shifted: &Fitted, base: &Fitted, candidates: &mut Vec<Fitted>) -> Option<Fitted> {
        let chatter_hz = shifted.space.chatter_hz(&shifted.x);
        let with = |level: &'static str| {
            let effects = shifted.space.hypothesis.effects.iter().copied().chain([level]).collect();
            let hypothesis = Hypothesis { effects, base_free: true, pole_free: true, ..Hypothesis::default() };
            let space = Space::new(hypothesis, &shifted.model, &self.given.base, chatter_hz);
            let found = Fitted::search(space, &self.fit, SearchEffort::Full)?;
            (self.is_adequate(Some(&found), base) && self.is_significant(&found, base)).then_some(found)
        };
        let mut found: Vec<Fitted> =
            LEVELS.into_iter().filter(|level| !self.is_given(level)).filter_map(with).collect();
        sort_by_number(&mut found, |one| one.bic);
        candidates.extend(found.iter().cloned());
        found.into_iter().next()
    }

    /// Whether a shift of the base, or of effects of the given model, explains next to nothing on any records: over many samples a negligible one is
    /// significant, and every repeat has one.
    pub fn is_trifling_shift(&self, found: &Fitted, given: &Fitted) -> bool {
        found.space.hypothesis.effects.iter().all(|effect| self.is_given(effect)) && self.is_trifle(found, given)
    }

    /// The base instead of effects that explain next to nothing beside it, where rounding to the step of the positions, q/√12, exceeds what is left: what
    /// a model of coarse steps leaves is no noise, and over many samples anything that resembles it is significant.
    pub fn base_instead_of_trifle_beside_steps(&self, found: Fitted, base: &Fitted) -> Fitted {
        let rounded = |step: f64| step / 12.0_f64.sqrt();
        let is_rounded =
            || self.quantisation_step().is_some_and(|step| rounded(step) > pooled_deviation(&base.residuals));
        let is_trifle = found.space.hypothesis.base_free && is_rounded() && self.is_trifle(&found, base);
        if is_trifle { base.clone() } else { found }
    }

    /// Whether one hypothesis explains next to nothing more than another on fit and on check records.
    fn is_trifle(&self, one: &Fitted, other: &Fitted) -> bool {
        let takes_little = |one: &Fitted, other: &Fitted| {
            pooled_deviation(&one.residuals) > LEAST_FALL * pooled_deviation(&other.residuals)
        };
        let there = || one.on(&self.check).zip(other.on(&self.check));
        takes_little(one, other) && there().is_some_and(|(one, other)| takes_little(&one, &other))
    }

    /// Whether a check record differs from a model mainly by its level: the search removes the level of each record, and the model has none.
    fn is_off_by_level(&self, fitted: &Fitted) -> bool {
        let left = PlainFit::as_it_is(&fitted.model, &self.check);
        left.is_none_or(|left| left.residuals.iter().any(|residual| is_level(residual)))
    }
}

/// Whether a residual is mainly a level.
fn is_level(left: &[f64]) -> bool {
    // Root mean square over the deviation, above which it is.
    const GREATEST_RATIO: f64 = 2.0;
    let [level, deviation] = level_and_deviation(left);
    level.hypot(deviation) > GREATEST_RATIO * deviation
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{
            Verdict, diagnose,
            measured_noise::MeasuredNoise,
            three_records::{measured_as, three_records, three_records_of},
        },
        progress::Work,
        signal::record::Record,
    };
    use actuator_fmu::parameters::table;

    #[test]
    fn a_shift_that_takes_a_hundredth_of_what_is_left_is_none() {
        let truth = Model::from_set(&table()[0]);
        let records = three_records(&truth, 3.0);
        let verdict = |factor: f64| {
            let [k, p, omega, zeta] = truth.base.values();
            let given = Model { base: Base::from_values([factor * k, p, omega, zeta]).unwrap(), ..truth.clone() };
            let diagnosis = diagnose(&given, &records[..2], &records[2..], &[], None).unwrap();
            (diagnosis.verdict, diagnosis.findings.first().map(|finding| finding.name))
        };
        // Errors of 0.15 of the noise, and as large as the noise.
        assert_eq!(verdict(1.0015), (Verdict::NothingMissing, None));
        assert_eq!(verdict(1.01), (Verdict::Named, Some("parameter_shift")));
    }

    /// A model with a pole twenty times too fast, and ω a twentieth too high.
    #[test]
    fn a_level_beside_a_base_with_another_pole_is_a_bias() {
        let truth = Model::from_set(&table()[0]);
        let [k, _, omega, zeta] = truth.base.values();
        let of = |p: f64, omega: f64| Model { base: Base::from_values([k, p, omega, zeta]).unwrap(), ..truth.clone() };
        let (moving, given) = (of(5.0 * omega, omega), of(100.0 * omega, 1.05 * omega));
        let records: Vec<Record> =
            three_records_of(&moving, 3.0, 6.0).iter().map(|record| measured_as(record, |_, at| at + 0.1)).collect();
        let noise = MeasuredNoise::of(&records.iter().collect::<Vec<&Record>>(), &[]);
        let work = Work::new(Vec::new(), None);
        let selection = StructureSelection::new(&given, &records[..2], &records[2..], noise, None, &work);
        let base = selection.fit(Hypothesis::default(), &given).unwrap();
        let free = Hypothesis { base_free: true, wide: true, ..Hypothesis::default() };
        let shifted = selection.fit(free, &of(10.0 * omega, omega)).unwrap();
        assert!(selection.is_off_by_level(&shifted));
        let found = selection.level_beside_shift(&shifted, &base, &mut Vec::new()).unwrap();
        assert_eq!(found.space.hypothesis.effects, ["sensor_bias"]);
        assert!((found.model.base.p() / (5.0 * omega) - 1.0).abs() < 0.1, "{}", found.model.base.p());
        let offset = found.factors.iter().map(|factors| factors[0]);
        assert!(offset.clone().all(|offset| (offset - 0.1).abs() < 0.01), "{:?}", offset.collect::<Vec<f64>>());
    }

    #[test]
    fn a_level_is_more_than_all_else_that_is_left() {
        // With a deviation of 1, a level of the square root of three has an rms of twice that.
        let about = |level: f64| (0..100).map(|n| level + if n % 2 == 0 { 1.0 } else { -1.0 }).collect::<Vec<f64>>();
        assert!([0.0, 1.7, -1.7].iter().all(|level| !is_level(&about(*level))));
        assert!([1.8, -1.8].iter().all(|level| is_level(&about(*level))));
    }
}
