//! Thinned records: used by wide searches and cross-validation, so that their time depends on the motion and not on the logger.
//!
//! ```text
//! c'[m] = mean of the command over a group, held through it,    y'[m] = y at the start of the group,    the load as the command
//! ```
//!
//! The command keeps its area, so that a system that is slow relative to a group moves as before. For a command that is linear between samples, the
//! first sample of each group would not suffice: a step would become a ramp that begins up to a group early.

use crate::{
    inspect::{laguerre, spectrum},
    signal::{
        Command, Interpolation,
        record::{FEWEST_SAMPLES, Record},
    },
};

/// How far records are thinned.
#[derive(Debug, Clone, Copy)]
pub struct Thinning {
    /// Samples in a period of the fastest motion.
    pub samples_per_period: f64,
    /// Samples of all records together, above which only the liveliest stretch of each is used.
    pub most_samples: usize,
    /// Whether records are thinned no further than to that number.
    pub only_as_needed: bool,
}

impl Thinning {
    /// For searches of the structure by likelihood: the grouping changes the fastest motion by a two-thousandth.
    pub const FINE: Self = Self { samples_per_period: 60.0, most_samples: 7_000, only_as_needed: false };
    /// For the same where stretches do not suffice.
    pub const WHOLE: Self = Self { samples_per_period: 24.0, most_samples: 22_000, only_as_needed: true };
    /// For wide searches and cross-validation by plain output error: by three thousandths.
    pub const COARSE: Self = Self { samples_per_period: 24.0, most_samples: 6_000, only_as_needed: false };
}

/// Samples of all records together up to which structures are searched on the whole records.
pub const MOST_SAMPLES_WHOLE: usize = 24_000;

/// Fewest samples of a stretch.
const SHORTEST_STRETCH: usize = 1500;

/// The records, thinned as far as motions up to a bandwidth [Hz] remain unchanged, and cut to stretches where they are longer.
pub fn thinned(records: &[&Record], bandwidth_hz: f64, thinning: Thinning) -> Vec<Record> {
    let most = (thinning.most_samples / records.len().max(1)).max(SHORTEST_STRETCH);
    let coarsest = |record: &Record| if thinning.only_as_needed { record.len().div_ceil(most) } else { usize::MAX };
    let thin = |record| thin(record, bandwidth_hz, thinning.samples_per_period, coarsest(record));
    records.iter().map(|record| liveliest(thin(record), most)).collect()
}

/// Whether a thinned record lacks a part of its record.
pub fn is_stretch(thinned: &Record, record: &Record) -> bool {
    /// Share of the duration; the last group may be cut off.
    const WHOLE: f64 = 0.98;
    let duration =
        |record: &Record| record.time().last().zip(record.time().first()).map_or(0.0, |(end, start)| end - start);
    duration(thinned) < WHOLE * duration(record)
}

fn thin(record: &Record, bandwidth_hz: f64, samples_per_period: f64, coarsest: usize) -> Record {
    let interval = record.sampling().interval_s();
    let moved = spectrum::reach_hz(record.position(), interval);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small count
    let group = (1.0 / (interval * samples_per_period * moved.max(bandwidth_hz))).floor() as usize;
    let group = group.min(coarsest);
    if group < 2 || record.len() / group < 2 * FEWEST_SAMPLES {
        return record.clone();
    }
    let time = record.time();
    let starts = || (0..record.len() - 1).step_by(group);
    let mean_over_group = |values: &[f64], start: usize| {
        let end = (start + group).min(record.len() - 1);
        let mean = |n: usize| match record.interpolation() {
            Interpolation::Held => values[n],
            Interpolation::Linear => 0.5 * (values[n] + values[n + 1]),
        };
        let area: f64 = (start..end).map(|n| mean(n) * (time[n + 1] - time[n])).sum();
        area / (time[end] - time[start])
    };
    let of_groups = |values: &[f64]| starts().map(|start| mean_over_group(values, start)).collect::<Vec<f64>>();
    let thin = Command { time: starts().map(|start| time[start]).collect(), command: of_groups(record.command()) };
    let position = starts().map(|start| record.position()[start]).collect();
    let made = Record::new(thin, position, record.unit(), Interpolation::Held, record.source());
    let load = record.load().map(of_groups);
    made.map_or_else(
        |_| record.clone(),
        |made| made.with_load(load).with_offset_s(record.offset_s()).slipped_as(record),
    )
}

