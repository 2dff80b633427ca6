//! A stop that the measured positions show by themselves: wherever the model would go beyond a level, the position stands at it, whatever the command.
//!
//! The effect of a stop on a record continues after the contact: a controller with integral action has wound up, and returns late. No limit of the
//! library reproduces this, so that on such an actuator a stop explains a smaller part of the difference than other leads must. What the positions
//! show is certain nevertheless.

use super::{
    diagnosis::Lead,
    fitted::Fitted,
    hypothesis::{Hypothesis, family},
    outcome::{Form, Outcome, Standing},
    plain_fit::PlainFit,
    selection::StructureSelection,
    space::Space,
};
use crate::{digits::with_unit, signal::record::rms};
use actuator_fmu::{effects::find, parameters::Model};

/// Limits that make positions stand at a level: a stop, or a limited command.
const LIMITS: [&str; 2] = ["position_limit", "command_limit"];

/// Contacts on both sides together, at least.
const FEWEST_CONTACTS: usize = 3;

/// Rms of a model with the stop over those of the given model, of a base refitted near it and of its own base without the stop, at most, on the fit
/// or on the check records.
const CLOSES: f64 = 0.95;
/// Rms of one of the limits over that of the other, on the fit records, below which they are alternatives.
const AS_NEAR: f64 = 1.1;

const ITERATIONS: usize = 12;

/// Stops that positions show.
struct Stop {
    /// As a lead, in a model that reduces the residual; none where no model with them does.
    form: Option<Form>,
    /// A note on what the positions show.
    note: String,
    /// The lead that is listed where there is no form.
    shown: Lead,
}

