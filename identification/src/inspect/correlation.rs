//! Lag and sign of a response by cross-correlation with its command.

use rustfft::num_complex::Complex;
use serde::Serialize;

use crate::{fourier, signal::record::without_mean};

/// Extremum of the cross-correlation of command and position.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Correlation {
    /// Lag of the position behind the command [samples]; negative for a lead.
    pub lag_samples: f64,
    /// Correlation coefficient there, from -1 to 1.
    pub coefficient: f64,
}

/// Extremes within this fraction of the largest count as equal: those of a periodic command repeat, and the first causal one is chosen.
const ALIKE: f64 = 0.98;

/// If the best extremum has both a lead and the opposite sign, one with a lag and the same sign is preferred if its correlation is at least
/// this fraction of it.
const NEARLY: f64 = 0.8;

/// A peak with a smaller lead than this is at zero: half a sample, a possible offset between columns of one logger.
const AHEAD_SAMPLES: f64 = 0.5;

/// Cross-correlation of two columns, either unchanged or, if that is far clearer and nearer to zero lag, detrended: a drifting sensor
/// correlates with other motion.
#[must_use]
pub fn correlate(command: &[f64], position: &[f64]) -> Correlation {
    /// Maximum ratio of 1 - |correlation| detrended to that unchanged.
    const FAR_CLEARER: f64 = 0.5;
    let as_they_are = correlate_about_means(command, position);
    let about_lines = correlate_about_means(&without_line(command), &without_line(position));
    let missing = |correlation: &Correlation| 1.0 - correlation.coefficient.abs();
    let is_clearer = missing(&about_lines) < FAR_CLEARER * missing(&as_they_are);
    if is_clearer && about_lines.lag_samples.abs() < as_they_are.lag_samples.abs() { about_lines } else { as_they_are }
}

/// Values minus their regression line.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn without_line(values: &[f64]) -> Vec<f64> {
    let middle = 0.5 * (values.len() as f64 - 1.0);
    let about = without_mean(values);
    let from_middle = |n: usize| n as f64 - middle;
    let (product, square) = about.iter().enumerate().fold((0.0, f64::MIN_POSITIVE), |(product, square), (n, value)| {
        (product + value * from_middle(n), square + from_middle(n).powi(2))
    });
    about.iter().enumerate().map(|(n, value)| value - product / square * from_middle(n)).collect()
}

/// Circular autocorrelation coefficients of a signal about its mean; zero if it is constant.
#[must_use]
#[allow(clippy::cast_precision_loss)] // a count of samples
pub fn circular_autocorrelation(signal: &[f64]) -> Vec<f64> {
    let mut spectrum: Vec<Complex<f64>> =
        without_mean(signal).into_iter().map(|value| Complex::new(value, 0.0)).collect();
    fourier::forward(signal.len()).process(&mut spectrum);
    spectrum.iter_mut().for_each(|line| *line = Complex::new(line.norm_sqr(), 0.0));
    let power: f64 = spectrum.iter().map(|line| line.re).sum();
    fourier::inverse(signal.len()).process(&mut spectrum);
    spectrum.iter().map(|line| line.re / power.max(f64::MIN_POSITIVE)).collect()
}

