//! Eq. (1) or (6) behind a delay: H(s) exp(-s T).

use nalgebra::Complex;

use super::transfer_function::response;
use actuator_fmu::parameters::{Base, Order};

/// A linear model whose command is delayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelayedModel {
    /// k, p, ω, ζ.
    pub base: Base,
    /// Second or third.
    pub order: Order,
    /// T, between command and actuator \[s\].
    pub delay_s: f64,
}

impl DelayedModel {
    /// Its response at a frequency \[Hz\].
    #[must_use]
    pub fn response(&self, frequency_hz: f64) -> Complex<f64> {
        let lag = Complex::from_polar(1.0, -std::f64::consts::TAU * frequency_hz * self.delay_s);
        response(&self.base, self.order, frequency_hz) * lag
    }
}
