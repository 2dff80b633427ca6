//! The strongest line of a residual's spectrum: start value of an oscillation or a resonance.

use rustfft::num_complex::Complex;

use super::trace::Trace;
use crate::{fourier, signal::sampling::Sampling};

/// Length after zero padding, as a multiple of that of the residual: a peak between two lines loses little.
const PADDING: usize = 4;

/// Frequency of the strongest line in residuals of several records together [Hz].
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts and places of lines
pub fn strongest_frequency_hz(residuals: &[Vec<f64>], traces: &[Trace<'_>]) -> f64 {
    // Periods of a line in the longest record, at least: a slower one is a drift.
    const FEWEST_PERIODS: f64 = 4.0;
    let mut best = (0.0, 0.0);
    let spectra: Vec<(f64, Vec<f64>)> = residuals
        .iter()
        .zip(traces)
        .map(|(residual, trace)| {
            let (Sampling::Even(interval) | Sampling::Uneven(interval)) = trace.record.sampling();
            let length = (PADDING * residual.len()).next_power_of_two();
            let mut values: Vec<Complex<f64>> = residual.iter().map(|value| Complex::new(*value, 0.0)).collect();
            values.resize(length, Complex::default());
            fourier::forward(length).process(&mut values);
            let power = values[..length / 2].iter().map(|value| value.norm_sqr() / residual.len() as f64).collect();
            (1.0 / (interval * length as f64), power)
        })
        .collect();
    let Some((finest, _)) = spectra.iter().min_by(|a, b| a.0.total_cmp(&b.0)) else { return 0.0 };
    let longest = residuals.iter().map(Vec::len).max().unwrap_or(1) as f64;
    let length = spectra.iter().map(|(_, power)| power.len()).max().unwrap_or(1) as f64;
    let first = (FEWEST_PERIODS * 2.0 * length / longest) as usize;
    for line in first..length as usize {
        let frequency = line as f64 * finest;
        let power: f64 = spectra
            .iter()
            .map(|(width, power)| power.get((frequency / width).round() as usize).copied().unwrap_or_default())
            .sum();
        if power > best.1 {
            best = (frequency, power);
        }
    }
    best.0
}
