//! Noise of a measurement, without a model of the actuator, and how it was estimated.
//!
//! In decreasing reliability: repeats of one motion, periods of a periodic command, parts at rest, the spectrum above the band of the
//! command. The last one assumes white noise: it misses noise within the band, and includes motion above it that neither a linear model nor
//! play explains.

use std::f64::consts::PI;

use serde::Serialize;

use super::{spectrum::Band, window::NoiseLeft};
use crate::{frequency::power_density, linear_least_squares::dot, signal::record::rms, sorting::sort_by_number};

/// How the noise was estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Difference of two records with one command.
    Repeats,
    /// Difference of the periods of one command.
    Periods,
    /// Position while the command rests.
    Quiet,
    /// Spectrum above the band of the command, assuming white noise.
    AboveBand,
    /// Residual of a flexible linear model: an upper bound.
    Assumed,
}

/// Noise of a record.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Noise {
    /// Root mean square [unit of position].
    pub rms: f64,
    /// How it was estimated.
    pub source: Source,
}

impl Noise {
    /// From samples whose noise was reduced by interpolation.
    #[must_use]
    pub fn before_interpolation(self, left: NoiseLeft) -> Self {
        Self { rms: self.rms / left.variance.sqrt(), ..self }
    }
}

/// Commands that differ by less than this fraction of their range are equal.
const SAME_COMMAND: f64 = 1e-6;

