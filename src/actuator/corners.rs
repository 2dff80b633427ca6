//! A step of a linear actuator whose command, behind its effects, has corners (as behind a rate limit), for approximate simulations in a
//! search: the response to the line at the start plus the response to each change of slope over the remainder of the step.
//!
//! ```text
//! z(T) = M(T) z(0) + ... + Σ Δslope G(T - t),   G the response of x, δ and v at rest to a slope of 1
//! ```

use nalgebra::Vector3;

use super::constants::Actuator;
use crate::{operator::FAST_POLE_RATIO, parameters::Order};

/// Number of terms of a series in time.
const TERMS: usize = 20;

/// Maximum step length in time constants of the fastest pole of the series: the first omitted term is 4e-11.
const MOST_TIME_CONSTANTS: f64 = 2.5;

/// G for times up to the step length.
#[derive(Debug, Clone)]
pub(super) struct CornerResponse {
    /// [s]
    duration: f64,
    k: f64,
    /// The pole p, if not part of the series [1/s].
    fast: Option<f64>,
    /// Series of x and δ in the fraction of the step.
    pole: [f64; TERMS],
    position: [f64; TERMS],
    /// Coefficient of e^(-pt) in δ.
    decay: f64,
}

impl Default for CornerResponse {
    /// Without a duration: NaN equals no number.
    fn default() -> Self {
        let none = [0.0; TERMS];
        Self { duration: f64::NAN, k: 0.0, fast: None, pole: none, position: none, decay: 0.0 }
    }
}

impl Actuator {
    /// Whether steps of this length [s] are short enough for corners.
    pub(super) fn has_corners_in(&self, duration: f64) -> bool {
        self.largest_pole * duration <= MOST_TIME_CONSTANTS
    }

    fn has_fast_pole(&self) -> bool {
        self.order == Order::Third && self.base.p() > FAST_POLE_RATIO * self.largest_pole
    }
}

impl CornerResponse {
    /// For an actuator without effects on its motion.
    pub fn new(actuator: &Actuator, duration: f64) -> Self {
        let (k, p, terms) = (actuator.base.k(), actuator.base.p(), &actuator.terms);
        let fast = actuator.has_fast_pole().then_some(p);
        let (mut pole, mut position, mut decay) = ([0.0; TERMS], [0.0; TERMS], 0.0);
        if fast.is_some() {
            // x = k (t - 1/p) + k/p e^(-pt); the drive responds to the decay with a decay.
            (pole[0], pole[1]) = (-k / p, k * duration);
            decay = terms.omega2 * (k / p) / (p * p - terms.damping * p + terms.omega2);
            (position[0], position[1]) = (-decay, p * decay * duration);
        } else if actuator.order == Order::Third {
            let pt = p * duration;
            for n in 0..TERMS - 1 {
                let command = if n == 1 { k * duration } else { 0.0 };
                pole[n + 1] = pt * (command - pole[n]) / (n + 1) as f64;
            }
        } else {
            pole[1] = k * duration;
        }
        let (spring, damping) = (terms.omega2 * duration * duration, terms.damping * duration);
        for n in 0..TERMS - 2 {
            let next = (n + 1) as f64;
            let force = spring * (pole[n] - position[n]) - damping * next * position[n + 1];
            position[n + 2] = force / (next * (next + 1.0));
        }
        Self { duration, k, fast, pole, position, decay }
    }

    /// Step length [s].
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// G after this time [s].
    pub fn after(&self, time: f64) -> Vector3<f64> {
        let share = time / self.duration;
        let (mut pole, mut position, mut rate) = (0.0, 0.0, 0.0);
        for n in (0..TERMS).rev() {
            rate = rate * share + position;
            position = position * share + self.position[n];
            pole = pole * share + self.pole[n];
        }
        let slow = Vector3::new(pole, position, rate / self.duration);
        let Some(p) = self.fast else { return slow };
        let fast = (-p * time).exp();
        slow + Vector3::new(self.k / p, self.decay, -p * self.decay) * fast
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        effects::Effects,
        parameters::Base,
        transition::{Ramp, Transition},
    };

    #[test]
    fn the_response_to_a_corner_is_that_to_a_ramp_from_rest() {
        const DURATION: f64 = 0.01;
        for (p, omega, zeta) in [(1e4, 160.0, 0.6), (90.0, 160.0, 0.3), (2e3, 60.0, 2.0), (700.0, 100.0, 1.0)] {
            for order in Order::ALL {
                let base = Base::from_values([1.2, p, omega, zeta]).unwrap();
                let actuator = Actuator::new(base, *order, &Effects::default());
                assert!(actuator.has_corners_in(DURATION) && !actuator.has_corners_in(10.0 * DURATION));
                let response = CornerResponse::new(&actuator, DURATION);
                for share in [0.0, 1e-3, 0.3, 0.7, 1.0] {
                    let time = share * DURATION;
                    let ramp = Ramp { value: 0.0, slope: 1.0 };
                    let expected = Transition::new(base, *order, time).apply(Vector3::zeros(), ramp);
                    let found = response.after(time);
                    let difference = (found - expected).component_div(&Vector3::new(DURATION, DURATION, 1.0)).amax();
                    assert!(difference < 1e-9, "{p} {omega} {order:?} {share}: {found} {expected}");
                }
            }
        }
    }
}
