//! Values of a record: ends of the range, columns at rest, numbers beyond arithmetic.

use super::finding::Finding;

/// Maximum magnitude of a value [its unit]: limits of inactive effects start at 1e9, and squares must not overflow.
pub const GREATEST: f64 = 1e8;

/// A command that moves by less than this relative to its magnitude is constant within the precision of a number.
const DIGITS: f64 = 1e-12;

/// Numbers that are unsuitable for computation.
#[must_use]
pub fn overflow(name: &'static str, values: &[f64], time: &[f64]) -> Option<Finding> {
    let place = values.iter().position(|value| value.abs() >= GREATEST)?;
    let sentence = format!("{name} reaches {:e}, but magnitudes must be below {GREATEST:e}", values[place]);
    let remedy = "check the units and the file, or give the values in a larger unit";
    Some(Finding::refusal("overflow", sentence, remedy).at(place, time))
}

/// A position that equals its command, to the last digit of every sample.
#[must_use]
pub fn copy_of_command(command: &[f64], position: &[f64]) -> Option<Finding> {
    (command == position).then(|| {
        Finding::refusal(
            "position_is_command",
            "the position is the command itself in every sample",
            "check the columns, and that the logger writes what the sensor measures",
        )
    })
}

/// Columns that do not move.
#[must_use]
pub fn standstill(command: &[f64], position: &[f64]) -> Option<Finding> {
    let range = |values: &[f64]| {
        let (low, high) = extremes(values);
        (high - low, low.abs().max(high.abs()))
    };
    let (moved, magnitude) = range(command);
    if moved <= DIGITS * magnitude {
        let sentence = format!("the command moves by {moved:e}, no more than its rounding");
        return Some(Finding::refusal("command_rests", sentence, "choose a record with excitation"));
    }
    let (moved, magnitude) = range(position);
    (moved <= DIGITS * magnitude).then(|| {
        Finding::refusal(
            "position_rests",
            format!("the position never moves: it stays at {} whatever the command does", position[0]),
            "check the sensor and the column, and that the actuator was on",
        )
    })
}

/// Minimum and maximum.
#[must_use]
pub fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// Minimum fraction of a record in flat stretches, and fraction of the range that counts as its end.
const FLAT_SHARE: f64 = 0.03;
const END_SHARE: f64 = 1e-3;

/// Stretches in which the position stays at one end of its range while the command moves: end value, first sample, samples.
#[must_use]
pub fn saturation(command: &[f64], position: &[f64]) -> Vec<(f64, usize, usize)> {
    let (low, high) = extremes(position);
    let near = END_SHARE * (high - low);
    let mut found = Vec::new();
    for end in [low, high] {
        let at_end: Vec<usize> = (1..position.len())
            .filter(|n| (position[*n] - end).abs() <= near && command[*n] != command[*n - 1])
            .collect();
        if at_end.len() as f64 > FLAT_SHARE * position.len() as f64 {
            found.push((end, at_end[0], at_end.len()));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_held_at_a_stop_is_saturated() {
        let command: Vec<f64> = (0..2000).map(|n| (0.01 * f64::from(n)).sin()).collect();
        let position: Vec<f64> = command.iter().map(|value| value.clamp(-0.6, 2.0)).collect();
        let found = saturation(&command, &position);
        assert!(found.len() == 1 && (found[0].0 + 0.6).abs() < 1e-12, "{found:?}");
        assert!(saturation(&command, &command).is_empty());
    }
}
