//! The command: band, period, parts at rest.

use std::ops::Range;

use rustfft::num_complex::Complex;
use serde::Serialize;

use crate::{fourier, frequency::power_density};

/// Band of a command.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Band {
    /// \[Hz\]
    pub lowest_hz: f64,
    /// \[Hz\]
    pub highest_hz: f64,
}

/// Fraction of the power excluded at each end of the band.
const OUTSIDE: f64 = 0.005;

/// Median of a chi-square distribution with one degree of freedom over its mean: the distribution of lines of a real transform of noise.
const MEDIAN_OF_LINE: f64 = 0.454_9;

/// Two quarters of the spectrum that differ by less than this, as a logarithm, are one noise floor.
const FLAT: f64 = 0.2;

/// The band that contains 99 % of the power of a command about its mean, without the white noise of a measured one.
///
/// The lines are those of the whole record: with a resolution of a quarter of a hertz the ends of a band are not found. Noise is detected
/// from the two upper quarters of the spectrum if they are alike.
#[must_use]
#[allow(clippy::cast_precision_loss)] // counts of lines
pub fn band(command: &[f64], interval_s: f64) -> Band {
    let mut power = lines(command);
    let floor = floor(&power);
    power.iter_mut().for_each(|power| *power -= floor);
    let least = OUTSIDE * power.iter().sum::<f64>();
    let hz = |line: usize| 0.5 * (line + 1) as f64 / (power.len() as f64 * interval_s);
    // From this end to where the cumulative power exceeds the limit.
    let end = |mut lines: &mut dyn Iterator<Item = usize>| {
        let mut sum = 0.0;
        Iterator::find(&mut lines, |line| {
            sum += power[*line];
            sum >= least
        })
    };
    let lowest = end(&mut (0..power.len()));
    let highest = end(&mut (0..power.len()).rev());
    Band { lowest_hz: lowest.map_or(0.0, hz), highest_hz: highest.map_or(0.5 / interval_s, hz) }
}

/// Maximum number of samples in one transform.
const MOST_SAMPLES: usize = 400_000;

/// Power of the lines of a signal about its mean, up to half the sampling rate. It is continued beyond its ends by reflection, even near a
/// crest and odd near zero, so that there are no jumps.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn lines(signal: &[f64]) -> Vec<f64> {
    let length = signal.len() / signal.len().div_ceil(MOST_SAMPLES);
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>();
    let size = square(&mut signal.iter().map(|value| value - mean));
    let change = square(&mut signal.windows(2).map(|pair| pair[1] - pair[0]));
    let sign = |value: f64, before: f64| {
        if (value - before).powi(2) * size > (value - mean).powi(2) * change { -1.0 } else { 1.0 }
    };
    let fft = fourier::forward(4 * length);
    let mut power = vec![0.0; length];
    for part in signal.chunks_exact(length) {
        let (first, last) = (sign(part[0], part[1]), sign(part[length - 1], part[length - 2]));
        let forth = |sign: f64| part.iter().map(move |value| Complex::from(sign * (value - mean)));
        let back = |sign: f64| part.iter().rev().map(move |value| Complex::from(sign * (value - mean)));
        let mut values: Vec<Complex<f64>> =
            forth(1.0).chain(back(last)).chain(forth(first * last)).chain(back(first)).collect();
        fft.process(&mut values);
        // Every second line is empty, by the symmetry of the images.
        let pairs = values[1..].chunks_exact(2).map(|pair| pair[0].norm_sqr() + pair[1].norm_sqr());
        power.iter_mut().zip(pairs).for_each(|(power, pair)| *power += pair);
    }
    power
}

/// Mean power of a line of white noise; 0 if the spectrum does not end in a floor, or is only a floor.
#[allow(clippy::cast_precision_loss)] // counts of lines
fn floor(power: &[f64]) -> f64 {
    let (half, quarter) = (power.len() / 2, power.len() / 4);
    if quarter == 0 {
        return 0.0;
    }
    let level = |lines: &[f64]| {
        let mut lines = lines.to_vec();
        let middle = lines.len() / 2;
        *lines.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN_OF_LINE
    };
    let (third, fourth) = (level(&power[half..half + quarter]), level(&power[half + quarter..]));
    let floor = 0.5 * (third + fourth);
    let is_floor = (third / fourth).ln().abs() < FLAT && floor * (power.len() as f64) < 0.5 * power.iter().sum::<f64>();
    if is_floor { floor } else { 0.0 }
}

