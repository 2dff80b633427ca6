//! Positions that are constant to the last digit: at an end of the range of their sensor, for a part of a record, or between readings that
//! are less frequent than the rows of the file.

use std::{collections::BTreeMap, ops::Range};

use super::{finding::Finding, values::extremes, window::Window};
use crate::{
    digits::{significant, with_unit},
    signal::record::Record,
};

/// Minimum number of samples at an end, and in a row there at least once, that is not due to chance.
const FEWEST_AT_END: usize = 8;
const FEWEST_IN_A_ROW: usize = 3;

/// Minimum ratio of the samples at the end of the range to those at any level near it, for a position that is held there.
const MORE_OFTEN_THAN_NEAR: usize = 5;

/// Levels within this fraction of the range are near an end.
const NEAR: f64 = 0.1;

/// Mean excursion of a linear response beyond the end, as a fraction of the range.
const BEYOND: f64 = 0.01;

/// A stretch in which a linear response moves through this fraction of the range is conspicuous; with play, friction and dead zones there
/// are many such stretches.
const STANDS_OUT: f64 = 0.25;
const MOST_STRETCHES: usize = 2;
const NEXT_STRETCH: f64 = 0.5;

/// Minimum number of samples of a constant stretch.
const SHORTEST_STRETCH: usize = 10;

/// Minimum number of changes of a position for testing their times, and fraction of them at regular times.
const FEWEST_CHANGES: usize = 40;
const IN_TIME: f64 = 0.95;

/// Fraction of the changes that exceed the smallest one: for slow rounded motion all are one step.
const LARGER_CHANGES: f64 = 0.5;

/// Findings on constant positions in a window; `explained` is the response of a linear model, `ends` are those already reported as held.
pub fn findings(record: &Record, window: &Window, explained: &[f64], ends: &[f64]) -> Vec<Finding> {
    let (time, unit) = (record.time(), record.unit().name());
    let position = &window.position;
    let at_end = clipped(position, explained).into_iter().filter(|(end, ..)| !ends.contains(end));
    let mut findings: Vec<Finding> = at_end
        .map(|(end, first, count)| {
            let sentence = format!(
                "the position is constant at {} to the last digit in {count} samples where a linear response exceeds it: a stop, a limit, or \
                 the end of the sensor's range",
                with_unit(end, 5, unit)
            );
            Finding::note("saturation", sentence).at(window.start + first, time)
        })
        .collect();
    if let Some(every) = slower_readings(position) {
        let sentence = format!(
            "the position changes only at one of {every} samples: it was read {} times a second and held in between",
            significant(1.0 / (every as f64 * window.interval_s), 4)
        );
        let remedy = "keep only the rows in which it was read, or record it as often as the command: held values lag by half that interval on average";
        findings.push(Finding::warning("held_position", sentence, remedy).at(window.start, time));
        return findings;
    }
    for (stretch, moved) in frozen(position, explained) {
        let seconds = significant(stretch.len() as f64 * window.interval_s, 3);
        let sentence = format!(
            "the position is constant at {} to the last digit for {seconds} s, while a linear response moves through {}",
            with_unit(position[stretch.start], 5, unit),
            with_unit(moved, 3, unit)
        );
        let remedy = "check whether sensor or logger froze there or the actuator was off, and leave that part out";
        findings.push(Finding::warning("frozen", sentence, remedy).at(window.start + stretch.start, time));
    }
    findings
}

/// Ends of the range at which a position is held: the end, its first sample, its samples.
fn clipped(position: &[f64], explained: &[f64]) -> Vec<(f64, usize, usize)> {
    let (low, high) = extremes(position);
    let range = high - low;
    let mut found = Vec::new();
    for (end, sign) in [(low, -1.0), (high, 1.0)] {
        let at_end: Vec<usize> = (0..position.len()).filter(|n| position[*n] == end).collect();
        let in_a_row = at_end.chunk_by(|one, next| one + 1 == *next).map(<[usize]>::len).max().unwrap_or(0);
        if at_end.len() < FEWEST_AT_END || in_a_row < FEWEST_IN_A_ROW {
            continue;
        }
        let beyond = at_end.iter().map(|n| sign * (explained[*n] - end)).sum::<f64>() / at_end.len() as f64;
        if beyond > BEYOND * range && at_end.len() >= MORE_OFTEN_THAN_NEAR * most_at_a_level_near(position, end, range)
        {
            found.push((end, at_end[0], at_end.len()));
        }
    }
    found
}

/// Maximum number of samples at one level near an end.
fn most_at_a_level_near(position: &[f64], end: f64, range: f64) -> usize {
    let mut counts = BTreeMap::new();
    let near = position.iter().filter(|value| **value != end && (**value - end).abs() < NEAR * range);
    near.for_each(|value| *counts.entry(value.to_bits()).or_insert(0) += 1);
    counts.into_values().max().unwrap_or(1)
}

