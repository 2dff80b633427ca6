//! Limits of rate or acceleration that never saturate for as long as an actuator needs to respond.
//!
//! A limit that saturates long enough produces a rate, or a curvature, that does not depend on the size of the demand. One that releases before the
//! actuator has responded does not show this: it softens the response to large steps, and so does a valve whose flow goes with the root of a
//! pressure, or an inaccurate clock. A rate that grows with the root of the demand leaves a part of the difference beside a limit, which a limit that is
//! there does not.

use super::{given_effects::delay_s, late::lag_s, outcome::Form, selection::StructureSelection, trace::Trace};
use crate::{digits::with_unit, signal::record::Record};
use actuator_fmu::parameters::Model;

const COMMAND_RATE_LIMIT: &str = "command_rate_limit";
const LIMITS: [&str; 3] = [COMMAND_RATE_LIMIT, "rate_limit", "acceleration_limit"];

/// Consecutive samples in which a limit of the command's rate must act at least once: fewer are confounded with an inaccurate clock.
const FEWEST_LIMITED_SAMPLES: usize = 2;

/// How long a limit must saturate continuously at least once, in lags of the actuator: one of the command's rate, and one of the drive, which
/// saturates at the start of a motion and again at its end. The second of each where the limit explains nearly all that any base leaves.
const LEAST_HELD_OF_COMMAND: [f64; 2] = [1.4, 0.7];
const LEAST_HELD_BY_DRIVE: [f64; 2] = [2.0, 1.4];

impl StructureSelection<'_> {
    /// Why the limit of a lead saturates too briefly to be identified; none where it saturates long enough, or there is no limit.
    pub fn holds_briefly(&self, lead: &Form) -> Option<String> {
        let Form { fitted, is_nearly_all, .. } = lead;
        let limit = LIMITS.into_iter().find(|limit| fitted.space.hypothesis.effects.contains(limit))?;
        let traces: Vec<&Trace<'_>> = self.fit.iter().chain(&self.check).collect();
        too_brief(limit, &fitted.model, self.given, &traces, *is_nearly_all)
    }
}

