//! An actuator between samples: from one sample to the next the state is a linear function of state and command,
//!
//! ```text
//! z[n+1] = M z[n] + b0 c[n-m-1] + b1 c[n-m] + b2 c[n-m+1],   z = (x, δ, v)
//! ```
//!
//! with the delay T = m h + r, 0 <= r < h. A held command changes r after a sample, from c[n-m-1] to c[n-m]; a linear one
//! has its corner there. M and b are exact (see [`actuator_fmu::transition`]), so the response between commanded and measured
//! samples is exact as well:
//!
//! ```text
//! G = (0, 1, 0) (q - M)⁻¹ (b0 q⁻¹ + b1 + b2 q) q⁻ᵐ,   q = exp(2πj f h)
//! ```
//!
//! It is not the continuous H: it includes the command's reconstruction and its images at multiples of the sampling rate.

use nalgebra::{Complex, Matrix3, Vector3};

use crate::signal::Interpolation;
use actuator_fmu::{
    parameters::{Base, Order},
    transition::{Ramp, Transition},
};

/// M, b and m of one actuator, one interval and one delay.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    /// M.
    pub free: Matrix3<f64>,
    /// b0, b1, b2.
    pub taps: [Vector3<f64>; 3],
    /// m.
    pub lag: usize,
    interval: f64,
}

impl Sampled {
    /// For samples `interval_s` > 0 apart, with the command delayed by `delay_s` >= 0.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // delays of few samples
    pub fn new(base: Base, order: Order, delay_s: f64, interpolation: Interpolation, interval_s: f64) -> Self {
        let lag = (delay_s / interval_s).floor();
        let rest = (delay_s - lag * interval_s).clamp(0.0, interval_s);
        let before = Transition::new(base, order, rest);
        let after = Transition::new(base, order, interval_s - rest);
        let share = rest / interval_s;
        // Unit command at one of the three samples, zero at the others: value at the start and at the corner of both pieces.
        let through = |[old, now, next]: [f64; 3]| {
            let (first, second) = match interpolation {
                Interpolation::Held => (Ramp::held(old), Ramp::held(now)),
                Interpolation::Linear => {
                    let earlier = (now - old) / interval_s;
                    let later = (next - now) / interval_s;
                    (Ramp { value: now - earlier * rest, slope: earlier }, Ramp { value: now, slope: later })
                }
            };
            let middle = if share > 0.0 { before.apply(Vector3::zeros(), first) } else { Vector3::zeros() };
            after.apply(middle, second)
        };
        let free = Matrix3::from_fn(|row, column| {
            let unit = Vector3::ith(column, 1.0);
            let middle = if share > 0.0 { before.apply(unit, Ramp::default()) } else { unit };
            after.apply(middle, Ramp::default())[row]
        });
        let taps = [through([1.0, 0.0, 0.0]), through([0.0, 1.0, 0.0]), through([0.0, 0.0, 1.0])];
        Self { free, taps, lag: lag as usize, interval: interval_s }
    }

    /// Position at the samples of a command, from rest under its first value, with initial position `rest`.
    #[must_use]
    pub fn position(&self, command: &[f64], rest: f64) -> Vec<f64> {
        let last = command.len().saturating_sub(1);
        // The command is constant before the first and after the last sample.
        let at = |index: usize| command[index.saturating_sub(self.lag + 1).min(last)];
        let [b0, b1, b2] = &self.taps;
        let mut state = Vector3::new(rest, rest, 0.0);
        let mut position = Vec::with_capacity(command.len());
        for index in 0..command.len() {
            position.push(state.y);
            state = self.free * state + b0 * at(index) + b1 * at(index + 1) + b2 * at(index + 2);
        }
        position
    }

    /// G at a frequency \[Hz\].
    #[must_use]
    #[allow(clippy::cast_precision_loss)] // delays of few samples
    pub fn response(&self, frequency_hz: f64) -> Complex<f64> {
        let angle = std::f64::consts::TAU * frequency_hz * self.interval;
        let q = Complex::from_polar(1.0, angle);
        let input = (self.taps[0].map(Complex::from) * q.conj()
            + self.taps[1].map(Complex::from)
            + self.taps[2].map(Complex::from) * q)
            * Complex::from_polar(1.0, -angle * self.lag as f64);
        // x depends on itself only, so that (q - M) z = input is solved from the top: x, then δ and v (Cramer's rule).
        let m = &self.free;
        let x = input.x / (q - m[(0, 0)]);
        let (first, second) = (input.y + x * m[(1, 0)], input.z + x * m[(2, 0)]);
        let determinant = (q - m[(1, 1)]) * (q - m[(2, 2)]) - m[(1, 2)] * m[(2, 1)];
        (first * (q - m[(2, 2)]) + second * m[(1, 2)]) / determinant
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// G by an independent route, Poisson's sum of H and its images, each times the reconstruction: sinc² for linear commands, sinc with
    /// half an interval of lag for held ones.
    fn sum_of_images(
        base: &Base,
        order: Order,
        delay: f64,
        interpolation: Interpolation,
        h: f64,
        f: f64,
    ) -> Complex<f64> {
        let image = |number: i32| {
            let frequency = f + f64::from(number) / h;
            let angle = std::f64::consts::PI * frequency * h;
            let sinc = if angle == 0.0 { 1.0 } else { angle.sin() / angle };
            let reconstruction = match interpolation {
                Interpolation::Held => Complex::from_polar(1.0, -angle) * sinc,
                Interpolation::Linear => Complex::from(sinc * sinc),
            };
            let delayed = Complex::from_polar(1.0, -std::f64::consts::TAU * frequency * delay);
            crate::frequency::response(base, order, frequency) * reconstruction * delayed
        };
        (-2000..=2000).map(image).sum()
    }

    #[test]
    fn the_sampled_response_is_the_sum_of_all_images() {
        let base = Base::new(1.05, 300.0, 165.0, 0.56).unwrap();
        for order in [Order::Second, Order::Third] {
            for interpolation in [Interpolation::Held, Interpolation::Linear] {
                for delay in [0.0, 0.0013, 0.005, 0.0172] {
                    for f in [0.5, 4.0, 12.0, 60.0] {
                        let exact = Sampled::new(base, order, delay, interpolation, 0.005).response(f);
                        let summed = sum_of_images(&base, order, delay, interpolation, 0.005, f);
                        // The sum is truncated at the 2000th image, which is (165 / (2π 4e5))² of the response; the order of the truncated
                        // tail is its cube.
                        assert!(
                            (exact - summed).norm() < 1e-8,
                            "{order:?} {interpolation:?} {delay} {f}: {exact} {summed}"
                        );
                    }
                }
            }
        }
    }
}