/// Stretches in which a position is constant within its range, unlike the rest of the record, and the range of a linear response in them.
fn frozen(position: &[f64], explained: &[f64]) -> Vec<(Range<usize>, f64)> {
    let (low, high) = extremes(position);
    let moved = |stretch: &Range<usize>| {
        let (low, high) = extremes(&explained[stretch.clone()]);
        high - low
    };
    let is_within = |stretch: &Range<usize>| low < position[stretch.start] && position[stretch.start] < high;
    let mut stretches: Vec<(Range<usize>, f64)> = stretches(position)
        .filter(|stretch| stretch.len() >= SHORTEST_STRETCH && is_within(stretch))
        .map(|stretch| (stretch.clone(), moved(&stretch)))
        .collect();
    stretches.sort_by(|one, other| other.1.total_cmp(&one.1));
    let count = stretches.iter().filter(|(_, moved)| *moved > STANDS_OUT * (high - low)).count();
    let next = stretches.get(count).map_or(0.0, |(_, moved)| *moved);
    let least = stretches[..count].last().map_or(0.0, |(_, moved)| *moved);
    stretches.truncate(if count <= MOST_STRETCHES && next < NEXT_STRETCH * least { count } else { 0 });
    stretches
}

/// Runs of equal positions.
fn stretches(position: &[f64]) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    position.chunk_by(|one, next| one == next).map(move |equal| {
        let stretch = start..start + equal.len();
        start = stretch.end;
        stretch
    })
}

/// Rows from one reading of the position to the next, if more than one.
fn slower_readings(position: &[f64]) -> Option<usize> {
    let changes: Vec<usize> = stretches(position).skip(1).map(|stretch| stretch.start).collect();
    if changes.len() < FEWEST_CHANGES {
        return None;
    }
    let most_frequent = |values: &mut dyn Iterator<Item = usize>| {
        let mut counts = BTreeMap::new();
        values.for_each(|value| *counts.entry(value).or_insert(0) += 1);
        counts.into_iter().max_by_key(|(_, count)| *count)
    };
    let (every, _) = most_frequent(&mut changes.windows(2).map(|pair| pair[1] - pair[0]))?;
    if every < 2 {
        return None;
    }
    let (_, in_time) = most_frequent(&mut changes.iter().map(|change| change % every))?;
    let heights: Vec<f64> = changes.iter().map(|change| (position[*change] - position[change - 1]).abs()).collect();
    let least = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let larger = heights.iter().filter(|height| **height > 1.5 * least).count();
    let is_share = |count: usize, share: f64| count as f64 >= share * changes.len() as f64;
    (is_share(in_time, IN_TIME) && is_share(larger, LARGER_CHANGES)).then_some(every)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uniform_noise::uniform_noise;

    const COUNT: usize = 4000;

    /// A motion through -1 to 1, of two frequencies, and its reading by a sensor with noise.
    fn motion() -> (Vec<f64>, Vec<f64>) {
        let mut noise = uniform_noise(3);
        let motion: Vec<f64> =
            (0..COUNT).map(|n| n as f64).map(|n| 0.7 * (0.011 * n).sin() + 0.3 * (0.0417 * n).sin()).collect();
        let read = motion.iter().map(|value| value + 0.002 * noise()).collect();
        (motion, read)
    }

    #[test]
    fn a_sensor_at_the_end_of_its_range_is_reported_and_a_motion_that_turns_there_is_not() {
        let (motion, read) = motion();
        assert!(clipped(&read, &motion).is_empty());
        let clipped_read: Vec<f64> = read.iter().map(|value| value.min(0.75)).collect();
        let found = clipped(&clipped_read, &motion);
        assert!(found.len() == 1 && found[0].0 == 0.75 && found[0].2 > 100, "{found:?}");
        // Rounded, a motion is often at its maximum, and no response goes beyond.
        let rounded: Vec<f64> = motion.iter().map(|value| (value * 50.0).round() / 50.0).collect();
        assert!(clipped(&rounded, &motion).is_empty());
    }

    #[test]
    fn a_stretch_that_stands_is_reported_and_a_play_that_stands_at_each_turn_is_not() {
        let (motion, read) = motion();
        assert!(frozen(&read, &motion).is_empty());
        let mut stood = read;
        let value = stood[1700];
        stood[1700..1900].fill(value);
        let found = frozen(&stood, &motion);
        assert!(found.len() == 1 && found[0].0 == (1700..1900), "{found:?}");
        let behind = crate::signal::play::behind_play(&motion, 0.2);
        assert!(frozen(&behind, &motion).is_empty());
    }

    #[test]
    fn readings_that_are_held_are_told_by_when_they_change() {
        let (motion, read) = motion();
        let held = |every: usize| (0..COUNT).map(|n| read[n - n % every]).collect::<Vec<f64>>();
        assert_eq!(slower_readings(&read), None);
        assert_eq!([slower_readings(&held(2)), slower_readings(&held(20))], [Some(2), Some(20)]);
        let rounded: Vec<f64> = motion.iter().map(|value| (value * 50.0).round() / 50.0).collect();
        assert_eq!(slower_readings(&rounded), None);
    }
}