/// The stretch with the largest sum of three shares of the record: motion of the command, its range, and power of the residual of a linear model. An
/// effect may act in few parts.
fn liveliest(record: Record, most: usize) -> Record {
    if record.len() <= most {
        return record;
    }
    let motion = |values: &[f64]| -> f64 { values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum() };
    let range = |values: &[f64]| {
        let ends = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        ends.1 - ends.0
    };
    let whole = record.command();
    let (all_motion, all_range) = (motion(whole).max(f64::MIN_POSITIVE), range(whole).max(f64::MIN_POSITIVE));
    let left = laguerre::fit(whole, record.position()).residual;
    let power = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
    let all_power = power(&left).max(f64::MIN_POSITIVE);
    let life = |start: usize| {
        let part = start..start + most;
        let stretch = &whole[part.clone()];
        motion(stretch) / all_motion + range(stretch) / all_range + power(&left[part]) / all_power
    };
    let starts = (0..=record.len() - most).step_by(most / 4);
    let start = starts.max_by(|a, b| life(*a).total_cmp(&life(*b))).unwrap_or_default();
    record.stretch(start..start + most).unwrap_or(record)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::trace::Trace,
        generated::TestPoint,
        signal::excitation::{Excitation, Kind},
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Base, Model, PositionUnit, table},
    };

    /// A gain that drifts, in a stretch of a thinned stretch.
    #[test]
    fn a_stretch_knows_when_in_its_record_it_began() {
        let drift = find("gain_drift").unwrap();
        let effects = Effects::default().with(drift, &[-0.01]).unwrap();
        let model = Model { effects, ..Model::from_set(&table()[0]) };
        let excitation = Excitation { duration_s: 60.0, ..Excitation::new(Kind::Sweep) };
        let interpolation = Interpolation::Held;
        let point =
            TestPoint { model: model.clone(), excitation, interpolation, noise_share: 0.0, turbulence: None, seed: 1 };
        let whole = point.record("whole").unwrap();
        let late = whole.stretch(4000..whole.len()).unwrap();
        let thin =
            thinned(&[&late], 2.0, Thinning { samples_per_period: 5.0, most_samples: 1500, only_as_needed: false })
                .remove(0);
        assert!(thin.offset_s() >= 20.0 && thin.len() < late.len(), "{} {}", thin.offset_s(), thin.len());
        let left = |record: &Record| {
            let trace = Trace::new(record, &model.base);
            let simulated = trace.position(&model).unwrap();
            let pairs = record.position().iter().zip(&simulated).skip(trace.settling);
            pairs.map(|(measured, simulated)| (measured - simulated).abs()).fold(0.0, f64::max)
        };
        let forgetful = late.clone().with_offset_s(0.0);
        assert!(left(&late) < 1e-5 && left(&forgetful) > 0.1, "{} {}", left(&late), left(&forgetful));
    }

    /// A sweep whose fast end, where the command moves most, is too weak for the stops.
    #[test]
    fn a_stretch_is_where_the_effect_is() {
        let limit = find("position_limit").unwrap();
        let effects = Effects::default().with(limit, &[-3.0, 3.0]).unwrap();
        let base = Base::from_values([1.0, 400.0, 12.0, 1.0]).unwrap();
        let model = Model { base, effects, ..Model::from_set(&table()[0]) };
        let excitation = Excitation { duration_s: 60.0, amplitude: 4.0, ..Excitation::new(Kind::Sweep) };
        let interpolation = Interpolation::Held;
        let point = TestPoint { model, excitation, interpolation, noise_share: 0.01, turbulence: None, seed: 1 };
        let whole = point.record("whole").unwrap();
        let at_stop = |record: &Record| record.position().iter().filter(|position| position.abs() > 2.95).count();
        let stretch =
            thinned(&[&whole], 1e3, Thinning { samples_per_period: 24.0, most_samples: 3000, only_as_needed: false })
                .remove(0);
        assert!(stretch.len() == 3000 && whole.len() > 11_000, "{}", stretch.len());
        assert!(2 * at_stop(&stretch) > at_stop(&whole), "{} {}", at_stop(&stretch), at_stop(&whole));
    }

    /// A load that moves the position, in a record that is thinned.
    #[test]
    fn a_load_is_thinned_with_its_record() {
        let load = find("hinge_load").unwrap();
        let effects = Effects::default().with(load, &[0.5, 0.0]).unwrap();
        let base = Base::from_values([1.0, 400.0, 25.0, 0.7]).unwrap();
        let model = Model { base, effects, ..Model::from_set(&table()[0]) };
        let of =
            |function: &dyn Fn(f64) -> f64| (0..20_000).map(|n| function(f64::from(n) / 2000.0)).collect::<Vec<f64>>();
        let command = Command { time: of(&|t| t), command: of(&|t| (5.0 * t).sin()) };
        let made = |position: Vec<f64>| {
            let (unit, held) = (PositionUnit::default(), Interpolation::Held);
            let record = Record::new(command.clone(), position, unit, held, "loaded").unwrap();
            record.with_load(Some(of(&|t| (7.0 * t).cos())))
        };
        let whole = made(Trace::new(&made(vec![0.0; 20_000]), &base).position(&model).unwrap());
        let thin = thinned(&[&whole], 4.0, Thinning::COARSE).remove(0);
        assert!(thin.len() < 3000, "{}", thin.len());
        let left = |record: &Record| {
            let trace = Trace::new(record, &base);
            let simulated = trace.position(&model).unwrap();
            let pairs = simulated.iter().zip(record.position()).skip(trace.settling);
            pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
        };
        let [with, without] = [left(&thin), left(&thin.clone().with_load(None))];
        assert!(with < 0.01 && without > 0.3, "{with} {without}");
    }

    /// A step in one sample, and one in the midst of a group.
    #[test]
    fn a_step_of_a_linear_command_stays_where_it_is() {
        let time: Vec<f64> = (0..20_001).map(|n| f64::from(n) / 2000.0).collect();
        let command: Vec<f64> = (0..20_001).map(|n| if (4007..12_000).contains(&n) { 1.0 } else { 0.0 }).collect();
        let made = |position| {
            let command = Command { time: time.clone(), command: command.clone() };
            Record::new(command, position, PositionUnit::default(), Interpolation::Linear, "steps").unwrap()
        };
        let base = Base::from_values([1.0, 400.0, 25.0, 0.7]).unwrap();
        let model = Model { base, ..Model::from_set(&table()[0]) };
        let whole = made(Trace::new(&made(vec![0.0; 20_001]), &base).position(&model).unwrap());
        let thin = thinned(&[&whole], 4.0, Thinning::COARSE).remove(0);
        assert!(thin.len() < 3000, "{}", thin.len());
        let simulated = Trace::new(&thin, &base).position(&model).unwrap();
        let furthest =
            simulated.iter().zip(thin.position()).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        // A ramp that began up to a group early would be 0.04 off.
        assert!(furthest < 0.01, "{furthest}");
    }

    #[test]
    fn a_whole_record_is_thinned_no_further_than_needed_and_cut_only_where_that_does_not_do() {
        let time: Vec<f64> = (0..64_000).map(|n| f64::from(n) / 2000.0).collect();
        let slow: Vec<f64> = time.iter().map(|t| t.sin()).collect();
        let command = Command { time, command: slow.clone() };
        let record = Record::new(command, slow, PositionUnit::default(), Interpolation::Held, "sine").unwrap();
        let whole = thinned(&[&record], 10.0, Thinning::WHOLE).remove(0);
        assert!(!is_stretch(&whole, &record));
        assert_eq!(whole.len(), 64_000 / 3, "every third, not every eighth as the bandwidth allows");
        // A bandwidth that leaves every other sample.
        assert!(is_stretch(&thinned(&[&record], 41.0, Thinning::WHOLE)[0], &record));
        assert!(is_stretch(&thinned(&[&record], 10.0, Thinning::FINE)[0], &record));
    }

    #[test]
    fn a_fast_logger_is_thinned_and_the_area_of_the_command_kept() {
        let time: Vec<f64> = (0..20_001).map(|n| f64::from(n) / 2000.0).collect();
        let command: Vec<f64> = time.iter().map(|t| (std::f64::consts::TAU * t).sin()).collect();
        let whole = Command { time, command: command.clone() };
        let record = Record::new(whole, command, PositionUnit::default(), Interpolation::Held, "sine").unwrap();
        let thin = thinned(&[&record], 4.0, Thinning::COARSE).remove(0);
        assert!(thin.len() < 1200, "{}", thin.len());
        let area = |record: &Record| -> f64 {
            record.time().windows(2).zip(record.command()).map(|(pair, c)| c * (pair[1] - pair[0])).sum()
        };
        assert!((area(&thin) - area(&record)).abs() < 0.02);
        assert_eq!(thinned(&[&record], 100.0, Thinning::COARSE)[0].len(), 6_000);
    }
}
