//! Effects that only a check record shows.
//!
//! The fit records cannot identify such an effect, and a check record must not decide what is named. It is searched on that record beside the
//! explanation of the fit records, and reported as a suspicion with its size.

use super::{
    diagnosis::Lead,
    evidence::shows_clearly,
    fitted::Fitted,
    hypothesis::{Hypothesis, MeasurementTerm, PARAMETER_SHIFT, family},
    judgement::Judgement,
    plain_fit::{PlainFit, mean_square},
    screening::observe,
    selection::StructureSelection,
    space::Space,
    trace::Trace,
    wide::{effect_of, implausible},
};
use crate::{digits::significant, parallel, signal::play::range};
use actuator_fmu::{
    effects::{CHAIN, Effect, find},
    parameters::{Base, Model},
};

/// Share of the excess of the explanation on the record that a suspected effect must explain.
const LEAST_SHARE: f64 = 0.5;

/// Mean square of the explanation on a check record over its largest on a fit record from which on an effect is suspected, where the explanation is
/// not adequate.
pub const CLEARLY_MORE: f64 = 1.5;

/// The same where it is otherwise adequate: the remainder must exceed the noise.
pub const MORE_THAN_NOISE: f64 = 2.0;

/// Mean square of another effect over that of a lead, on a check record, below which it contradicts the lead.
const CONTRADICTS: f64 = 0.25;

/// Mean square of a lead over that of the given model, on a check record, below which no other effect contradicts the lead: one that is fitted to
/// that record alone has a smaller residual there in any case.
const NEARLY_NOTHING: f64 = 0.1;

/// Mean square of a limit beside its own free base over that of a suspicion, and of the free base alone, up to which the limit is suspected instead.
const CLEARLY_LESS: f64 = 0.5;

/// Distance between two limits over the range of the command (times k) below which they hold the position still.
const NARROW: f64 = 0.02;

/// Mean square of a base fitted to the record alone over that of an effect below which the base is suspected instead: no effect is needed.
const AS_WELL: f64 = 1.2;

const ITERATIONS: usize = 12;

impl StructureSelection<'_> {
    /// The suspicion for each check record on which the mean square of the explanation exceeds its largest on a fit record by a factor.
    pub fn suspicions(&self, explanation: &Fitted, factor: f64) -> Vec<Lead> {
        let fitted = self.fit.len();
        let on_fitted = explanation.residuals.iter().map(|residual| mean_square(residual)).fold(0.0, f64::max);
        let of_record = |(index, trace): (usize, &Trace<'_>)| {
            let noise = self.noise.records.get(fitted + index).map_or(0.0, |noise| noise.rms * noise.rms);
            suspicion(explanation, trace, noise, factor * on_fitted)
        };
        self.check.iter().enumerate().filter_map(of_record).collect()
    }

    /// Suspicions, each replaced by a limit beside its own free base where this has a clearly smaller residual on the record, judged by fits to the
    /// other records and half of this one: on an actuator of another structure no effect may be identifiable beside the explanation of the fit
    /// records.
    pub fn or_beside_own_bases(&self, suspicions: Vec<Lead>, judgement: &Judgement) -> Vec<Lead> {
        let of = |suspicion: Lead| self.beside_own_base(&suspicion, judgement).unwrap_or(suspicion);
        suspicions.into_iter().map(of).collect()
    }

    fn beside_own_base(&self, suspicion: &Lead, judgement: &Judgement) -> Option<Lead> {
        let record = suspicion.only_in.as_ref()?;
        let place = self.check.iter().position(|trace| trace.record.source().display().to_string() == *record)?;
        let place = self.fit.len() + place;
        let noise = self.noise.records.get(place).map_or(0.0, |noise| noise.rms * noise.rms);
        let limits = judgement.judged.iter().filter(|judged| family(judged.effect) == "limit");
        let plausible = limits.filter(|judged| implausible(&judged.fit).is_none());
        let best = plausible.min_by(|a, b| a.left[place].total_cmp(&b.left[place]))?;
        let (left, left_by_other) = (best.left[place], suspicion.check_rms?.powi(2));
        // A free base explains much by itself.
        if left > CLEARLY_LESS * left_by_other.min(judgement.base_left[place]) {
            return None;
        }
        let excess = (left_by_other - noise) / (1.0 - suspicion.share?);
        let effect = find(best.effect)?;
        let names = effect.parameters.iter().map(|parameter| parameter.name);
        Some(Lead {
            name: effect.name,
            family: family(effect.name),
            share: Some(1.0 - (left - noise) / excess),
            nonlinear_share: best.nonlinear_share,
            check_rms: Some(left.sqrt()),
            parameters: names.zip(best.fit.model.effects.values_of(effect.name)?.iter().copied()).collect(),
            why_not: shows_only_in("a free base", record),
            only_in: Some(record.clone()),
        })
    }

    /// Whether a lead holds: the fit records show it clearly, or no effect suspected in a check record contradicts it there by a far smaller
    /// residual. A lead with a small share of the given model's residual there is not contradicted, nor is one `beside` which the suspicions were
    /// searched.
    pub fn is_consistent(&self, lead: &Fitted, base: &Fitted, beside: &Fitted, suspicions: &[Lead]) -> bool {
        let effects = &beside.space.hypothesis.effects;
        if lead.space.hypothesis.effects.last().is_some_and(|effect| effects.contains(effect)) {
            return true;
        }
        let space = Space::new(Hypothesis::default(), &lead.model, lead.space.given(), 0.0);
        let Some(left) = PlainFit::at(space, Vec::new(), &self.check) else { return false };
        let contradicts = |suspicion: &&Lead, left: f64| {
            !lead.space.hypothesis.effects.contains(&suspicion.name)
                && suspicion.check_rms.is_some_and(|rms| rms * rms < CONTRADICTS * left)
        };
        let Some(given) = PlainFit::as_it_is(self.given, &self.check) else { return false };
        let is_contradicted = |((trace, left), given): ((&Trace<'_>, f64), f64)| {
            if left < NEARLY_NOTHING * given {
                return false;
            }
            let record = trace.record.source().display().to_string();
            let mut there = suspicions.iter().filter(|suspicion| suspicion.only_in.as_ref() == Some(&record));
            there.any(|suspicion| contradicts(&suspicion, left))
        };
        let each = self.check.iter().zip(left.mean_squares()).zip(given.mean_squares());
        shows_clearly(lead, base) || !each.into_iter().any(is_contradicted)
    }
}