impl StructureSelection<'_> {
    /// The stops that positions show, in the given model or beside a base refitted near it; none where they show none, or the given model has a limit
    /// of this kind.
    fn leading_stop(&self, base: &Fitted) -> Option<Stop> {
        let has_limit = LIMITS.iter().any(|limit| self.given.effects.active_values_of(limit).is_some());
        if has_limit || self.as_healthy().is_some() {
            return None;
        }
        let sides = [-1.0, 1.0].map(|sign| self.contact_towards(sign));
        let contacts: usize = sides.iter().flatten().map(|side| side.contacts).sum();
        if contacts < FEWEST_CONTACTS || !sides.iter().flatten().any(|side| side.is_whatever_the_command) {
            return None;
        }
        let levels = [-1.0, 1.0].iter().zip(&sides).map(|(sign, side)| side.as_ref().map(|side| sign * side.level));
        let levels: Vec<Option<f64>> = levels.collect();
        let form = self.at_levels(self.given, &levels, base).or_else(|| {
            let stop = self.with_limit(self.given, LIMITS[0], &levels)?;
            let beside = Hypothesis { base_free: true, ..Hypothesis::default() };
            let beside = Space::new(beside, &stop, &self.given.base, 0.0);
            self.at_levels(&PlainFit::search(beside, &self.fit, ITERATIONS)?.model, &levels, base)
        });
        let parameters = find(LIMITS[0]).map_or(&[][..], |stop| stop.parameters).iter().map(|parameter| parameter.name);
        let shown = Lead {
            name: LIMITS[0],
            family: family(LIMITS[0]),
            share: None,
            nonlinear_share: None,
            check_rms: None,
            parameters: parameters.zip(&levels).filter_map(|(name, level)| Some((name, (*level)?))).collect(),
            only_in: None,
            why_not: format!(
                "the position rests there in {contacts} contacts, however far the model goes beyond, but a model with the stop hardly reduces the residual, or \
                 increases that of a record, as where integral action returns late from a stop"
            ),
        };
        let unit = self.given.unit().name();
        let at: Vec<String> = levels.iter().flatten().map(|level| with_unit(*level, 4, unit)).collect();
        let note = format!(
            "the position rests at {} in {contacts} contacts, however far the model goes beyond: a stop. The motion after a contact may still differ: \
             integral action winds up there",
            at.join(" and at ")
        );
        Some(Stop { form, note, shown })
    }

    /// An outcome that explains nothing, with the stops that these records show.
    pub fn with_stop(&self, mut outcome: Outcome) -> Outcome {
        let stop = if outcome.is_unexplained() { self.leading_stop(&outcome.base) } else { None };
        // They may have been listed already, from parts of the records.
        outcome.shown.retain(|lead| lead.name != LIMITS[0]);
        let Some(Stop { form, note, shown }) = stop else { return outcome };
        let Some(form) = form else {
            outcome.shown.push(shown);
            return outcome;
        };
        let Some((misfit, predictable)) = self.misfit(&form.fitted).zip(self.predictable(&form.fitted)) else {
            return outcome;
        };
        let (explanation, note) = (Some(form.fitted.clone()), Some(note));
        Outcome { explanation, standing: Standing::Leading { forms: vec![form] }, misfit, predictable, note, ..outcome }
    }

    /// The limit in a model with the smallest residual on the fit records, and the other one where its residual is as small; none where neither
    /// holds.
    fn at_levels(&self, model: &Model, levels: &[Option<f64>], base: &Fitted) -> Option<Form> {
        let base_free = model.base != self.given.base;
        let leads = LIMITS.into_iter().filter_map(|limit| {
            let with = self.with_limit(model, limit, levels)?;
            let hypothesis = Hypothesis { effects: vec![limit], base_free, ..Hypothesis::default() };
            let lead = Fitted::at_start(Space::new(hypothesis, &with, &self.given.base, 0.0), &self.fit)?;
            let is_sound = lead.space.is_plausible(&lead.model) && !lead.space.is_base_at_bound(&lead.x);
            (is_sound && self.closes_and_widens_nothing(&lead, base)?).then_some(lead)
        });
        let mut leads: Vec<Fitted> = leads.collect();
        let least = leads.iter().map(Fitted::rms).fold(f64::INFINITY, f64::min);
        leads.retain(|lead| lead.rms() < AS_NEAR * least);
        let others = leads.iter().skip(1).flat_map(|other| &other.space.hypothesis.effects);
        let alternatives = others.map(|limit| (*limit).to_owned()).collect();
        Some(Form { alternatives, ..leads.first()?.clone().into() })
    }

    /// A model with a limit at the levels where positions stand; for a limit of the command, where the steady position is at that level.
    fn with_limit(&self, model: &Model, limit: &str, levels: &[Option<f64>]) -> Option<Model> {
        let limit = find(limit)?;
        let scale = if limit.name == LIMITS[0] { 1.0 } else { model.base.k() };
        let values = levels.iter().zip(limit.parameters);
        let values: Vec<f64> =
            values.map(|(level, parameter)| level.map_or(parameter.neutral, |level| level / scale)).collect();
        Some(Model { effects: self.given.effects.with(limit, &values).ok()?, ..model.clone() })
    }

    /// Whether a lead has a clearly smaller residual on the fit or on the check records than a base without it, and no larger one than the given
    /// model on any record.
    pub fn closes_and_widens_nothing(&self, lead: &Fitted, base: &Fitted) -> Option<bool> {
        let unlimited = Model { effects: self.given.effects.clone(), ..lead.model.clone() };
        let mut closes = false;
        for traces in [&self.fit, &self.check] {
            let (before, after) = (PlainFit::as_it_is(self.given, traces)?, PlainFit::as_it_is(&lead.model, traces)?);
            for ((trace, before), after) in traces.iter().zip(&before.residuals).zip(&after.residuals) {
                if self.leaves_more(lead, [rms(after), rms(before)], std::slice::from_ref(trace))? {
                    return Some(false);
                }
            }
            let others = [&base.model, &unlimited].map(|model| Some(PlainFit::as_it_is(model, traces)?.mean_square()));
            let least = others.into_iter().try_fold(before.mean_square(), |least, other| Some(least.min(other?)))?;
            closes |= after.mean_square() < CLOSES.powi(2) * least;
        }
        Some(closes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{
            Verdict, diagnose,
            three_records::{measured_as, said, three_records},
        },
        signal::record::Record,
    };
    use actuator_fmu::parameters::{PositionUnit, table};

    /// A motor of first order under proportional and integral control, that runs against stops: by Euler's method, a hundred steps a sample.
    fn under_integral_control(command: &[f64], interval_s: f64, integral_gain: f64, stops: [f64; 2]) -> Vec<f64> {
        let [proportional, lag_s] = [25.0, 0.01];
        let step = interval_s / 100.0;
        let (mut position, mut rate, mut integral) = (0.0_f64, 0.0, 0.0);
        let sample = |command: &f64| {
            let before = position;
            for _ in 0..100 {
                let error = command - position;
                integral += integral_gain * error * step;
                rate += (proportional * (error + integral) - rate) / lag_s * step;
                position += rate * step;
                if position <= stops[0] || position >= stops[1] {
                    (position, rate) = (position.clamp(stops[0], stops[1]), 0.0);
                }
            }
            before
        };
        command.iter().map(sample).collect()
    }

    /// The given model and three records of such a motor.
    fn wound_up(integral_gain: f64, stops: [f64; 2]) -> (Model, Vec<Record>) {
        let base = actuator_fmu::parameters::Base::from_values([1.0, 1e4, 50.0, 1.0]).unwrap();
        let given = Model { base, ..Model::from_set(&table()[0]) };
        let records = three_records(&given, 10.0);
        let records = records.iter().map(|record| {
            let noise: Vec<f64> = record.position().iter().map(|z| 0.02 * (1e4 * z).sin()).collect();
            let interval_s = record.sampling().interval_s();
            let moved = under_integral_control(record.command(), interval_s, integral_gain, stops);
            let position = moved.iter().zip(noise).map(|(position, noise)| position + noise).collect();
            Record::new(record.to_command(), position, PositionUnit::default(), record.interpolation(), "wound up")
                .unwrap()
        });
        let records = records.collect();
        (given, records)
    }

    #[test]
    #[ignore = "slow"]
    fn a_stop_leads_though_the_controller_winds_up_at_it_and_that_leaves_most_of_the_difference() {
        let of = |stops: [f64; 2]| {
            let (given, records) = wound_up(15.0, stops);
            said(&given, &records)
        };
        let (verdict, found) = of([-4.0, 5.0]);
        let (name, values, _) = found.unwrap();
        assert!(verdict == Verdict::Leading && name == "position_limit", "{verdict:?} {name}");
        assert!((values[0] + 4.0).abs() < 0.05 && (values[1] - 5.0).abs() < 0.05, "{values:?}");
        let (verdict, found) = of([-1e9, 1e9]);
        assert_eq!((verdict, found), (Verdict::Unexplained, None));
    }

    /// With references that were set anew for each record.
    #[test]
    #[ignore = "slow"]
    fn a_stop_leads_where_its_level_is_off_by_what_the_zeros_of_the_records_are() {
        let (given, records) = wound_up(15.0, [-4.0, 5.0]);
        let of = |zeros: [f64; 3]| {
            let each = records.iter().zip(zeros);
            let anew: Vec<Record> =
                each.map(|(record, zero)| measured_as(record, |_, position| position + zero)).collect();
            said(&given, &anew)
        };
        let (verdict, found) = of([0.35, -0.2, 0.1]);
        let (name, values, _) = found.unwrap();
        assert!(verdict == Verdict::Leading && name == "position_limit", "{verdict:?} {name}");
        assert!((values[0] + 4.0).abs() < 0.3 && (values[1] - 5.0).abs() < 0.3, "{values:?}");
        assert_eq!(of([1.0, -1.0, 0.0]).1, None);
    }

    #[test]
    #[ignore = "slow"]
    fn a_stop_that_positions_show_is_listed_where_winding_up_leaves_no_model_with_less() {
        let (given, records) = wound_up(60.0, [-8.0, 8.5]);
        let diagnosis = diagnose(&given, &records[..2], &records[2..], &[], None).unwrap();
        let lead = diagnosis.leads.iter().find(|lead| lead.name == "position_limit").unwrap();
        assert!(diagnosis.verdict == Verdict::Unexplained && lead.share.is_none(), "{:?} {lead:?}", diagnosis.verdict);
        let [min, max] = ["min", "max"].map(|side| lead.parameters[side]);
        assert!((min + 8.0).abs() < 0.05 && (max - 8.5).abs() < 0.05, "{min} {max}");
    }
}
