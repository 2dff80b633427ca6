//! A quantised measurement: the step found in its values, and the expected output of a quantiser behind noise.

use std::f64::consts::{PI, TAU};

/// Rounding to multiples of a step behind noise: its expected output.
///
/// ```text
/// E round(y + e) = y + step/π Σ_k (-1)^k / k exp(-2π²k²s²) sin(2πk y/step),    e normal with deviation s step
/// ```
///
/// The Fourier series of a sawtooth, attenuated by the noise, which acts as dither: from s = 0.4 on the quantiser is linear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantiser {
    /// Step \[deg\].
    pub step: f64,
    /// s
    pub noise: f64,
}

impl Quantiser {
    /// E round(y + e) in the place of each y; the series is summed by Clenshaw's recurrence, b_k = c_k + 2 cos(θ) b_(k+1) - b_(k+2).
    pub fn round_on_average(&self, positions: &mut [f64]) {
        let coefficients = self.coefficients();
        for position in positions {
            let (sine, cosine) = (TAU * *position / self.step).sin_cos();
            let (mut next, mut after_next) = (0.0, 0.0);
            for coefficient in coefficients.iter().rev() {
                (next, after_next) = (coefficient + 2.0 * cosine * next - after_next, next);
            }
            *position += self.step / PI * sine * next;
        }
    }

    /// (-1)^k / k exp(-2π²k²s²) from k = 1 on.
    fn coefficients(&self) -> Vec<f64> {
        // exp(-2π²k²s²) of the first omitted term is below a thousandth.
        const LAST: f64 = 0.6;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small count
        let terms = (LAST / self.noise).ceil() as u32;
        let magnitude = |k: f64| (-2.0 * (PI * k * self.noise).powi(2)).exp() / k;
        (1..=terms).map(|k| if k % 2 == 0 { magnitude(k.into()) } else { -magnitude(k.into()) }).collect()
    }
}

/// Distance of any value from a multiple of the step, at most, in steps: the digits of a file resolve it.
const GRID_TOLERANCE: f64 = 1e-3;

/// Step over the rounding error, at least: any value is near a multiple of a shorter step.
const LEAST_ROUNDINGS: f64 = 10.0;

/// Largest step of which all values are multiples [their unit]; 0 where there is none.
pub fn step_of(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let span = sorted.last().copied().unwrap_or_default() - sorted.first().copied().unwrap_or_default();
    let size = span.max(sorted.iter().fold(0.0, |size: f64, value| size.max(value.abs())));
    // Differences at the level of rounding errors do not count.
    let rounding = 1e-9 * size;
    let gaps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > rounding).collect();
    let Some(least) = gaps.iter().copied().reduce(f64::min) else { return 0.0 };
    // Each difference is a whole number of steps; their mean is more accurate than the smallest one.
    let (mut total, mut steps) = (0.0, 0.0);
    for gap in &gaps {
        let whole = (gap / least).round();
        total += gap;
        steps += whole;
    }
    let step = total / steps;
    if step < LEAST_ROUNDINGS * rounding {
        return 0.0;
    }
    let off = |value: &f64| (value / step - (value / step).round()).abs();
    if sorted.iter().all(|value| off(value) < GRID_TOLERANCE + rounding / step) { step } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_expected_is_the_mean_of_rounded_noise() {
        let quantiser = Quantiser { step: 0.5, noise: 0.12 };
        // By the probabilities of a normal distribution between the edges of the steps.
        let below = |x: f64| 0.5 * (1.0 + erf(x / std::f64::consts::SQRT_2));
        for tenth in -20..=20 {
            let mut position = [0.1 * f64::from(tenth)];
            let at = position[0] / quantiser.step;
            let edge = |n: i32| below((f64::from(n) - 0.5 - at) / quantiser.noise);
            let mean: f64 = (-20..20).map(|n| f64::from(n) * (edge(n + 1) - edge(n))).sum();
            quantiser.round_on_average(&mut position);
            assert!((position[0] / quantiser.step - mean).abs() < 2e-4, "{tenth}: {position:?} {mean}");
        }
    }

    /// By its series, which converges everywhere; large arguments have reached their limit.
    fn erf(x: f64) -> f64 {
        if x.abs() > 5.0 {
            return x.signum();
        }
        let (mut term, mut sum) = (x, x);
        for n in 1..200 {
            let n = f64::from(n);
            term *= -x * x / n;
            sum += term / (2.0 * n + 1.0);
        }
        std::f64::consts::FRAC_2_SQRT_PI * sum
    }

    #[test]
    fn a_step_is_found_in_rounded_values_and_only_there() {
        let smooth: Vec<f64> = (0..1000).map(|n| 3.0 * (0.37 * f64::from(n)).sin()).collect();
        assert_eq!(step_of(&smooth), 0.0);
        let rounded: Vec<f64> = smooth.iter().map(|value| (value / 0.088).round() * 0.088).collect();
        assert!((step_of(&rounded) - 0.088).abs() < 1e-12);
        let digits: Vec<f64> = smooth.iter().map(|value| (value * 1e4).round() / 1e4).collect();
        assert!((step_of(&digits) - 1e-4).abs() < 1e-10);
        // Two values that happen to lie close to each other.
        let mut close = smooth;
        close.push(close[7] + 4e-9);
        assert_eq!(step_of(&close), 0.0);
    }
}