/// The suspicion for a record on which the mean square of the explanation exceeds `least`.
fn suspicion(explanation: &Fitted, trace: &Trace<'_>, noise: f64, least: f64) -> Option<Lead> {
    let alone = [trace.clone()];
    let without = PlainFit::at_start(beside(explanation, &explanation.model, None), &alone)?;
    let excess = without.mean_square() - noise;
    if without.mean_square() <= least || excess <= 0.0 {
        return None;
    }
    let observed = observe(&explanation.model, &without.residuals, &alone);
    let admissible = |effect: &&&Effect| {
        let is_active = explanation.model.effects.active_values_of(effect.name).is_some();
        !is_active && effect.name != "quantisation" && MeasurementTerm::of(effect.name).is_none()
    };
    let fit_one = |effect: &&'static Effect| -> Option<PlainFit> {
        let starts = (effect.start_values)(&observed).into_iter().filter_map(|values| {
            let mut model = explanation.model.clone();
            model.effects = model.effects.with(effect, &values).ok()?;
            Some(beside(explanation, &model, Some(effect.name)))
        });
        PlainFit::search_from_nearest(starts, &alone, ITERATIONS)
    };
    let effects: Vec<&'static Effect> = CHAIN.iter().filter(admissible).copied().collect();
    let best = parallel::map(&effects, fit_one)
        .into_iter()
        .flatten()
        .filter(|fit| implausible(fit).is_none())
        .min_by(|a, b| a.mean_square().total_cmp(&b.mean_square()))?;
    let share = 1.0 - (best.mean_square() - noise) / excess;
    if share < LEAST_SHARE {
        return None;
    }
    let record = trace.record.source().display().to_string();
    let lead = |name: &'static str, fit: &PlainFit, parameters: Vec<(&'static str, f64)>| Lead {
        name,
        family: family(name),
        share: Some(1.0 - (fit.mean_square() - noise) / excess),
        nonlinear_share: None,
        check_rms: Some(fit.mean_square().sqrt()),
        parameters: parameters.into_iter().collect(),
        why_not: shows_only_in(&of_the_others(&explanation.space.hypothesis), &record),
        only_in: Some(record.clone()),
    };
    // The record may differ by its gain, or be of another rig.
    let space = beside_with(explanation, &explanation.model, None, true);
    let start = space.start();
    let shifted = PlainFit::search_from(space, &start, &alone, ITERATIONS);
    if let Some(shifted) = shifted.filter(|shifted| shifted.mean_square() < AS_WELL * best.mean_square()) {
        let names = Base::PARAMETERS.iter().map(|parameter| parameter.name);
        let parameters = names.zip(shifted.model.base.values()).collect();
        return Some(lead(PARAMETER_SHIFT, &shifted, parameters));
    }
    let name = effect_of(&best);
    // Limits without room between them are no effect: the actuator, or its sensor, was off.
    let values = best.model.effects.values_of(name)?;
    let (low, high) = range(trace.record.command());
    let room = NARROW * explanation.model.base.k().abs() * (high - low);
    if ["position_limit", "command_limit"].contains(&name) && values[1] - values[0] < room {
        return None;
    }
    let effect = effects.iter().find(|effect| effect.name == name)?;
    let parameters = effect.parameters.iter().map(|parameter| parameter.name);
    let parameters = parameters.zip(values.iter().copied()).collect();
    Some(lead(name, &best, parameters))
}

