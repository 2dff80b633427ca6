//! Likelihood with the noise density taken from the spectrum of a residual around each frequency (P. Whittle, 1953).

use rustfft::num_complex::Complex;

use crate::fourier;

/// Σ_f 2 |X|² / S(f), S the density of a residual around each frequency. Tapers reduce leakage into frequencies with hardly any power, and no density
/// is taken to be below a thousandth of the mean.
pub fn whittle_power(column: &[f64], residual: &[f64]) -> f64 {
    let [power, own] = multitaper_periodograms([column, residual]);
    over_density(power.into_iter(), &own)
}

/// Σ_f 2 (|R_other|² - |R|²) / S(f): how much more another residual has of this than the residual itself.
pub fn whittle_gain(other: &[f64], residual: &[f64]) -> f64 {
    let [power, own] = multitaper_periodograms([other, residual]);
    over_density(power.iter().zip(&own).map(|(power, own)| power - own), &own)
}

#[allow(clippy::cast_precision_loss)] // counts of lines
fn over_density(power: impl Iterator<Item = f64>, residual: &[f64]) -> f64 {
    const FLOOR_SHARE: f64 = 1e-3;
    let density = local_mean(residual);
    let floor = (FLOOR_SHARE * density.iter().sum::<f64>() / density.len() as f64).max(f64::MIN_POSITIVE);
    2.0 * power.zip(&density).map(|(power, density)| power / density.max(floor)).sum::<f64>()
}

/// |R|² of the lines of columns of one length, the mean over the sine tapers of K. S. Riedel and A. Sidorenko (IEEE Trans. Signal Process. 43, 1995):
/// together they cover a record up to its first and last samples, near which a sweep reaches its highest rates.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn multitaper_periodograms<const COLUMNS: usize>(columns: [&[f64]; COLUMNS]) -> [Vec<f64>; COLUMNS] {
    const TAPERS: usize = 8;
    let length = columns[0].len();
    let transform = fourier::forward(length);
    let mut sums = columns.map(|_| vec![0.0; length / 2 + 1]);
    let (sin_step, cos_step) = (std::f64::consts::PI / (length + 1) as f64).sin_cos();
    let (mut sin, mut cos) = (0.0, 1.0);
    // sin a, sin 2a, ... by sin (k + 1)a = 2 cos a sin ka - sin (k - 1)a, for angles a that are turned on from sample to sample.
    let weight = |_| {
        (sin, cos) = (sin * cos_step + cos * sin_step, cos * cos_step - sin * sin_step);
        [0.0, sin, 2.0 * cos]
    };
    let mut weights: Vec<[f64; 3]> = (0..length).map(weight).collect();
    let mut values = vec![Complex::default(); length];
    // Two tapers in one transform, one as its real part: |U|² + |V|² of a line are half of |U + jV|² there and at its mirror image.
    for _ in 0..TAPERS / 2 {
        for weight in &mut weights {
            let [before, one, factor] = *weight;
            *weight = [one, factor * one - before, factor];
        }
        for (column, sum) in columns.iter().zip(&mut sums) {
            for ((value, sample), [one, two, _]) in values.iter_mut().zip(*column).zip(&weights) {
                *value = Complex::new(sample * one, sample * two);
            }
            transform.process(&mut values);
            for (line, sum) in sum.iter_mut().enumerate() {
                let mirrored = values[(length - line) % length];
                *sum += 0.5 * (values[line].norm_sqr() + mirrored.norm_sqr()) / TAPERS as f64;
            }
        }
        for weight in &mut weights {
            let [one, two, factor] = *weight;
            *weight = [two, factor * two - one, factor];
        }
    }
    sums
}

/// Mean of the lines around each line.
#[allow(clippy::cast_precision_loss)] // a count of lines
fn local_mean(power: &[f64]) -> Vec<f64> {
    const HALF_WIDTH: usize = 12;
    let mut sums = vec![0.0];
    for value in power {
        sums.push(sums[sums.len() - 1] + value);
    }
    (0..power.len())
        .map(|line| {
            let (from, to) = (line.saturating_sub(HALF_WIDTH), (line + HALF_WIDTH + 1).min(power.len()));
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_power_is_the_mean_over_sine_tapers() {
        for length in [36_usize, 37] {
            let column: Vec<f64> = (0..length).map(|n| (0.7 * n as f64).cos() + 0.1 * n as f64).collect();
            for (line, found) in multitaper_periodograms([&column])[0].iter().enumerate() {
                let of_taper = |taper: usize| -> f64 {
                    let angle = |n: usize| std::f64::consts::TAU * (line * n) as f64 / length as f64;
                    let weight =
                        |n: usize| (std::f64::consts::PI * (taper * (n + 1)) as f64 / (length + 1) as f64).sin();
                    let sum = |wave: fn(f64) -> f64| -> f64 {
                        column.iter().enumerate().map(|(n, value)| weight(n) * value * wave(angle(n))).sum()
                    };
                    sum(f64::cos).powi(2) + sum(f64::sin).powi(2)
                };
                let expected = (1..=8).map(of_taper).sum::<f64>() / 8.0;
                assert!((found - expected).abs() < 1e-10 * (1.0 + expected), "{length} {line}: {found} {expected}");
            }
        }
    }

    #[test]
    fn a_burst_counts_alike_wherever_it_is() {
        const LENGTH: usize = 2000;
        let burst = |start: usize| -> f64 {
            let column: Vec<f64> =
                (0..LENGTH).map(|n| if (start..start + 80).contains(&n) { (n as f64).sin() } else { 0.0 }).collect();
            multitaper_periodograms([&column])[0].iter().sum()
        };
        let middle = burst(960);
        for start in [40, 100, 500, 1500, 1820, 1880] {
            let share = burst(start) / middle;
            assert!((0.5..2.0).contains(&share), "{share} at {start}");
        }
    }
}
