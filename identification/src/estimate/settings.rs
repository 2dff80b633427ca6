//! Settings of a fit: method, order, delay, prior knowledge.

use serde::Serialize;

use super::pole::LagPrior;
use actuator_fmu::parameters::BAND_HZ;

/// Estimation method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Eq. (2) to (5) of the report: weighted errors of magnitude and phase, quasi-Newton steps.
    Report,
    /// Maximum likelihood on the records.
    #[default]
    Likelihood,
}

/// Order of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OrderChoice {
    /// Eq. (6).
    Second,
    /// Eq. (1).
    Third,
    /// The order favoured by the evidence in the records.
    #[default]
    Auto,
}

/// A delay between command and actuator, in addition to eq. (1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DelayChoice {
    /// Known \[s\].
    Declared(f64),
    /// To be estimated.
    Free,
}

impl Default for DelayChoice {
    fn default() -> Self {
        Self::Declared(0.0)
    }
}

/// Unit of the phase errors in the report's cost, which its text does not state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PhaseUnit {
    /// Degrees: consistent with the drift of p in table 2.
    #[default]
    Degree,
    /// Radians.
    Radian,
}

/// Settings of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Method.
    pub method: Method,
    /// Order.
    pub order: OrderChoice,
    /// Its delay.
    pub delay: DelayChoice,
    /// Prior knowledge of 1/p, if the records give none; for [`Method::Likelihood`].
    pub lag_prior: LagPrior,
    /// For [`Method::Report`].
    pub phase_unit: PhaseUnit,
    /// Band of the report's cost \[Hz\].
    pub band_hz: [f64; 2],
    /// Starts k, p, ω, ζ instead of the built-in ones.
    pub starts: Option<Vec<[f64; 4]>>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::default(),
            order: OrderChoice::default(),
            delay: DelayChoice::default(),
            lag_prior: LagPrior::default(),
            phase_unit: PhaseUnit::default(),
            band_hz: BAND_HZ,
            starts: None,
        }
    }
}
