//! The linear actuator over a finite time, exactly.
//!
//! With command c, pole state x, position δ and rate v (eq. (1) of NASA/TM-1998-208452 in the time domain; eq. (6) is
//! the same with x = k c):
//!
//! ```text
//! ẋ = p (k c - x),   δ̇ = v,   v̇ = ω² (x - δ) - 2 ζ ω v
//! ```
//!
//! For a command c0 + c1 t the solution is a particular one plus the free motion of the difference:
//!
//! ```text
//! z(t) = zp(t) + M(t) (z(0) - zp(0)),   z = (x, δ, v)
//! xp = k (c0 + c1 t - c1 / p),   δp = xp - 2 ζ k c1 / ω,   vp = k c1
//! ```
//!
//! M(t) is in closed form, so that the accuracy depends neither on the step size nor on p t, which reaches 1e6.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::{
    exponential::{Terms, exponential},
    parameters::{Base, Order},
};

/// A linear command over a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Ramp {
    /// At the start \[deg\].
    pub value: f64,
    /// Per second [deg/s]; 0 for a held command.
    pub slope: f64,
}

impl Ramp {
    /// A constant command.
    #[must_use]
    pub fn held(value: f64) -> Self {
        Self { value, slope: 0.0 }
    }

    /// True if it is 0 and stays so.
    #[must_use]
    #[inline]
    pub fn is_zero(self) -> bool {
        // Both signs of 0.
        (self.value.to_bits() | self.slope.to_bits()) << 1 == 0
    }

    /// The command after `time` \[s\].
    #[must_use]
    #[inline]
    pub fn at(self, time: f64) -> f64 {
        self.value + self.slope * time
    }
}

/// M(t) of one actuator for one duration.
#[derive(Debug, Clone, PartialEq)]
pub struct Transition {
    duration: f64,
    free: Matrix3<f64>,
    particular: Particular,
}

impl Default for Transition {
    /// Without a duration: NaN equals no number.
    fn default() -> Self {
        Self { duration: f64::NAN, free: Matrix3::zeros(), particular: Particular::default() }
    }
}

/// Factors of the particular solution, divided once.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Particular {
    k: f64,
    /// Lag of x behind k c: 1/p, or 0 for order 2 [s].
    lag: f64,
    /// Lag of δ behind x: 2 ζ / ω [s].
    drive_lag: f64,
}

impl Particular {
    fn new(base: &Base, order: Order) -> Self {
        let lag = match order {
            Order::Second => 0.0,
            Order::Third => 1.0 / base.p(),
        };
        Self { k: base.k(), lag, drive_lag: 2.0 * base.zeta() / base.omega() }
    }

    #[inline]
    fn at(&self, command: Ramp, time: f64) -> Vector3<f64> {
        let slope = self.k * command.slope;
        let x = self.k * command.at(time) - slope * self.lag;
        Vector3::new(x, x - slope * self.drive_lag, slope)
    }
}

/// A free response below this is set to zero: it is far below rounding, and subnormal numbers would triple the time of a step.
const NEGLIGIBLE: f64 = 1e-290;

#[cold]
fn is_negligible(free: Vector3<f64>) -> bool {
    free.amax() < NEGLIGIBLE
}

/// Relative to p² + ω²: below it the characteristic polynomial at -p is so small that the partial fractions cancel.
const NEARLY_DOUBLE_POLE: f64 = 1e-2;

impl Transition {
    /// Over `duration` \[s\] >= 0.
    #[must_use]
    pub fn new(base: Base, order: Order, duration: f64) -> Self {
        let free = match order {
            Order::Second => second_order(&base, duration, Vector3::zeros()),
            Order::Third => third_order(&base, duration),
        };
        Self { duration, free, particular: Particular::new(&base, order) }
    }

    /// Its duration \[s\].
    #[must_use]
    #[inline]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// (x, δ, v) after the step, from (x, δ, v) before it.
    #[must_use]
    #[inline]
    pub fn apply(&self, before: Vector3<f64>, command: Ramp) -> Vector3<f64> {
        if command.slope != 0.0 {
            let (at_start, at_end) = (self.particular.at(command, 0.0), self.particular.at(command, self.duration));
            return self.with_particular(before, at_start, at_end);
        }
        // As above for a held command, whose particular solution is at rest.
        let x = self.particular.k * command.value;
        let at_rest = Vector3::new(x, x, 0.0);
        self.with_particular(before, at_rest, at_rest)
    }

    #[inline]
    fn with_particular(&self, before: Vector3<f64>, at_start: Vector3<f64>, at_end: Vector3<f64>) -> Vector3<f64> {
        let free = self.free * (before - at_start);
        // One comparison, as long as the drive moves.
        if free.y.abs() < NEGLIGIBLE && is_negligible(free) { at_end } else { at_end + free }
    }

    /// ∂(x, δ, v) at the end of the step with respect to the held command.
    #[must_use]
    pub fn by_command(&self) -> Vector3<f64> {
        let unit = self.particular.at(Ramp::held(1.0), 0.0);
        unit - self.free * unit
    }
}

/// e^{-σt} cosh(t √Δ) and e^{-σt} sinh(t √Δ) / √Δ with σ = ζω and Δ = ω² (ζ² - 1), whatever the sign of Δ.
fn damped(base: &Base, t: f64) -> (f64, f64) {
    let (omega, zeta) = (base.omega(), base.zeta());
    let sigma = zeta * omega;
    let root = omega * ((zeta - 1.0).abs() * (zeta + 1.0)).sqrt();
    if root == 0.0 {
        let decay = (-sigma * t).exp();
        (decay, t * decay)
    } else if zeta < 1.0 {
        let decay = (-sigma * t).exp();
        let (sin, cos) = (root * t).sin_cos();
        (decay * cos, decay * sin / root)
    } else {
        // The slower real pole is ω² / (σ + √Δ): this form does not cancel when ζ is large.
        let slow = (-omega * omega / (sigma + root) * t).exp();
        let difference = (-2.0 * root * t).exp_m1();
        (slow * (1.0 + 0.5 * difference), slow * -difference / (2.0 * root))
    }
}

