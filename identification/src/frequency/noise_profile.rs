//! Noise that varies along a record, and its effect on the response at a frequency.
//!
//! The lines around a frequency contain the noise of the whole record, the response only that at the times at which the command had power
//! there: in a sweep, some seconds. With the power P of the command at the frequency and the variance v of the noise, both in segments of
//! the record, the variance of the response is that for even noise times
//!
//! ```text
//! Σ P v / (Σ P · v̄)
//! ```
//!
//! or that for even noise, whichever is larger: at the ends of a band, where response and transient are hardly separable, estimates contain
//! noise of all times. v is computed from second differences of the residual of a reference model, which are insensitive to its small
//! errors. If the variances do not differ by the Bayesian information criterion, nothing changes.

use nalgebra::Complex;

use crate::fourier;

/// Length of a segment [s]: the neighbourhood of a frequency, half a hertz, has no better time resolution.
const SEGMENT_S: f64 = 4.0;

/// Maximum number of segments.
const MOST_SEGMENTS: usize = 64;

/// Minimum number of samples of a segment.
const FEWEST: usize = 100;

/// Evidence (twice the logarithm of the odds) that counts as strong.
const STRONG: f64 = 10.0;

/// Effective fraction of independent values among second differences of white noise: 1 / Σ ρ², with correlations of 1, -4/6 and 1/6.
const INDEPENDENT: f64 = 1.0 / (1.0 + 2.0 * (16.0 / 36.0 + 1.0 / 36.0));

/// Variance of the noise and power of the command in segments of a record.
pub(super) struct NoiseProfile {
    /// v / v̄ and P over frequency.
    segments: Vec<(f64, Vec<f64>)>,
    bin_hz: f64,
}

impl NoiseProfile {
    /// For a record with this command and the residual `rest` of a model; `None` if the noise is even.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of samples
    pub(super) fn new(command: &[f64], rest: &[f64], interval_s: f64) -> Option<Self> {
        let length = ((SEGMENT_S / interval_s) as usize).max(FEWEST).max(rest.len() / MOST_SEGMENTS);
        let variance = |segment: &[f64]| {
            let bends = segment.windows(3).map(|three| three[0] - 2.0 * three[1] + three[2]);
            bends.map(|bend| bend * bend).sum::<f64>() / (segment.len() - 2) as f64
        };
        let variances: Vec<f64> = rest.chunks_exact(length).map(variance).collect();
        let count = variances.len() as f64;
        let mean = variances.iter().sum::<f64>() / count;
        let apart: f64 = variances.iter().map(|variance| (mean / variance).ln()).sum();
        let samples = INDEPENDENT * length as f64;
        let evidence = samples * apart - (count - 1.0) * (samples * count).ln();
        if variances.len() < 2 || evidence.is_nan() || evidence <= STRONG {
            return None;
        }
        let fft = fourier::forward(length);
        let power = |segment: &[f64]| {
            let mean = segment.iter().sum::<f64>() / length as f64;
            let window = |place: usize| (std::f64::consts::PI * (place as f64 + 0.5) / length as f64).sin().powi(2);
            let values = segment.iter().enumerate().map(|(place, value)| Complex::from((value - mean) * window(place)));
            let mut values: Vec<Complex<f64>> = values.collect();
            fft.process(&mut values);
            values[..=length / 2].iter().map(Complex::norm_sqr).collect::<Vec<f64>>()
        };
        let segments = variances.iter().zip(command.chunks_exact(length));
        Some(Self {
            segments: segments.map(|(variance, segment)| (variance / mean, power(segment))).collect(),
            bin_hz: 1.0 / (length as f64 * interval_s),
        })
    }

    /// Variance of the response at a frequency [Hz] over that for even noise, at least one.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of bins
    pub(super) fn factor(&self, frequency_hz: f64) -> f64 {
        let place = frequency_hz / self.bin_hz;
        let (mut sum, mut all) = (0.0, 0.0);
        for (variance, power) in &self.segments {
            let bin = (place as usize).min(power.len() - 2);
            let power = power[bin] + (place - bin as f64).clamp(0.0, 1.0) * (power[bin + 1] - power[bin]);
            sum += power * variance;
            all += power;
        }
        if all > 0.0 { (sum / all).max(1.0) } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frequency_has_the_noise_of_its_time() {
        // 2 Hz in the first half, 5 Hz in the second, where the noise is twice as large.
        let time = (0..8000).map(|n| f64::from(n) * 0.005);
        let command: Vec<f64> =
            time.map(|t| (std::f64::consts::TAU * if t < 20.0 { 2.0 } else { 5.0 } * t).sin()).collect();
        let even: Vec<f64> = (0..8000).map(|n| (f64::from(n) * 0.754_877_666).fract() - 0.5).collect();
        assert!(NoiseProfile::new(&command, &even, 0.005).is_none());
        let grown: Vec<f64> = even.iter().enumerate().map(|(n, e)| if n < 4000 { *e } else { 2.0 * e }).collect();
        let profile = NoiseProfile::new(&command, &grown, 0.005).unwrap();
        assert!(profile.factor(2.0) == 1.0 && (profile.factor(5.0) - 1.6).abs() < 0.02);
    }
}
