//! Limits of rate or acceleration that never saturate for as long as an actuator needs to respond.
//!
//! A limit that saturates long enough produces a rate, or a curvature, that does not depend on the size of the demand. One that releases before the
//! actuator has responded does not show this: it softens the response to large steps, and so does a valve whose flow goes with the root of a
//! pressure, or an inaccurate clock.

use super::{fitted::Fitted, late::lag_s, selection::StructureSelection, trace::Trace};
use crate::{digits::with_unit, signal::record::Record};
use actuator_fmu::parameters::Model;

const COMMAND_RATE_LIMIT: &str = "command_rate_limit";
const LIMITS: [&str; 3] = [COMMAND_RATE_LIMIT, "rate_limit", "acceleration_limit"];

/// Consecutive samples in which a limit of the command's rate must act at least once: fewer are confounded with an inaccurate clock.
const FEWEST_LIMITED_SAMPLES: usize = 2;

/// How long a limit must saturate continuously at least once, in lags of the given base: one of the command's rate, and one of the drive, which
/// saturates at the start of a motion and again at its end.
const LEAST_HELD: f64 = 1.4;
const LEAST_HELD_BY_DRIVE: f64 = 2.0;

impl StructureSelection<'_> {
    /// Why the limit of a lead saturates too briefly to be identified; none where it saturates long enough, or there is no limit.
    pub fn holds_briefly(&self, lead: &Fitted) -> Option<String> {
        let limit = LIMITS.into_iter().find(|limit| lead.space.hypothesis.effects.contains(limit))?;
        let traces: Vec<&Trace<'_>> = self.fit.iter().chain(&self.check).collect();
        too_brief(limit, &lead.model, self.given, &traces)
    }
}

/// Why this limit of a model saturates too briefly in all records, relative to the lag of the given model; none where it saturates long enough or
/// does not act.
fn too_brief(limit: &str, model: &Model, given: &Model, traces: &[&Trace<'_>]) -> Option<String> {
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
    let least_s = lag_s(given) * if of_command.is_some() { LEAST_HELD } else { LEAST_HELD_BY_DRIVE };
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

    #[test]
    fn a_limit_that_lets_go_before_the_actuator_answers_is_too_brief() {
        let base = Base::from_values([1.0, 1e4, 30.0, 0.8]).unwrap();
        let given = Model { base, ..Model::from_set(&table()[0]) };
        let excitation = Excitation { duration_s: 20.0, amplitude: 5.0, ..Excitation::new(Kind::Steps) };
        let (interpolation, noise_share) = (Interpolation::Held, 0.0);
        let point =
            TestPoint { model: given.clone(), excitation, interpolation, noise_share, turbulence: None, seed: 1 };
        let record = point.record("steps").unwrap();
        let trace = Trace::new(&record, &base);
        let reason = |limit: &str, values: &[f64]| {
            let effects = Effects::default().with(find(limit).unwrap(), values).unwrap();
            too_brief(limit, &Model { effects, ..given.clone() }, &given, &[&trace])
        };
        // The rate at which the longest step takes this many lags.
        let longest = record.command().windows(2).map(|ends| (ends[1] - ends[0]).abs()).fold(0.0, f64::max);
        let rate_of = |lags: f64| [longest / (lags * lag_s(&given)); 2];
        assert!(reason(COMMAND_RATE_LIMIT, &rate_of(1.2)).unwrap().starts_with("it saturates continuously for"));
        assert!(reason(COMMAND_RATE_LIMIT, &[5000.0; 2]).unwrap().ends_with("a clock offset does the same"));
        assert_eq!(reason(COMMAND_RATE_LIMIT, &rate_of(1.6)), None);
        // In a step of 1 deg a linear actuator reaches a rate of at most 0.42 ω, and its servo demands an acceleration of ω².
        let omega = base.omega();
        let of_drive = [
            ("rate_limit", vec![0.35 * omega * longest; 2], vec![0.15 * omega * longest; 2]),
            ("acceleration_limit", vec![0.6 * omega.powi(2) * longest], vec![0.03 * omega.powi(2) * longest]),
        ];
        for (limit, brief, long) in of_drive {
            assert!(reason(limit, &brief).unwrap().starts_with("it saturates continuously for"), "{limit}");
            assert_eq!(reason(limit, &long), None, "{limit}");
        }
    }
}
