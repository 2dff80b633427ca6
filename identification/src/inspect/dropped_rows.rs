//! Rows dropped by a logger, reinserted: the command, which a simulation needs, but not the measurement.
//!
//! A held command with a dropped row would be simulated with its previous value, i.e. with a lag. On a clock that is even except for such
//! rows the missing command is interpolated between its neighbours, by the polynomial or the hold that best predicts the existing rows.
//! Inserted positions are not measured: they are excluded from all fits and residuals.

use super::sampling::Clock;
use crate::signal::record::Record;

/// Maximum deviation of times from an even grid, in intervals, for such a clock.
const GRID_SHARE: f64 = 0.02;
/// Maximum fraction of dropped rows: with more, too few remain between them.
const MOST_DROPPED: f64 = 0.35;
/// Number of neighbours on either side for a polynomial.
const REACHES: [usize; 2] = [3, 1];

/// The record with its dropped rows reinserted; unchanged if its clock is uneven for other reasons.
#[must_use]
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of samples
pub fn completed(record: Record, clock: &Clock) -> Record {
    let time = record.time();
    let places: Vec<usize> =
        time.iter().map(|at| ((at - time[0]) / clock.interval_s).round().max(0.0) as usize).collect();
    let count = places[places.len() - 1] + 1;
    let interval = (time[time.len() - 1] - time[0]) / (count - 1).max(1) as f64;
    let is_even = time
        .iter()
        .zip(&places)
        .all(|(at, place)| (at - time[0] - *place as f64 * interval).abs() < GRID_SHARE * interval);
    let increases = places.windows(2).all(|pair| pair[0] < pair[1]);
    let dropped = count.saturating_sub(time.len());
    if dropped == 0 || !is_even || !increases || dropped as f64 > MOST_DROPPED * count as f64 {
        return record;
    }
    let mut is_measured = vec![false; count];
    places.iter().for_each(|place| is_measured[*place] = true);
    let start = time[0];
    let filled = |values: &[f64]| filled(values, &places, &is_measured);
    let time = (0..count).map(|place| start + place as f64 * interval).collect();
    let (command, position) = (filled(record.command()), filled(record.position()));
    let load = record.load().map(filled);
    record.with_rows_put_in(time, command, position, load, is_measured)
}

/// Values at grid indices, interpolated from their neighbours in between.
fn filled(values: &[f64], places: &[usize], is_measured: &[bool]) -> Vec<f64> {
    let reach = best_reach(values, places);
    let mut next = 0;
    is_measured
        .iter()
        .enumerate()
        .map(|(place, measured)| {
            if *measured {
                next += 1;
                return values[next - 1];
            }
            between(values, places, next, place, reach)
        })
        .collect()
}

/// Number of neighbours that best predicts existing values; `None` for a hold.
fn best_reach(values: &[f64], places: &[usize]) -> Option<usize> {
    let widest = REACHES[0];
    let regular: Vec<usize> = (widest..values.len().saturating_sub(widest))
        .filter(|index| places[index + widest] - places[index - widest] == 2 * widest)
        .collect();
    let missed = |reach: Option<usize>| {
        let errors = regular.iter().map(|&index| {
            let without = |of: &[f64]| [&of[..widest], &of[widest + 1..]].concat();
            let around = index - widest..=index + widest;
            let near: Vec<f64> = without(&values[around.clone()]);
            #[allow(clippy::cast_precision_loss)] // small counts
            let at: Vec<usize> = [&places[index - widest..index], &places[index + 1..=index + widest]].concat();
            between(&near, &at, widest, places[index], reach) - values[index]
        });
        // Square roots: one large error at a step counts less than two of half the size.
        errors.map(|error: f64| error.abs().sqrt()).sum::<f64>()
    };
    let tried = REACHES.map(Some).into_iter().chain([None]);
    tried.min_by(|a, b| missed(*a).total_cmp(&missed(*b))).flatten()
}

/// The value at a grid index before the value with index `next`, through `reach` neighbours on either side (Lagrange's polynomial).
#[allow(clippy::cast_precision_loss)] // counts of samples
fn between(values: &[f64], places: &[usize], next: usize, place: usize, reach: Option<usize>) -> f64 {
    let Some(reach) = reach else { return values[next - 1] };
    let near = next.saturating_sub(reach)..(next + reach).min(values.len());
    let distance = |index: usize| places[index] as f64 - place as f64;
    let weight = |index: usize| -> f64 {
        let others = near.clone().filter(|other| *other != index);
        others.map(|other| distance(other) / (distance(other) - distance(index))).product()
    };
    near.clone().map(|index| weight(index) * values[index]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        inspect::sampling::clock,
        signal::{Command, Interpolation},
    };
    use actuator_fmu::parameters::PositionUnit;

    fn with_losses(of: impl Fn(f64) -> f64) -> (Record, Vec<f64>) {
        let all: Vec<f64> = (0..400).map(|n| 0.005 * f64::from(n)).collect();
        let kept = |n: usize| n % 9 != 4 && n % 31 != 7;
        let time: Vec<f64> = (0..400).filter(|n| kept(*n)).map(|n| all[n]).collect();
        let command: Vec<f64> = time.iter().map(|t| of(*t)).collect();
        let whole = all.iter().map(|t| of(*t)).collect();
        let position = command.clone();
        let record =
            Record::new(Command { time, command }, position, PositionUnit::default(), Interpolation::Held, "lossy");
        (record.unwrap(), whole)
    }

    #[test]
    fn a_smooth_command_is_put_back_by_a_polynomial_and_the_measurement_is_not() {
        let (record, whole) = with_losses(|t| (std::f64::consts::TAU * 8.0 * t).sin());
        let lost = whole.len() - record.len();
        let clock = clock(record.time());
        let record = completed(record, &clock);
        assert_eq!(record.len(), whole.len());
        assert_eq!((0..record.len()).filter(|n| !record.is_measured(*n)).count(), lost);
        let worst = record.command().iter().zip(&whole).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 2e-3, "{worst}");
    }

    #[test]
    fn a_command_in_steps_is_held() {
        let (record, _) = with_losses(|t| (t / 0.1 + 1e-9).floor() % 2.0);
        let clock = clock(record.time());
        let record = completed(record, &clock);
        assert!(record.command().iter().all(|value| *value == 0.0 || *value == 1.0));
    }

    #[test]
    fn uneven_times_stay_as_they_are() {
        let time: Vec<f64> = (0..200).map(|n| 0.005 * (f64::from(n) + 0.2 * f64::from(n).sin())).collect();
        let command: Vec<f64> = time.iter().map(|t| (30.0 * t).sin()).collect();
        let record = Record::new(
            Command { time, command: command.clone() },
            command,
            PositionUnit::default(),
            Interpolation::Held,
            "jitter",
        )
        .unwrap();
        let clock = clock(record.time());
        assert_eq!(completed(record.clone(), &clock), record);
    }
}
