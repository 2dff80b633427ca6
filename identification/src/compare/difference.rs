//! Two responses, and the difference between them.

use nalgebra::Complex;
use serde::Serialize;

use super::{condition::Condition, set::Set};
use crate::frequency::{BAND_HZ, phase_deg};
use actuator_fmu::parameters::Order;

/// Tolerances of a control law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Limits {
    /// For the magnitude [deg/deg].
    pub magnitude: f64,
    /// For the phase \[deg\].
    pub phase_deg: f64,
}

/// The report's: a tenth of margins of 6 dB, a factor of 2, and 30 deg.
pub const LIMITS: Limits = Limits { magnitude: 0.1, phase_deg: 3.0 };

/// Band in which the report places the key aeroelastic frequencies of the wing \[Hz\].
pub const AEROELASTIC_BAND_HZ: [f64; 2] = [3.0, 5.0];

/// Responses are compared every 0.01 Hz: a limit is first exceeded at the first of these frequencies beyond it.
pub const POINTS_PER_HZ: f64 = 100.0;

/// The difference between two sets.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// Label of the first.
    pub from: String,
    /// Label of the second.
    pub to: String,
    /// Conditions of both, if known.
    #[serde(skip)]
    pub conditions: Option<[Condition; 2]>,
    /// In the band of the report's data, 0.5 to 12 Hz.
    pub data_band: InBand,
    /// In 3 to 5 Hz.
    pub aeroelastic_band: InBand,
}

/// The difference in one band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct InBand {
    /// The band \[Hz\].
    pub band_hz: [f64; 2],
    /// | |H_b| - |H_a| | [deg/deg].
    pub magnitude: Extreme,
    /// |angle of H_b conj(H_a)| \[deg\].
    pub phase_deg: Extreme,
    /// Neither limit is exceeded.
    pub within_limits: bool,
}

/// The maximum in a band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extreme {
    /// Maximum.
    pub max: f64,
    /// Its frequency \[Hz\].
    pub at_hz: f64,
    /// Frequency at which the limit is first exceeded \[Hz\], if it is.
    pub first_passed_hz: Option<f64>,
    /// Standard error of the difference at that frequency, if a set was estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std_error: Option<f64>,
}

impl Difference {
    /// For two sets.
    #[must_use]
    pub fn between(from: &Set, to: &Set) -> Self {
        let (a, b) = (|frequency| from.response(frequency), |frequency| to.response(frequency));
        Self {
            from: from.label.clone(),
            to: to.label.clone(),
            conditions: from.condition.clone().zip(to.condition.clone()).map(<[Condition; 2]>::from),
            data_band: InBand::between(a, b, BAND_HZ).unsure(from, to),
            aeroelastic_band: InBand::between(a, b, AEROELASTIC_BAND_HZ).unsure(from, to),
        }
    }
}

/// Variance of a set's magnitude [(deg/deg)²] and phase [deg²] at a frequency [Hz], to first order: g' C g with the covariance C of (ln k,
/// ln ω, ln ζ, 1/p, T) and g = ∂ ln H, with relative changes of magnitude as real part and angles as imaginary part:
///
/// ```text
/// D = 1 + 2 ζ s/ω + (s/ω)²
/// ∂ ln H / ∂ ln k = 1,   / ∂ ln ω = (2 ζ s/ω + 2 (s/ω)²) / D,   / ∂ ln ζ = -(2 ζ s/ω) / D,   / ∂ 1/p = -s / (1 + s/p),   / ∂ T = -s
/// ```
fn variances(set: &Set, frequency_hz: f64) -> Option<[f64; 2]> {
    let covariance = set.covariance?;
    let base = &set.model.base;
    let s = Complex::new(0.0, std::f64::consts::TAU * frequency_hz);
    let ratio = s / base.omega();
    let (damping, inertia) = (ratio * (2.0 * base.zeta()), ratio * ratio);
    let whole = damping + inertia + 1.0;
    let lag_s = if set.model.order == Order::Third { 1.0 / base.p() } else { 0.0 };
    let g = [Complex::from(1.0), (damping + inertia * 2.0) / whole, -damping / whole, -s / (s * lag_s + 1.0), -s];
    let magnitude = set.response(frequency_hz).norm();
    let variance = |of: &dyn Fn(&Complex<f64>) -> f64| -> f64 {
        let terms = g
            .iter()
            .zip(&covariance)
            .map(|(a, row)| of(a) * row.iter().zip(&g).map(|(value, b)| value * of(b)).sum::<f64>());
        terms.sum()
    };
    let phase_deg = variance(&|value| value.im) * f64::to_degrees(1.0).powi(2);
    Some([variance(&|value| value.re) * magnitude * magnitude, phase_deg])
}

impl InBand {
    /// For two responses over frequency \[Hz\], of any origin, in a band \[Hz\].
    #[must_use]
    pub fn between(a: impl Fn(f64) -> Complex<f64>, b: impl Fn(f64) -> Complex<f64>, band_hz: [f64; 2]) -> Self {
        let [first, last] = band_hz.map(|end| (end * POINTS_PER_HZ).round());
        let pairs = (0..=(last - first).max(0.0) as u32).map(|index| {
            let frequency = (first + f64::from(index)) / POINTS_PER_HZ;
            (frequency, a(frequency), b(frequency))
        });
        Self::over(pairs, band_hz)
    }

