//! The part of a record used for statistics: at one interval, without gaps, no longer than needed.

use std::f64::consts::TAU;

use super::sampling::Clock;
use crate::signal::{Interpolation, record::Record};

/// Number of samples sufficient for all statistics here; longer records are judged by their liveliest part of this length.
const MOST_SAMPLES: usize = 30_000;

/// Jitter from which samples are interpolated to even times.
const UNEVEN: f64 = 0.02;

/// Command and position at one interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// First sample in the record.
    pub start: usize,
    /// \[s\]
    pub interval_s: f64,
    /// Command.
    pub command: Vec<f64>,
    /// Position.
    pub position: Vec<f64>,
    /// External load, where recorded.
    pub load: Option<Vec<f64>>,
    /// Fraction of white noise that remains after interpolation to even times.
    pub noise_left: NoiseLeft,
}

/// Autocovariance of interpolated samples of white noise of variance 1, at no lag and at a lag of one interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseLeft {
    /// Variance.
    pub variance: f64,
    /// Covariance of neighbours.
    pub covariance: f64,
}

impl NoiseLeft {
    /// For samples that are not interpolated.
    pub const ALL: Self = Self { variance: 1.0, covariance: 0.0 };

    /// Fraction of the density of white noise at a frequency, in turns per interval.
    #[must_use]
    pub fn density(self, turns: f64) -> f64 {
        self.variance + 2.0 * self.covariance * (TAU * turns).cos()
    }
}

/// The longest part without gaps; if longer than [`MOST_SAMPLES`], the samples in which the command moves most.
#[must_use]
pub fn window(record: &Record, clock: &Clock) -> Window {
    part(record, clock, MOST_SAMPLES)
}

/// The longest part without gaps, of any length.
#[must_use]
pub fn whole(record: &Record, clock: &Clock) -> Window {
    part(record, clock, usize::MAX)
}

fn part(record: &Record, clock: &Clock, most: usize) -> Window {
    let mut from = 0;
    let mut longest = 0..0;
    for end in clock.gaps.iter().map(|gap| gap + 1).chain([record.len()]) {
        if end - from > longest.len() {
            longest = from..end;
        }
        from = end;
    }
    if longest.len() > most {
        let activity = |start: usize| -> f64 {
            record.command()[start..start + most].windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum()
        };
        let starts = (longest.start..=longest.end - most).step_by(most / 2);
        let liveliest = starts.max_by(|a, b| activity(*a).total_cmp(&activity(*b))).unwrap_or(longest.start);
        longest = liveliest..liveliest + most;
    }
    let start = longest.start;
    let load = record.load().map(|load| &load[longest.clone()]);
    let (time, command, position) =
        (&record.time()[longest.clone()], &record.command()[longest.clone()], &record.position()[longest]);
    if clock.jitter < UNEVEN && clock.dropped_samples == 0 {
        return Window {
            start,
            interval_s: clock.interval_s,
            command: command.to_vec(),
            position: position.to_vec(),
            load: load.map(<[f64]>::to_vec),
            noise_left: NoiseLeft::ALL,
        };
    }
    let held = record.interpolation() == Interpolation::Held;
    Window {
        start,
        interval_s: clock.interval_s,
        command: on_even_times(time, command, clock.interval_s, held),
        position: on_even_times(time, position, clock.interval_s, false),
        load: load.map(|load| on_even_times(time, load, clock.interval_s, false)),
        noise_left: noise_left(time, clock.interval_s),
    }
}

impl Window {
    /// Groups of samples merged into one: the command's mean over each, equivalent for a held command, and the position at its start.
    #[must_use]
    #[allow(clippy::cast_precision_loss)] // counts of samples
    pub fn grouped(&self, group: usize) -> Self {
        let command = self.command.chunks_exact(group).map(|part| part.iter().sum::<f64>() / group as f64);
        let at_beginning = |values: &[f64]| values.chunks_exact(group).map(|part| part[0]).collect();
        Self {
            start: self.start,
            interval_s: self.interval_s * group as f64,
            command: command.collect(),
            position: at_beginning(&self.position),
            load: self.load.as_deref().map(at_beginning),
            noise_left: NoiseLeft {
                covariance: if group == 1 { self.noise_left.covariance } else { 0.0 },
                ..self.noise_left
            },
        }
    }
}

fn on_even_times(time: &[f64], values: &[f64], interval: f64, held: bool) -> Vec<f64> {
    let on_line = |(before, share): (usize, f64)| {
        let share = if held { 0.0 } else { share };
        values[before] + share * (values[before + 1] - values[before])
    };
    even_times(time, interval).map(on_line).collect()
}

/// For each even time the previous sample, and the fraction of the way from it to the next one.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of samples
fn even_times(time: &[f64], interval: f64) -> impl Iterator<Item = (usize, f64)> {
    let count = ((time[time.len() - 1] - time[0]) / interval).floor() as usize + 1;
    let mut before = 0;
    (0..count).map(move |n| {
        let at = time[0] + n as f64 * interval;
        while before + 2 < time.len() && time[before + 1] <= at {
            before += 1;
        }
        let share = (at - time[before]) / (time[before + 1] - time[before]);
        (before, share.clamp(0.0, 1.0))
    })
}

/// For lines between samples, with fractions f to the next one: mean (1 - f)² + f², and for neighbours the mean product of the weights of
/// their common samples.
#[allow(clippy::cast_precision_loss)] // a count of samples
fn noise_left(time: &[f64], interval: f64) -> NoiseLeft {
    let weights = |(before, share): (usize, f64)| [(before, 1.0 - share), (before + 1, share)];
    let shared = |one: (usize, f64), other: (usize, f64)| {
        let pairs = weights(one).into_iter().flat_map(|one| weights(other).map(|other| (one, other)));
        pairs.map(|(one, other)| if one.0 == other.0 { one.1 * other.1 } else { 0.0 }).sum::<f64>()
    };
    let places: Vec<(usize, f64)> = even_times(time, interval).collect();
    let variance = places.iter().map(|place| shared(*place, *place)).sum::<f64>() / places.len() as f64;
    let covariance = places.windows(2).map(|pair| shared(pair[0], pair[1])).sum::<f64>() / places.len() as f64;
    NoiseLeft { variance, covariance }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_times_hold_a_command_and_interpolate_a_position() {
        let time = [0.0, 0.1, 0.25, 0.3, 0.4];
        let values = [0.0, 1.0, 2.0, 3.0, 4.0];
        assert_eq!(on_even_times(&time, &values, 0.1, true), [0.0, 1.0, 1.0, 3.0, 3.0]);
        let linear = on_even_times(&time, &values, 0.1, false);
        assert!((linear[2] - 5.0 / 3.0).abs() < 1e-12, "{linear:?}");
        // Weights 1, 1, (1/3, 2/3), 1, 1 of the samples 0, 1, (1, 2), 3, 4.
        let left = noise_left(&time, 0.1);
        assert!((left.variance - (4.0 + 5.0 / 9.0) / 5.0).abs() < 1e-9, "{left:?}");
        assert!((left.covariance - 1.0 / 15.0).abs() < 1e-9, "{left:?}");
    }
}