/// M, given its first column, the response to x(0).
fn second_order(base: &Base, t: f64, first_column: Vector3<f64>) -> Matrix3<f64> {
    let (c, s) = damped(base, t);
    let sigma = base.zeta() * base.omega();
    let omega2 = base.omega() * base.omega();
    Matrix3::from_columns(&[
        first_column,
        Vector3::new(0.0, c + sigma * s, -omega2 * s),
        Vector3::new(0.0, s, c - sigma * s),
    ])
}

/// δ due to x(0) e^{-pt} by partial fractions: ω² (e^{-pt} - C - σ S + p S) / D with D = p² - 2σp + ω².
fn third_order(base: &Base, t: f64) -> Matrix3<f64> {
    let (p, omega, sigma) = (base.p(), base.omega(), base.zeta() * base.omega());
    let omega2 = omega * omega;
    let d = (p - sigma) * (p - sigma) + omega2 - sigma * sigma;
    if d.abs() < NEARLY_DOUBLE_POLE * (p * p + omega2) {
        return by_matrix_exponential(base, t);
    }
    let (c, s) = damped(base, t);
    let pole = (-p * t).exp();
    let response = (pole - c - sigma * s + p * s) / d;
    second_order(base, t, Vector3::new(pole, omega2 * response, omega2 * (s - p * response)))
}

/// Scaling and squaring. Only used if p is next to a pole of the second-order part, so that p t is of the size of ω t and never the 1e6 at
/// which squaring loses digits.
fn by_matrix_exponential(base: &Base, t: f64) -> Matrix3<f64> {
    let (p, omega2, sigma) = (base.p(), base.omega() * base.omega(), base.zeta() * base.omega());
    let columns = [[-p * t, 0.0, omega2 * t], [0.0, 0.0, -omega2 * t], [0.0, t, -2.0 * sigma * t]];
    exponential(columns, Terms::Fourteen).into()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn base() -> impl Strategy<Value = Base> {
        // p over twelve decades, ω and ζ around and far beyond the tables.
        ((-1.0_f64..9.0), (0.0_f64..4.0), (0.0_f64..4.0))
            .prop_map(|(p, omega, zeta)| Base::new(1.1, 10_f64.powf(p), 10_f64.powf(omega), zeta).unwrap())
    }

    fn scaled_difference(base: &Base, a: Vector3<f64>, b: Vector3<f64>) -> f64 {
        let scale = Vector3::new(1.0, 1.0, 1.0 / base.omega());
        (a - b).component_mul(&scale).amax()
    }

    proptest! {
        /// Two steps equal one: the semigroup law, which detects any error of M. The starting value is 1 deg, the slope up to 1e3 deg/s;
        /// absolute tolerance 1e-9 of that.
        #[test]
        fn two_steps_are_one(base in base(), order in prop::sample::select(Order::ALL), h in -7.0_f64..0.5, cut in 0.01_f64..0.99, slope in -1.0_f64..1.0) {
            let h = 10_f64.powf(h);
            let command = Ramp { value: 0.7, slope };
            let start = Vector3::new(0.2, -0.3, 0.5 * base.omega());
            let whole = Transition::new(base, order, h).apply(start, command);
            let middle = Transition::new(base, order, h * cut).apply(start, command);
            let rest = Ramp { value: command.at(h * cut), slope };
            let both = Transition::new(base, order, h - h * cut).apply(middle, rest);
            let size = 1.0 + (slope / base.p()).abs() + (slope * base.zeta() / base.omega()).abs();
            prop_assert!(scaled_difference(&base, whole, both) < 1e-9 * size, "{whole} {both}");
        }

        /// The closed form against scaling and squaring, an independent route, where that is accurate (p t < 1e3).
        #[test]
        fn closed_form_is_the_matrix_exponential(base in base(), t in -4.0_f64..0.0) {
            let t = 10_f64.powf(t);
            prop_assume!(base.p() * t < 1e3 && base.zeta() * base.omega() * t < 1e2);
            let closed = third_order(&base, t);
            let squared = by_matrix_exponential(&base, t);
            for column in 0..3 {
                let unit = if column == 2 { base.omega() } else { 1.0 };
                let difference = scaled_difference(&base, closed.column(column) * unit, squared.column(column) * unit);
                prop_assert!(difference < 1e-9, "{difference}");
            }
        }
    }

    #[test]
    fn a_held_command_is_reached_and_kept() {
        let base = Base::new(1.0767, 2.97e8, 100.72, 0.4615).unwrap();
        let transition = Transition::new(base, Order::Third, 0.005);
        let mut z = Vector3::zeros();
        for _ in 0..4000 {
            z = transition.apply(z, Ramp::held(2.0));
        }
        // A few roundings of 2.1534 deg, and of the rate that belongs to them.
        assert!(scaled_difference(&base, z, Vector3::new(2.1534, 2.1534, 0.0)) < 4.0 * 2.1534 * f64::EPSILON, "{z}");
    }

    #[test]
    fn a_double_pole_is_no_exception() {
        // p on the slow real pole: the partial fractions divide by zero, the exponential does not.
        let base = Base::new(1.0, 50.0, 100.0, 1.25).unwrap();
        let h = 1e-3;
        let one = third_order(&base, 2.0 * h);
        let two = third_order(&base, h) * third_order(&base, h);
        assert!((one - two).amax() < 1e-11, "{one} {two}");
    }
}