/// From a second record of the same command at the same times: the variance of the difference is twice that of the noise.
#[must_use]
pub fn of_repeat(command: &[f64], position: &[f64], other_command: &[f64], other_position: &[f64]) -> Option<Noise> {
    if command.len() != other_command.len() || !same(command, other_command) {
        return None;
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    // An offset between two sessions is not noise.
    let offset = mean(position) - mean(other_position);
    let difference: Vec<f64> = position.iter().zip(other_position).map(|(one, other)| one - other - offset).collect();
    Some(Noise { rms: rms(&difference) / 2.0_f64.sqrt(), source: Source::Repeats })
}

fn same(one: &[f64], other: &[f64]) -> bool {
    let (low, high) = super::values::extremes(one);
    one.iter().zip(other).all(|(one, other)| (one - other).abs() <= SAME_COMMAND * (high - low))
}

/// Minimum number of periods compared; the first one contains the start and is left out.
const FEWEST_PERIODS: usize = 3;

/// From the periods of a command: y minus the mean of all periods.
#[must_use]
pub fn of_periods(position: &[f64], period: usize) -> Option<Noise> {
    let periods: Vec<&[f64]> = position.chunks_exact(period).skip(1).collect();
    let count = periods.len();
    if count + 1 < FEWEST_PERIODS || count < 2 {
        return None;
    }
    let mean: Vec<f64> =
        (0..period).map(|place| periods.iter().map(|part| part[place]).sum::<f64>() / count as f64).collect();
    let square: f64 =
        periods.iter().map(|part| part.iter().zip(&mean).map(|(a, b)| (a - b).powi(2)).sum::<f64>()).sum();
    // The mean uses one degree of freedom at each sample of the period.
    let freedom = (period * (count - 1)) as f64;
    Some(Noise { rms: (square / freedom).sqrt(), source: Source::Periods })
}

/// Minimum length of a part at rest for estimating the noise [samples], after the motion has settled.
const FEWEST_QUIET: usize = 50;

/// A part with this many times the variance of its second half still settles in its first half.
const SETTLING_RATIO: f64 = 1.5;
/// Parts with this many times the median variance of all are not at rest.
const RESTLESS_RATIO: f64 = 4.0;

/// A part at the start with a mean rate of at least this many standard errors starts in motion.
const MOVING_RATIO: f64 = 5.0;

/// From parts in which the command rests, each with a line subtracted: slow settling is not noise. A part at the start does not settle if
/// it is not moving, and was not cut from a record.
#[must_use]
pub fn of_quiet(
    position: &[f64],
    parts: &[std::ops::Range<usize>],
    settling: usize,
    is_cut_out: bool,
) -> Option<Noise> {
    let is_at_rest = |part: &std::ops::Range<usize>| part.start == 0 && !is_cut_out && !moves(&position[part.clone()]);
    let from = |part: &std::ops::Range<usize>| if is_at_rest(part) { 0 } else { part.start + settling };
    let mut found: Vec<[f64; 2]> = parts
        .iter()
        .filter(|part| part.end >= from(part) + FEWEST_QUIET)
        .map(|part| {
            let values = &position[from(part)..part.end];
            let late = &values[values.len() / 2..];
            let (whole, half) = (about_line(values), about_line(late));
            let settles = late.len() >= FEWEST_QUIET && mean(whole) > SETTLING_RATIO * mean(half);
            if settles { half } else { whole }
        })
        .collect();
    sort_by_number(&mut found, |part| mean(*part));
    let most = RESTLESS_RATIO * mean(*found.get((found.len().max(1) - 1) / 2)?);
    let quiet = found.iter().filter(|part| mean(**part) <= most);
    let [square, freedom] = quiet.fold([0.0, 0.0], |[square, freedom], part| [square + part[0], freedom + part[1]]);
    (freedom > 0.0).then(|| Noise { rms: (square / freedom).sqrt(), source: Source::Quiet })
}

fn mean([square, freedom]: [f64; 2]) -> f64 {
    square / freedom
}

/// Whether values drift in one direction, beyond noise.
fn moves(values: &[f64]) -> bool {
    let [[square, freedom], [slope, of_place]] = line(values);
    slope * slope * of_place > MOVING_RATIO * MOVING_RATIO * square / freedom.max(1.0)
}

/// Sum of squares about a line, and its degrees of freedom.
fn about_line(values: &[f64]) -> [f64; 2] {
    line(values)[0]
}

/// As above, and the slope of the line with the sum of squares of the times about their mean.
fn line(values: &[f64]) -> [[f64; 2]; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let place: Vec<f64> = (0..values.len()).map(|n| n as f64 - 0.5 * (count - 1.0)).collect();
    let of_place = dot(&place, &place);
    let slope = dot(&place, values) / of_place.max(f64::MIN_POSITIVE);
    let square = values.iter().zip(&place).map(|(value, place)| (value - mean - slope * place).powi(2)).sum();
    [[square, count - 2.0], [slope, of_place]]
}

/// Length of the averaged parts of a spectrum [s].
const PART_S: f64 = 4.0;

/// Minimum number of lines of the spectrum above the band.
const FEWEST_LINES: usize = 20;

/// Median of an exponential distribution over its mean: the distribution of periodograms, for which a median is insensitive to hum.
const MEDIAN_OF_POWER: f64 = std::f64::consts::LN_2;

/// From the spectrum of a residual above twice the band of the command, assumed white over all frequencies, corrected for the effect of
/// interpolation.
#[must_use]
pub fn above_band(residual: &[f64], interval_s: f64, band: &Band, left: NoiseLeft) -> Option<Noise> {
    let nyquist = 0.5 / interval_s;
    let from = 2.0 * band.highest_hz;
    // From the differences r[n] - r[n-1], whose spectrum is 4 sin²(π f T) times as large: leakage from below is small there.
    let differences: Vec<f64> = residual.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut density: Vec<f64> = power_density(&tapered(&differences, interval_s), interval_s)
        .into_iter()
        .filter(|[frequency, _]| *frequency > from && *frequency < 0.95 * nyquist)
        .map(|[frequency, density]| {
            density / (2.0 * (PI * frequency * interval_s).sin()).powi(2) / left.density(frequency * interval_s)
        })
        .collect();
    if density.len() < FEWEST_LINES {
        return None;
    }
    density.sort_by(f64::total_cmp);
    let median = density[density.len() / 2];
    // With averaging over parts the median approaches the mean; one part is the worst case, for which at least half is known.
    let parts = (residual.len() as f64 * interval_s / PART_S).floor().max(1.0);
    let share = 1.0 - (1.0 - MEDIAN_OF_POWER) / parts;
    Some(Noise { rms: (median / share * nyquist).sqrt(), source: Source::AboveBand })
}

/// Parts of four seconds under Hann windows of unit mean square: motion in the band does not leak out of it.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of samples
fn tapered(values: &[f64], interval_s: f64) -> Vec<Vec<f64>> {
    let length = ((PART_S / interval_s) as usize).clamp(1, values.len().max(1));
    let weight = |n: usize| (8.0_f64 / 3.0).sqrt() * (PI * (n as f64 + 0.5) / length as f64).sin().powi(2);
    values
        .chunks_exact(length)
        .map(|part| part.iter().enumerate().map(|(n, value)| weight(n) * value).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::slice::from_ref;

    use crate::{
        inspect::{sampling::clock, window::window},
        signal::{Command, Interpolation, record::Record},
        uniform_noise::uniform_noise,
    };
    use actuator_fmu::parameters::PositionUnit;

    /// Uniform noise of rms 1.
    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut next = uniform_noise(seed);
        (0..count).map(|_| 12.0_f64.sqrt() * next()).collect()
    }

    fn with_noise(motion: &[f64], seed: u64) -> Vec<f64> {
        motion.iter().zip(noise(seed, motion.len())).map(|(value, noise)| value + 0.01 * noise).collect()
    }

    #[test]
    fn every_source_finds_the_noise_that_is_there() {
        let period: Vec<f64> = (0..500).map(|n| (std::f64::consts::TAU * f64::from(n) / 500.0).sin()).collect();
        let command: Vec<f64> = period.iter().copied().cycle().take(4000).collect();
        let (one, two) = (with_noise(&command, 1), with_noise(&command, 2));
        let close = |noise: Option<Noise>| {
            let rms = noise.unwrap().rms;
            assert!((rms / 0.01 - 1.0).abs() < 0.06, "{noise:?}");
        };
        close(of_repeat(&command, &one, &command, &two));
        close(of_periods(&one, 500));
        let rest = vec![0.5; 1000];
        close(of_quiet(&with_noise(&rest, 3), &[0..500, 500..1000], 0, false));
        // One part that has not settled, and all parts that start with settling.
        let mut settles = with_noise(&rest, 3);
        settles[..120].iter_mut().enumerate().for_each(|(n, value)| *value += (-0.03 * n as f64).exp());
        settles[500..620].iter_mut().enumerate().for_each(|(n, value)| *value += (-0.03 * n as f64).exp());
        settles[800..1000].iter_mut().enumerate().for_each(|(n, value)| *value += (0.2 * n as f64).sin());
        close(of_quiet(&settles, &[0..500, 500..800, 800..1000], 0, false));
        // The only part starts in motion, or is cut from a record in motion: no estimate before it has settled.
        let opens = |n: usize| 1.0 - (-0.01 * n as f64).exp();
        let moving = with_noise(&(0..4000).map(opens).collect::<Vec<f64>>(), 6);
        for is_cut_out in [false, true] {
            assert!(of_quiet(&moving[..400], from_ref(&(0..400)), 400, is_cut_out).is_none());
            close(of_quiet(&moving, from_ref(&(0..4000)), 700, is_cut_out));
        }
        let band = Band { lowest_hz: 0.0, highest_hz: 1.0 };
        close(above_band(&with_noise(&command, 4), 0.005, &band, NoiseLeft::ALL));
    }

    /// A line between samples averages their noise: at random times two thirds of its variance remain.
    #[test]
    fn noise_of_samples_that_were_put_on_even_times_is_that_of_the_samples() {
        let mut next = uniform_noise(5);
        let time: Vec<f64> = (0..6000).map(|n| 0.005 * (f64::from(n) + 0.8 * next())).collect();
        let motion: Vec<f64> = time.iter().map(|t| (3.0 * t).sin()).collect();
        let command = Command { time, command: motion.clone() };
        let position = with_noise(&motion, 7);
        let record = Record::new(command, position, PositionUnit::default(), Interpolation::Linear, "uneven").unwrap();
        let window = window(&record, &clock(record.time()));
        assert!((window.noise_left.variance - 2.0 / 3.0).abs() < 0.05, "{:?}", window.noise_left);
        let band = Band { lowest_hz: 0.0, highest_hz: 1.0 };
        let found = above_band(&window.position, window.interval_s, &band, window.noise_left).unwrap();
        assert!((found.rms / 0.01 - 1.0).abs() < 0.06, "{found:?}");
        let taken_whole = above_band(&window.position, window.interval_s, &band, NoiseLeft::ALL).unwrap();
        assert!(taken_whole.rms < 0.85 * found.rms, "{taken_whole:?}");
    }

    #[test]
    fn other_commands_are_no_repeats() {
        let command: Vec<f64> = (0..300).map(|n| (0.1 * f64::from(n)).sin()).collect();
        let other: Vec<f64> = command.iter().map(|value| 1.01 * value).collect();
        assert_eq!(of_repeat(&command, &command, &other, &other), None);
    }
}