/// By Fourier transforms with zero padding to twice the length.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_wrap)] // counts of samples
fn correlate_about_means(command: &[f64], position: &[f64]) -> Correlation {
    let count = command.len();
    let length = (2 * count).next_power_of_two();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count as f64;
    let (command_mean, position_mean) = (mean(command), mean(position));
    // Two real signals in one transform.
    let mut both: Vec<Complex<f64>> = command
        .iter()
        .zip(position)
        .map(|(command, position)| Complex::new(command - command_mean, position - position_mean))
        .collect();
    let norm = both.iter().map(|value| value.re * value.re).sum::<f64>()
        * both.iter().map(|value| value.im * value.im).sum::<f64>();
    if norm <= 0.0 || !norm.is_finite() {
        return Correlation { lag_samples: 0.0, coefficient: 0.0 };
    }
    both.resize(length, Complex::default());
    fourier::forward(length).process(&mut both);
    let mut product: Vec<Complex<f64>> = (0..length)
        .map(|bin| {
            let (here, mirrored) = (both[bin], both[(length - bin) % length].conj());
            let (command, position) = ((here + mirrored) * 0.5, (here - mirrored) * Complex::new(0.0, -0.5));
            position * command.conj()
        })
        .collect();
    fourier::inverse(length).process(&mut product);
    let farthest = (count / 2) as i64;
    // By lag, from one before the farthest lead to one after the farthest lag.
    let first = -(farthest + 1);
    let at_lags: Vec<f64> = (first..=farthest + 1)
        .map(|lag| product[lag.rem_euclid(length as i64) as usize].re / (length as f64 * norm.sqrt()))
        .collect();
    let at = |lag: i64| at_lags[(lag - first) as usize];
    // Peaks lie between samples: for a fast motion the nearest sample may be well below.
    let around = |lag: i64| [at(lag - 1), at(lag), at(lag + 1)].map(f64::abs);
    let offset = |[before, here, after]: [f64; 3]| {
        let curvature = before - 2.0 * here + after;
        if curvature < 0.0 { 0.5 * (before - after) / curvature } else { 0.0 }
    };
    let refined = |lag: i64| lag as f64 + offset(around(lag));
    let height = |lag: i64| {
        let [before, here, after] = around(lag);
        here - 0.25 * (before - after) * offset([before, here, after])
    };
    let is_peak = |lag: &i64| {
        let [before, here, after] = around(*lag);
        here >= before && here >= after
    };
    let all: Vec<i64> = (-farthest..=farthest).filter(is_peak).collect();
    let mut peaks = all.clone();
    let greatest = peaks.iter().map(|lag| height(*lag)).fold(0.0, f64::max);
    peaks.retain(|lag| height(*lag) >= ALIKE * greatest);
    let causal = peaks.iter().copied().find(|lag| refined(*lag) >= -AHEAD_SAMPLES);
    let nearest = peaks.iter().copied().min_by_key(|lag| lag.abs()).unwrap_or(0);
    let best = causal.filter(|lag| lag.abs() <= 4 * nearest.abs().max(1)).unwrap_or(nearest);
    // For a single up-and-down motion, the way down correlates well with the late way up before it.
    let follows = |lag: &i64| *lag >= 0 && at(*lag) >= NEARLY * greatest;
    let is_doubtful = at(best) < 0.0 && refined(best) < -AHEAD_SAMPLES;
    let lag = all.into_iter().filter(|_| is_doubtful).find(follows).unwrap_or(best);
    Correlation { lag_samples: refined(lag), coefficient: at(lag) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(count: usize) -> Vec<f64> {
        (0..count).map(|n| (1e-5 * (n * n) as f64 + 0.02 * n as f64).sin()).collect()
    }

    #[test]
    fn a_signal_of_two_periods_repeats_itself_after_one() {
        let signal: Vec<f64> = (0..80).map(|n| f64::from(n % 40 % 7) + f64::from(n % 40)).collect();
        let found = circular_autocorrelation(&signal);
        assert!((found[0] - 1.0).abs() < 1e-12 && (found[40] - 1.0).abs() < 1e-12 && found[20].abs() < 0.9);
        assert_eq!(circular_autocorrelation(&[2.0; 9]), vec![0.0; 9]);
    }

    #[test]
    fn lag_and_sign_of_a_delayed_copy() {
        let command = sweep(3000);
        for (lag, sign) in [(7_usize, 1.0), (400, -1.0)] {
            let position: Vec<f64> =
                (0..3000).map(|n| if n < lag { 2.0 } else { sign * command[n - lag] + 2.0 }).collect();
            let found = correlate(&command, &position);
            assert!((found.lag_samples - lag as f64).abs() < 0.2, "{found:?}");
            assert!(found.coefficient * sign > 0.8, "{found:?}");
            let swapped = correlate(&position, &command);
            assert!((swapped.lag_samples + lag as f64).abs() < 0.2, "{swapped:?}");
        }
    }

    /// Steps up and down whose drift gives the response to a later command the opposite sign.
    #[test]
    fn a_sensor_that_drifts_leaves_the_lag_of_the_response() {
        let levels = [0.0, -1.0, 2.0, 4.0, 7.0, 9.0, 9.0, 9.0, 7.0, 4.0, 2.0, -1.0, -1.0, -1.0, 2.0, 2.0];
        let command: Vec<f64> = levels.iter().flat_map(|level| [*level; 100]).collect();
        for drift in [0.0, 0.004, 0.008] {
            let behind = |n: usize| command[n.saturating_sub(12)] + drift * n as f64;
            let found = correlate(&command, &(0..command.len()).map(behind).collect::<Vec<f64>>());
            assert!((found.lag_samples - 12.0).abs() < 2.0 && found.coefficient > 0.9, "{drift} {found:?}");
        }
    }

    /// Nine samples per period: the sample nearest to a peak may be 6 % below it, and the opposite peak half a period later higher.
    #[test]
    fn a_fast_motion_has_the_sign_of_its_first_peak() {
        for behind in [0.3, 0.5, 0.8, 1.2, 1.5] {
            let phase = behind / 8.9 * std::f64::consts::TAU;
            let sines = |phase: f64| -> Vec<f64> {
                (0..1250)
                    .map(|n| (0.706 * f64::from(n) - phase).sin() + 0.3 * (0.67 * f64::from(n) - phase).sin())
                    .collect()
            };
            let found = correlate(&sines(0.0), &sines(phase));
            assert!(found.coefficient > 0.9 && (found.lag_samples - behind).abs() < 0.3, "{behind} {found:?}");
        }
    }

    #[test]
    fn of_a_sine_the_first_causal_peak_is_taken() {
        let sine = |phase: f64| (0..4000).map(|n| (0.05 * f64::from(n) - phase).sin()).collect::<Vec<f64>>();
        let found = correlate(&sine(0.0), &sine(2.1)); // lagging by 120 deg
        assert!((found.lag_samples - 42.0).abs() < 0.5 && found.coefficient > 0.9, "{found:?}");
    }

    /// Half a period of a trapezoid, and the response of play or a dead zone: the way down correlates best, with the opposite sign, with the late way up
    /// before it.
    #[test]
    fn a_late_response_to_one_way_up_and_down_follows_and_a_clear_opposite_that_is_early_leads() {
        let through = |points: &[(f64, f64)], time: f64| -> f64 {
            let behind = points.iter().skip(1).position(|(at, _)| time < *at).unwrap_or(points.len() - 2);
            let [(from, low), (to, high)] = [points[behind], points[behind + 1]];
            low + (high - low) * (time - from) / (to - from)
        };
        let sampled =
            |of_time: &dyn Fn(f64) -> f64| -> Vec<f64> { (0..1600).map(|n| of_time(0.005 * f64::from(n))).collect() };
        let command = [(0.0, 0.0), (2.45, 11.2), (3.5, 11.2), (5.95, 0.0), (7.0, 0.0), (8.0, -5.7)];
        let position = [(0.0, 0.0), (1.5, 0.0), (2.5, 4.4), (4.6, 13.4), (5.5, 9.0), (8.0, -2.2)];
        let found = correlate(&sampled(&|time| through(&command, time)), &sampled(&|time| through(&position, time)));
        assert!(found.coefficient > 0.6 && (200.0..450.0).contains(&found.lag_samples), "{found:?}");
        let sines = |time: f64| (2.0 * time).sin() + (5.3 * time).sin() + (11.9 * time).sin();
        let ahead = correlate(&sampled(&sines), &sampled(&|time| -sines(time + 0.2)));
        assert!(ahead.coefficient < -0.6 && (ahead.lag_samples + 40.0).abs() < 1.0, "{ahead:?}");
    }
}