    /// With the standard errors of its extremes, if a set has a covariance; sets without one count as exact.
    fn unsure(mut self, from: &Set, to: &Set) -> Self {
        if from.covariance.is_none() && to.covariance.is_none() {
            return self;
        }
        let error = |at_hz: f64, quantity: usize| {
            let of = |set: &Set| variances(set, at_hz).map_or(0.0, |variances| variances[quantity]);
            Some((of(from) + of(to)).sqrt()).filter(|error| error.is_finite())
        };
        self.magnitude.std_error = error(self.magnitude.at_hz, 0);
        self.phase_deg.std_error = error(self.phase_deg.at_hz, 1);
        self
    }

    /// For pairs of responses at given frequencies \[Hz\].
    #[must_use]
    pub fn over(pairs: impl IntoIterator<Item = (f64, Complex<f64>, Complex<f64>)>, band_hz: [f64; 2]) -> Self {
        let none = Extreme { max: 0.0, at_hz: band_hz[0], first_passed_hz: None, std_error: None };
        let (mut magnitude, mut phase) = (none, none);
        for (frequency, a, b) in pairs {
            magnitude.meet((b.norm() - a.norm()).abs(), frequency, LIMITS.magnitude);
            phase.meet(phase_deg(b * a.conj()).abs(), frequency, LIMITS.phase_deg);
        }
        let within_limits = magnitude.first_passed_hz.is_none() && phase.first_passed_hz.is_none();
        Self { band_hz, magnitude, phase_deg: phase, within_limits }
    }
}

impl Extreme {
    fn meet(&mut self, value: f64, frequency_hz: f64, limit: f64) {
        if value > self.max {
            (self.max, self.at_hz) = (value, frequency_hz);
        }
        if value > limit && self.first_passed_hz.is_none() {
            self.first_passed_hz = Some(frequency_hz);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_phase_across_half_a_turn_is_no_jump() {
        // 179 deg and -179 deg differ by 2 deg.
        let a = |_| Complex::from_polar(1.0, 179_f64.to_radians());
        let b = |_| Complex::from_polar(1.05, -179_f64.to_radians());
        let difference = InBand::between(a, b, [0.5, 12.0]);
        assert!((difference.phase_deg.max - 2.0).abs() < 1e-9 && (difference.magnitude.max - 0.05).abs() < 1e-12);
        assert!(difference.within_limits);
    }

    #[test]
    fn a_limit_is_first_passed_where_the_difference_exceeds_it() {
        // A phase difference of 0.249 f stays below 3 deg; one of 0.4995 f exceeds 3 deg at 6.006 Hz, detected at the next hundredth.
        let apart = |share: f64| move |f: f64| Complex::from_polar(1.0, (f * share).to_radians());
        assert_eq!(InBand::between(apart(0.0), apart(0.249), [0.5, 12.0]).phase_deg.first_passed_hz, None);
        let first = InBand::between(apart(0.0), apart(0.4995), [0.5, 12.0]).phase_deg.first_passed_hz.unwrap();
        assert!((first - 6.01).abs() < 1e-9, "{first}");
        // A magnitude difference of 0.01999 f exceeds 0.1 at 5.003 Hz.
        let grown = InBand::between(|_| Complex::from(1.0), |f| Complex::from(1.0 + 0.01999 * f), [3.0, 12.0]);
        assert!((grown.magnitude.first_passed_hz.unwrap() - 5.01).abs() < 1e-9);
    }

    #[test]
    fn errors_of_a_difference_follow_from_those_of_the_parameters() {
        // One parameter at a time, by finite differences of the response.
        let set = &crate::compare::Comparison::of_tables().sets[3];
        let (errors, step) = ([2e-3, 1e-2, 2e-2, 1e-5, 1e-4], 1e-3);
        for (parameter, error) in errors.into_iter().enumerate() {
            let mut covariance = [[0.0; 5]; 5];
            covariance[parameter][parameter] = error * error;
            let found = variances(&Set { covariance: Some(covariance), ..set.clone() }, 9.0).unwrap().map(f64::sqrt);
            let moved = |by: f64| {
                let mut values = set.model.base.values();
                let mut delay_s = 0.0;
                match parameter {
                    4 => delay_s += by,
                    3 => values[1] = 1.0 / (1.0 / values[1] + by),
                    0 => values[0] *= by.exp(),
                    other => values[other + 1] *= by.exp(),
                }
                let base = actuator_fmu::parameters::Base::from_values(values).unwrap();
                let model = actuator_fmu::parameters::Model { base, ..set.model.clone() };
                Set { model, delay_s, ..set.clone() }.response(9.0)
            };
            let (more, less) = (moved(step * error), moved(-step * error));
            let expected = [(more.norm() - less.norm()) / (2.0 * step), phase_deg(more * less.conj()) / (2.0 * step)]
                .map(f64::abs);
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-6 * (1e-3 + expected), "{parameter}: {found} {expected}");
            }
        }
    }
}