/// Frequency below which 99.5 % of the power of a signal lies, in parts of four seconds including jumps between their ends: a thinned
/// record need not retain motion above it.
#[must_use]
pub fn reach_hz(signal: &[f64], interval_s: f64) -> f64 {
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    let about: Vec<f64> = signal.iter().map(|value| value - mean).collect();
    let density = power_density(&[about], interval_s);
    let total: f64 = density.iter().map(|[_, density]| density).sum();
    let mut sum = 0.0;
    let reached = density.into_iter().find(|[_, density]| {
        sum += density;
        sum >= (1.0 - OUTSIDE) * total
    });
    reached.map_or(0.5 / interval_s, |[frequency, _]| frequency)
}

/// Differences below this fraction of the command's range count as zero.
const SAME: f64 = 1e-9;

/// Minimum number of samples in a period.
const SHORTEST_PERIOD: usize = 10;

/// Samples in the period of a command that repeats at least three times; `None` if it does not.
#[must_use]
pub fn period(command: &[f64]) -> Option<usize> {
    let (low, high) = super::values::extremes(command);
    let near = SAME * (high - low);
    let count = command.len();
    let repeats = |period: usize| (period..count).all(|n| (command[n] - command[n - period]).abs() <= near);
    // The maximum recurs after a period.
    let peak = command.iter().position(|value| high - value <= near)?;
    let back = (peak + SHORTEST_PERIOD..command.len()).filter(|n| high - command[*n] <= near).map(|n| n - peak);
    back.take_while(|period| *period <= count / 3).find(|period| repeats(*period))
}

/// Minimum length of a part at rest that is reported [samples].
const SHORTEST: usize = 20;

/// Parts in which the command rests.
#[must_use]
pub fn rests(command: &[f64]) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let mut from = 0;
    for n in 1..=command.len() {
        if n == command.len() || command[n] != command[n - 1] {
            if n - from >= SHORTEST {
                parts.push(from..n);
            }
            from = n;
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uniform_noise::uniform_noise;

    #[test]
    fn the_band_of_a_sweep_is_its_own_at_any_rate_wherever_it_ends_and_in_noise() {
        let mut noise = uniform_noise(4);
        for (rate, end) in [(100.0, 0.25), (1000.0, 0.25), (1000.0, 0.0)] {
            for size in [0.0, 0.1] {
                let count = 60.0 * rate;
                // From 0.1 to 20 Hz in 60 s; it ends at its extreme, or at zero.
                let turns = |share: f64| (60.0 * (0.1 * share + 0.5 * 19.9 * share * share)) * (603.0 + end) / 603.0;
                let command: Vec<f64> = (0..count as usize)
                    .map(|n| (std::f64::consts::TAU * turns(n as f64 / count)).sin() + size * noise())
                    .collect();
                let found = band(&command, 1.0 / rate);
                assert!(
                    found.lowest_hz < 0.35 && (found.highest_hz - 20.0).abs() < 0.3,
                    "{rate} {end} {size}: {found:?}"
                );
            }
        }
    }

    #[test]
    fn band_period_and_rests_of_a_made_command() {
        let mut command: Vec<f64> =
            (0..4000).map(|n| (std::f64::consts::TAU * 5.0 * 0.005 * f64::from(n)).sin()).collect();
        let found = band(&command, 0.005);
        assert!((found.lowest_hz - 5.0).abs() < 0.3 && (found.highest_hz - 5.0).abs() < 0.3, "{found:?}");
        let hold: Vec<f64> = (0..4000).map(|n| f64::from((n % 400) / 40)).collect();
        assert_eq!(period(&hold), Some(400));
        command[100..200].fill(0.25);
        let found = rests(&command);
        assert!(found.len() == 1 && found[0] == (100..200), "{found:?}");
        assert_eq!(period(&command), None);
    }
}