/// A model on one record with its own level. The measurement terms of the explanation have their own sizes and phases there, and the parameters of an
/// effect are free.
fn beside(explanation: &Fitted, model: &Model, effect: Option<&'static str>) -> Space {
    beside_with(explanation, model, effect, false)
}

/// The same, with the base free or not.
fn beside_with(explanation: &Fitted, model: &Model, effect: Option<&'static str>, base_free: bool) -> Space {
    let effects = explanation.space.hypothesis.effects.iter().copied();
    let terms = effects.filter(|effect| MeasurementTerm::of(effect).is_some());
    let hypothesis =
        Hypothesis { base_free, wide: true, effects: terms.chain(effect).collect(), ..Hypothesis::default() };
    let chatter_hz = explanation.space.chatter_hz(&explanation.x);
    Space::new(hypothesis, model, explanation.space.given(), chatter_hz)
}

fn shows_only_in(beside: &str, record: &str) -> String {
    format!("beside {beside}, only the check record {record} shows it: a fit record like it is needed")
}

/// What explains the other records, in words.
fn of_the_others(hypothesis: &Hypothesis) -> String {
    match (hypothesis.effects.as_slice(), hypothesis.base_free) {
        ([], false) => "the given model".to_owned(),
        ([], true) => "the refitted base".to_owned(),
        _ => hypothesis.name(),
    }
}

/// Why a lead that is not consistent with suspicions is not named.
pub fn contradicted() -> String {
    format!(
        "fitted to the fit records, it has more than {} times the residual rms on a check record of another effect suspected there",
        significant(CONTRADICTS.sqrt().recip(), 2)
    )
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::{
        diagnose::three_records::{measured_as, three_records_of},
        signal::record::Record,
    };
    use actuator_fmu::parameters::table;

    #[test]
    fn a_line_has_its_own_phase_in_a_check_record() {
        const FREQUENCY_HZ: f64 = 7.38;
        let model = Model::from_set(&table()[0]);
        let humming = |(record, phase): (&Record, f64)| {
            measured_as(record, |t, position| position + 0.3 * (TAU * FREQUENCY_HZ * t + phase).sin())
        };
        let records = three_records_of(&model, 3.0, 6.0);
        let records: Vec<Record> = records.iter().zip([0.0, 2.0, 4.0]).map(humming).collect();
        let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &model.base)).collect();
        let hypothesis = Hypothesis { effects: vec!["chatter"], ..Hypothesis::default() };
        let space = Space::new(hypothesis, &model, &model.base, FREQUENCY_HZ);
        let explanation = Fitted::at_start(space, &traces[..2]).unwrap();
        let left = PlainFit::at_start(beside(&explanation, &explanation.model, None), &traces[2..])
            .unwrap()
            .mean_square()
            .sqrt();
        assert!(left < 0.05, "{left}");
    }

    /// A check record of half the gain, one behind a limit that the others do not reach, and one of an actuator that is off.
    #[test]
    fn a_record_of_another_gain_alone_is_no_effect_and_nothing_limits_what_is_off() {
        let model = Model::from_set(&table()[0]);
        let records = three_records_of(&model, 3.0, 6.0);
        let suspected = |measured: &dyn Fn(f64, f64) -> f64| {
            let traces: Vec<Trace<'_>> = records[..2].iter().map(|record| Trace::new(record, &model.base)).collect();
            let space = Space::new(Hypothesis::default(), &model, &model.base, 0.0);
            let explanation = Fitted::at_start(space, &traces).unwrap();
            let check = measured_as(&records[2], measured);
            suspicion(&explanation, &Trace::new(&check, &model.base), 1e-4, 1e-3)
        };
        let half = suspected(&|_, position| 0.5 * position).unwrap();
        assert_eq!(half.name, PARAMETER_SHIFT);
        let [before, after] = [model.base.k(), half.parameters["k"]];
        assert!((after / before - 0.5).abs() < 0.01, "{before} {after}");
        let limited = suspected(&|_, position| position.clamp(-1.5, 1.5)).unwrap();
        assert_eq!(family(limited.name), "limit");
        let off = suspected(&|t, _| 0.3 + 0.005 * (1e4 * t).sin());
        assert!(off.is_none(), "{off:?}");
    }
}
