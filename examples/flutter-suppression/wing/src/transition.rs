//! The linear system over a finite time, exactly, for inputs that are held or move linearly.
//!
//! Inputs and their slopes join the states, u̇ = s, ṡ = 0; one matrix exponential of the whole (Van Loan 1978) holds
//!
//! ```text
//! z⁺ = Φ z + Γ₀ u + Γ₁ s
//! ```

use nalgebra::{SMatrix, SVector};

use crate::equations::{INPUTS, STATES, System};

const WHOLE: usize = STATES + 2 * INPUTS;

/// Φ, Γ₀ and Γ₁ of one duration.
#[derive(Debug, Clone, PartialEq)]
pub struct Transition {
    states: SMatrix<f64, STATES, STATES>,
    values: SMatrix<f64, STATES, INPUTS>,
    slopes: SMatrix<f64, STATES, INPUTS>,
}

impl Transition {
    /// Of this system over this time \[s\].
    #[must_use]
    pub fn new(system: &System, duration_s: f64) -> Self {
        let mut whole = SMatrix::<f64, WHOLE, WHOLE>::zeros();
        whole.fixed_view_mut::<STATES, STATES>(0, 0).copy_from(&system.states);
        whole.fixed_view_mut::<STATES, INPUTS>(0, STATES).copy_from(&system.inputs);
        whole.fixed_view_mut::<INPUTS, INPUTS>(STATES, STATES + INPUTS).fill_with_identity();
        let moved = exponential(&(whole * duration_s));
        Self {
            states: moved.fixed_view::<STATES, STATES>(0, 0).into_owned(),
            values: moved.fixed_view::<STATES, INPUTS>(0, STATES).into_owned(),
            slopes: moved.fixed_view::<STATES, INPUTS>(0, STATES + INPUTS).into_owned(),
        }
    }

    /// The states at the end.
    #[must_use]
    pub fn apply(
        &self,
        states: &SVector<f64, STATES>,
        inputs: &SVector<f64, INPUTS>,
        slopes: &SVector<f64, INPUTS>,
    ) -> SVector<f64, STATES> {
        self.states * states + self.values * inputs + self.slopes * slopes
    }
}

/// e^A: the series of a part of A whose norm is 1/2 at most, squared again as often as A was halved. What is left out, 0.5^15 / 15!, is less than is
/// rounded.
fn exponential(matrix: &SMatrix<f64, WHOLE, WHOLE>) -> SMatrix<f64, WHOLE, WHOLE> {
    let norm =
        matrix.column_iter().map(|column| column.iter().map(|entry| entry.abs()).sum::<f64>()).fold(0.0, f64::max);
    let squares = (2.0 * norm).log2().ceil().clamp(0.0, 64.0) as i32;
    let part = matrix * 0.5_f64.powi(squares);
    let (mut sum, mut term) = (SMatrix::identity(), SMatrix::identity());
    for n in 1..=14 {
        term = term * part / f64::from(n);
        sum += term;
    }
    (0..squares).fold(sum, |root, _| root * root)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::equations::Condition;

    fn system() -> System {
        Condition { pressure_psf: 200.0, speed_ft_s: 385.0, gain: 1.0 }.system().unwrap()
    }

    fn start() -> (SVector<f64, STATES>, SVector<f64, INPUTS>, SVector<f64, INPUTS>) {
        (
            SVector::from([0.02, -0.003, 0.1, 0.2, 1e-4, 2e-4]),
            SVector::from([1.5, 0.7, -3.0]),
            SVector::from([-20.0, 4.0, 9.0]),
        )
    }

    /// 1e-12 of the states: some roundings per step.
    #[test]
    fn a_step_is_the_same_in_pieces() {
        let (system, (states, inputs, slopes)) = (system(), start());
        let whole = Transition::new(&system, 0.01).apply(&states, &inputs, &slopes);
        let (mut pieces, mut now) = (states, inputs);
        for duration_s in [0.001, 0.0025, 0.0065] {
            pieces = Transition::new(&system, duration_s).apply(&pieces, &now, &slopes);
            now += slopes * duration_s;
        }
        assert!((whole - pieces).norm() <= 1e-12 * whole.norm(), "{whole} {pieces}");
    }

    /// Runge-Kutta's fourth-order steps of 10 µs, whose error is far below the tolerance of 1e-10.
    #[test]
    fn it_is_what_the_equations_integrate_to() {
        let (system, (mut states, inputs, slopes)) = (system(), start());
        let exact = Transition::new(&system, 0.005).apply(&states, &inputs, &slopes);
        let step_s = 1e-5;
        let rate =
            |z: SVector<f64, STATES>, time_s: f64| system.states * z + system.inputs * (inputs + slopes * time_s);
        for index in 0..500 {
            let time_s = f64::from(index) * step_s;
            let k1 = rate(states, time_s);
            let k2 = rate(states + k1 * (0.5 * step_s), time_s + 0.5 * step_s);
            let k3 = rate(states + k2 * (0.5 * step_s), time_s + 0.5 * step_s);
            let k4 = rate(states + k3 * step_s, time_s + step_s);
            states += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (step_s / 6.0);
        }
        assert!((exact - states).norm() <= 1e-10 * exact.norm(), "{exact} {states}");
    }
}
