//! Power spectral density of signals.

use rustfft::num_complex::Complex;

use crate::fourier;

/// One-sided power spectral density [unit²/Hz] over frequency \[Hz\] of signals at one interval \[s\], averaged over parts of about
/// four seconds without overlap (Bartlett's method).
#[must_use]
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of samples
pub fn power_density(signals: &[Vec<f64>], interval: f64) -> Vec<[f64; 2]> {
    const PART_S: f64 = 4.0;
    let shortest = signals.iter().map(Vec::len).min().unwrap_or(0);
    let length = ((PART_S / interval) as usize).clamp(1, shortest.max(1));
    let fft = fourier::forward(length);
    let mut sum = vec![0.0; length / 2 + 1];
    let mut parts = 0.0;
    for part in signals.iter().flat_map(|signal| signal.chunks_exact(length)) {
        let mut values: Vec<Complex<f64>> = part.iter().map(|value| Complex::new(*value, 0.0)).collect();
        fft.process(&mut values);
        sum.iter_mut().zip(&values).for_each(|(sum, value)| *sum += value.norm_sqr());
        parts += 1.0;
    }
    let scale = 2.0 * interval / (length as f64 * f64::max(parts, 1.0));
    let line = 1.0 / (interval * length as f64);
    sum.iter().enumerate().skip(1).map(|(place, power)| [place as f64 * line, scale * power]).collect()
}