/// Why this limit of a model saturates too briefly in all records, relative to the lag of the actuator; none where it saturates long enough or does
/// not act. The lag is the shorter one of the given model and of this one: a model that was fitted to limited motion contains the lag of the limit.
/// A limit that explains nearly all that any base leaves need not saturate for as long.
fn too_brief(limit: &str, model: &Model, given: &Model, traces: &[&Trace<'_>], is_nearly_all: bool) -> Option<String> {
    let values = model.effects.active_values_of(limit)?;
    let of_command = (limit == COMMAND_RATE_LIMIT).then(|| [values[0], values[1]]);
    if of_command.is_some_and(|rates| traces.iter().all(|trace| is_of_clock(rates, trace.record))) {
        return Some(
            "it acts only at steps of the command, for one sample each: a clock offset does the same".to_owned(),
        );
    }
    let held = traces.iter().map(|trace| match of_command {
        Some(rates) => longest_limited_s(rates, trace.record),
        None => longest_saturated_s(model, trace).unwrap_or(0.0),
    });
    let longest_s = held.fold(0.0, f64::max);
    let lag_s = lag_s(given).min(lag_s(model) + delay_s(model));
    let least = if of_command.is_some() { LEAST_HELD_OF_COMMAND } else { LEAST_HELD_BY_DRIVE };
    let least_s = lag_s * least[usize::from(is_nearly_all)];
    (longest_s < least_s).then(|| {
        format!(
            "it saturates continuously for at most {}; for less than {}, while the actuator responds, anything that softens large steps looks the same",
            with_unit(longest_s, 2, "s"),
            with_unit(least_s, 2, "s")
        )
    })
}

/// Longest time for which a limit of the command's rate saturates in a record [s].
fn longest_limited_s([up, down]: [f64; 2], record: &Record) -> f64 {
    let (mut limited, mut held, mut longest) = (record.command()[0], 0.0_f64, 0.0_f64);
    for step in record.steps() {
        let missing = step.command.value - limited;
        let needed = if missing > 0.0 { missing / up } else { -missing / down };
        held += needed.min(step.duration);
        longest = longest.max(held);
        limited += missing.clamp(-down * step.duration, up * step.duration);
        if needed < step.duration {
            held = 0.0;
        }
    }
    longest
}

/// Longest time for which a limit of the drive saturates in the motion of a model [s]; none where it diverges.
fn longest_saturated_s(model: &Model, trace: &Trace<'_>) -> Option<f64> {
    let saturated = trace.motion(model)?.saturated;
    let steps = trace.record.time().windows(2).map(|ends| ends[1] - ends[0]);
    let (mut held, mut longest) = (0.0_f64, 0.0_f64);
    for (duration, saturated) in steps.zip(saturated.into_iter().skip(1)) {
        held = if saturated { held + duration } else { 0.0 };
        longest = longest.max(held);
    }
    Some(longest)
}

/// Whether a limit of the command's rate acts in a record for a single sample at a time, if at all: a command that is read, or takes effect, a
/// fraction of a sample later looks the same.
fn is_of_clock(rates: [f64; 2], record: &Record) -> bool {
    let [up, down] = rates;
    let (mut limited, mut samples) = (record.command()[0], 0);
    record.steps().all(|step| {
        let wanted = step.command.value;
        let change = (wanted - limited).clamp(-down * step.duration, up * step.duration);
        samples = if change == wanted - limited { 0 } else { samples + 1 };
        limited += change;
        samples < FEWEST_LIMITED_SAMPLES
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{hypothesis::Hypothesis, plain_fit::PlainFit, space::Space, unseen::NEARLY_NOTHING},
        generated::TestPoint,
        signal::{
            Command, Interpolation,
            excitation::{Excitation, Kind},
        },
        simulate::simulate,
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Base, PositionUnit, table},
    };

    /// Steps of 10 deg and a sine with an amplitude of 10 deg at 2 Hz, at 100 samples/s.
    #[test]
    fn a_rate_that_only_steps_meet_for_one_sample_is_a_matter_of_the_clock() {
        let time: Vec<f64> = (0..500).map(|n| f64::from(n) / 100.0).collect();
        let record = |of: fn(f64) -> f64| {
            let command: Vec<f64> = time.iter().map(|t| of(*t)).collect();
            let (unit, held) = (PositionUnit::default(), Interpolation::Held);
            Record::new(Command { time: time.clone(), command: command.clone() }, command, unit, held, "record")
                .unwrap()
        };
        let steps = record(|t| if (2.0 * t + 1e-9).floor() % 2.0 == 0.0 { -5.0 } else { 5.0 });
        let sine = record(|t| 10.0 * (std::f64::consts::TAU * 2.0 * t).sin());
        // 1.25 and 2.5 samples for a step.
        assert!(is_of_clock([800.0; 2], &steps) && !is_of_clock([800.0, 400.0], &steps));
        assert!(!is_of_clock([100.0; 2], &sine));
    }

    #[test]
    fn a_limit_holds_for_as_long_as_the_command_is_ahead_of_it() {
        let time: Vec<f64> = (0..500).map(|n| f64::from(n) / 100.0).collect();
        let command: Vec<f64> = time.iter().map(|t| if t.rem_euclid(2.0) < 1.0 { -5.0 } else { 5.0 }).collect();
        let made = Command { time, command: command.clone() };
        let steps = Record::new(made, command, PositionUnit::default(), Interpolation::Held, "steps").unwrap();
        // 10 deg at 32 deg/s up, and at 100 deg/s down.
        assert!((longest_limited_s([32.0, 100.0], &steps) - 0.3125).abs() < 1e-9);
        assert!((longest_limited_s([200.0, 100.0], &steps) - 0.1).abs() < 1e-9);
    }

    #[test]
    fn the_lag_of_a_base_is_that_behind_a_ramp() {
        for set in table() {
            let model = Model::from_set(set);
            let time: Vec<f64> = (0..4000).map(|n| f64::from(n) / 1000.0).collect();
            let ramp = Command { command: time.clone(), time };
            let moved = simulate(&model, &ramp, Interpolation::Linear).unwrap().position;
            let late = ramp.time[3999] - moved[3999] / model.base.k();
            assert!((late - lag_s(&model)).abs() < 1e-6, "{late}");
        }
    }

    /// A model without effects, and steps that it follows.
    fn given_and_steps() -> (Model, Record) {
        let base = Base::from_values([1.0, 1e4, 30.0, 0.8]).unwrap();
        let given = Model { base, ..Model::from_set(&table()[0]) };
        let excitation = Excitation { duration_s: 20.0, amplitude: 5.0, ..Excitation::new(Kind::Steps) };
        let (interpolation, noise_share) = (Interpolation::Held, 0.0);
        let model = given.clone();
        let point = TestPoint { model, excitation, interpolation, noise_share, turbulence: None, seed: 1 };
        (given, point.record("steps").unwrap())
    }

    fn longest_step(record: &Record) -> f64 {
        record.command().windows(2).map(|ends| (ends[1] - ends[0]).abs()).fold(0.0, f64::max)
    }

    fn limited(model: &Model, limit: &str, values: &[f64]) -> Model {
        Model { effects: Effects::default().with(find(limit).unwrap(), values).unwrap(), ..model.clone() }
    }

    #[test]
    fn a_limit_that_lets_go_before_the_actuator_answers_is_too_brief() {
        let (given, record) = given_and_steps();
        let trace = Trace::new(&record, &given.base);
        let reason =
            |limit: &str, values: &[f64]| too_brief(limit, &limited(&given, limit, values), &given, &[&trace], false);
        // The rate at which the longest step takes this many lags.
        let longest = longest_step(&record);
        let rate_of = |lags: f64| [longest / (lags * lag_s(&given)); 2];
        assert!(reason(COMMAND_RATE_LIMIT, &rate_of(1.2)).unwrap().starts_with("it saturates continuously for"));
        assert!(reason(COMMAND_RATE_LIMIT, &[5000.0; 2]).unwrap().ends_with("a clock offset does the same"));
        assert_eq!(reason(COMMAND_RATE_LIMIT, &rate_of(1.6)), None);
        // In a step of 1 deg a linear actuator reaches a rate of at most 0.42 ω, and its servo demands an acceleration of ω².
        let omega = given.base.omega();
        let of_drive = [
            ("rate_limit", vec![0.35 * omega * longest; 2], vec![0.15 * omega * longest; 2]),
            ("acceleration_limit", vec![0.6 * omega.powi(2) * longest], vec![0.03 * omega.powi(2) * longest]),
        ];
        for (limit, brief, long) in of_drive {
            assert!(reason(limit, &brief).unwrap().starts_with("it saturates continuously for"), "{limit}");
            assert_eq!(reason(limit, &long), None, "{limit}");
        }
    }

    #[test]
    fn a_limit_of_the_drive_that_explains_nearly_all_need_not_saturate_for_two_lags() {
        let (given, record) = given_and_steps();
        let trace = Trace::new(&record, &given.base);
        let reason = |share: f64, is_nearly_all: bool| {
            let rate = share * given.base.omega() * longest_step(&record);
            let limited = limited(&given, "rate_limit", &[rate; 2]);
            let held_s = longest_saturated_s(&limited, &trace).unwrap();
            (held_s / lag_s(&given), too_brief("rate_limit", &limited, &given, &[&trace], is_nearly_all))
        };
        let (lags, _) = reason(0.23, false);
        assert!(lags > 1.4 && lags < 2.0, "{lags}");
        assert!(reason(0.23, false).1.is_some() && reason(0.23, true).1.is_none());
        assert!(reason(0.35, true).1.is_some());
    }

    #[test]
    fn a_limit_of_the_command_that_explains_nearly_all_need_not_saturate_for_a_whole_lag() {
        let (given, record) = given_and_steps();
        let trace = Trace::new(&record, &given.base);
        let is_brief = |lags: f64, is_nearly_all: bool| {
            let limited = limited(&given, COMMAND_RATE_LIMIT, &[longest_step(&record) / (lags * lag_s(&given)); 2]);
            too_brief(COMMAND_RATE_LIMIT, &limited, &given, &[&trace], is_nearly_all).is_some()
        };
        assert!(is_brief(0.8, false) && !is_brief(0.8, true) && is_brief(0.6, true));
    }

    /// A model that was fitted to limited motion is slower than the actuator.
    #[test]
    fn the_lag_is_that_of_the_actuator_and_not_of_a_model_that_contains_the_limit() {
        let (actuator, record) = given_and_steps();
        let trace = Trace::new(&record, &actuator.base);
        let rate = 0.15 * actuator.base.omega() * longest_step(&record);
        let found = limited(&actuator, "rate_limit", &[rate; 2]);
        let slow = Model { base: Base::from_values([1.0, 1e4, 10.0, 0.9]).unwrap(), ..actuator.clone() };
        assert!(longest_saturated_s(&found, &trace).unwrap() < 2.0 * lag_s(&slow));
        assert_eq!(too_brief("rate_limit", &found, &slow, &[&trace], false), None);
        // Beside the slow base itself, its lag counts.
        let beside_slow = limited(&slow, "rate_limit", &[rate; 2]);
        assert!(too_brief("rate_limit", &beside_slow, &slow, &[&trace], false).is_some());
    }

    /// The position of a first-order servo whose rate is some function of the demanded one, in steps that are short relative to its time constant.
    fn servo(record: &Record, rate_of: impl Fn(f64) -> f64) -> Record {
        const GAIN_PER_S: f64 = 15.0;
        const SHORT_STEPS: u32 = 50;
        let mut position = vec![0.0];
        for (ends, command) in record.time().windows(2).zip(record.command()) {
            let mut now = position[position.len() - 1];
            let step_s = (ends[1] - ends[0]) / f64::from(SHORT_STEPS);
            (0..SHORT_STEPS).for_each(|_| now += step_s * rate_of(GAIN_PER_S * (command - now)));
            position.push(now);
        }
        Record::new(record.to_command(), position, record.unit(), record.interpolation(), "servo").unwrap()
    }

    /// A model with a limit of this rate, fitted beside a free base to the motion of a servo, and the share that it leaves of what such a base does.
    fn explained(servo: &Record, given: &Model, limit: &'static str, rate: f64) -> (Model, f64) {
        let traces = [Trace::new(servo, &given.base)];
        let fit = |effects: Vec<&'static str>, model: &Model| {
            let hypothesis = Hypothesis { effects, base_free: true, wide: true, ..Hypothesis::default() };
            PlainFit::search(Space::new(hypothesis, model, &given.base, 0.0), &traces, 40).unwrap()
        };
        let with = fit(vec![limit], &limited(given, limit, &[rate; 2]));
        let left = with.mean_square() / fit(Vec::new(), given).mean_square();
        (with.model, left)
    }

    /// How long a limit of the drive saturates in a record, in lags of its base.
    fn held_in_lags(model: &Model, record: &Record) -> f64 {
        longest_saturated_s(model, &Trace::new(record, &model.base)).unwrap() / (lag_s(model) + delay_s(model))
    }

    #[test]
    fn a_rate_that_grows_with_the_root_of_the_demand_seems_limited_for_less_than_two_lags_and_leaves_a_part() {
        let (given, record) = given_and_steps();
        let longest = longest_step(&record);
        for rate in [0.5 * longest, 2.0 * longest, 4.0 * longest] {
            let servo = servo(&record, |demanded| demanded / (1.0 + (demanded / rate).abs()).sqrt());
            let (found, left) = explained(&servo, &given, "rate_limit", rate);
            let lags = held_in_lags(&found, &servo);
            assert!(lags < LEAST_HELD_BY_DRIVE[0] && left > NEARLY_NOTHING, "{lags} {left}");
            for start in [5.0, 10.0, 20.0, 40.0] {
                let (_, left) = explained(&servo, &given, COMMAND_RATE_LIMIT, start * longest);
                assert!(left > 5.0 * NEARLY_NOTHING, "{left}");
            }
        }
        let rate = 6.0 * longest;
        let servo = servo(&record, |demanded| demanded.clamp(-rate, rate));
        let (found, left) = explained(&servo, &given, "rate_limit", rate);
        let lags = held_in_lags(&found, &servo);
        let [least, least_of_all] = LEAST_HELD_BY_DRIVE;
        assert!(lags > least_of_all && lags < least && left < 0.01 * NEARLY_NOTHING, "{lags} {left}");
    }
}
