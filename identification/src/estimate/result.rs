//! Result of a fit: the model, its uncertainty, and the residual of each record.

use serde::Serialize;

use super::{
    layout::{Lag, Layout},
    noise::Noise,
    output_error::{OutputError, RecordResidual},
    settings::Method,
    simulation::Simulator,
};
use crate::{
    frequency::DelayedModel,
    signal::record::{Record, rms},
};
use actuator_fmu::{
    error::{Error, Result},
    parameters::{Model, Order},
};

/// One estimated number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// `k`, `p`, `omega`, `zeta` or `delay`.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The estimate.
    pub value: f64,
    /// Standard error; `None` if the method gives none.
    pub std_error: Option<f64>,
    /// 95 % interval; `None` if the method gives none.
    pub interval_95: Option<[f64; 2]>,
    /// Whether it is at a bound.
    pub at_bound: bool,
}

/// Information in the records on the first-order pole p.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pole {
    /// Only a lower 95 % bound [1/s]: a value of p would be arbitrary.
    Above(f64),
    /// A value, which is then among the estimates.
    Found,
    /// The method gives no information.
    Untold,
}

/// Residual of one record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RecordFit {
    /// Its file.
    pub source: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Samples.
    pub samples: usize,
    /// Root mean square of measured minus modelled position.
    pub residual_rms: f64,
    /// As above, relative to that of the position.
    pub residual_share: f64,
    /// Constant offset of the measurement, free in each record.
    pub offset: f64,
}

impl RecordFit {
    pub(super) fn new(record: &Record, record_residual: &RecordResidual) -> Self {
        let residual_rms = rms(&record_residual.residual);
        Self {
            source: record.source().display().to_string(),
            sha256: record.sha256().to_owned(),
            samples: record.len(),
            residual_rms,
            residual_share: residual_rms / rms(record.position()).max(f64::MIN_POSITIVE),
            offset: record_residual.offset,
        }
    }
}

/// The end of one start.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StartResult {
    /// k, p, ω, ζ.
    pub start: [f64; 4],
    /// k, p, ω, ζ.
    pub end: [f64; 4],
    /// Cost at the end.
    pub cost: f64,
    /// Number of steps.
    pub iterations: usize,
    /// How it ended.
    pub ending: String,
    /// Whether it ended by a convergence rule.
    pub converged: bool,
    /// Whether it led to the best end: k, ω and ζ within 1 % or, for maximum likelihood, within one standard error.
    pub at_best: bool,
}

/// Evidence of the records for one model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evidence {
    /// In words, `second order`.
    pub model: String,
    /// Number of estimated parameters.
    pub parameters: usize,
    /// Bayesian information criterion relative to that of the best; 10 is strong evidence against it.
    pub delta_bic: f64,
}

/// The result of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The model, with standard errors and provenance.
    pub model: Model,
    /// Method.
    pub method: Method,
    /// Estimated parameters, without nuisance parameters of single records.
    pub estimates: Vec<Estimate>,
    /// Correlations of the estimates, in their order; empty if the method gives none.
    pub correlations: Vec<Vec<f64>>,
    /// Covariance of ln |k|, ln ω, ln ζ, the lag 1/p \[s\] and the delay \[s\], for derived quantities such as responses. Zero for a lag that
    /// the model does not have and a delay that was declared; `None` if the method gives no errors.
    pub covariance: Option<[[f64; 5]; 5]>,
    /// Information on p.
    pub pole: Pole,
    /// Delay \[s\], declared or estimated; in the model it is the effect `delay`.
    pub delay_s: f64,
    /// How the search ended, in words.
    pub ending: String,
    /// Whether it converged to a minimum.
    pub converged: bool,
    /// Names of parameters at a bound.
    pub at_bound: Vec<String>,
    /// What the records do not determine, in words.
    pub not_identifiable: Vec<String>,
    /// End of each start.
    pub starts: Vec<StartResult>,
    /// Unit of positions, residuals and offsets.
    pub unit: &'static str,
    /// Root mean square of measured minus modelled position, over all records.
    pub residual_rms: f64,
    /// Standard deviation of the white noise behind the residual.
    pub innovation_rms: f64,
    /// Order of the autoregression that describes the colour of the noise, 0 for white noise; `None` if the method estimates no noise: the
    /// report's uses the residual unchanged.
    pub noise_order: Option<usize>,
    /// Effective number of independent samples; all of them if the method estimates no noise.
    pub effective_samples: f64,
    /// Each record.
    pub records: Vec<RecordFit>,
    /// Models compared, the best one first.
    pub evidence: Vec<Evidence>,
    /// Notes.
    pub notes: Vec<String>,
}

impl Fit {
    /// Measured minus modelled position of another record, at its times, with only its start and a constant offset free.
    ///
    /// # Errors
    /// A record in another unit.
    pub fn residual_on(&self, record: &Record) -> Result<Vec<f64>> {
        Ok(self.remainder_on(record)?.residual)
    }

    /// Prediction of a record that was not fitted, with only its start and a constant offset free.
    ///
    /// # Errors
    /// A record in another unit.
    pub fn prediction_of(&self, record: &Record) -> Result<RecordFit> {
        Ok(RecordFit::new(record, &self.remainder_on(record)?))
    }

    fn remainder_on(&self, record: &Record) -> Result<RecordResidual> {
        if record.unit().name() != self.unit {
            return Err(Error::new("unit of the record", record.unit().name(), self.unit).at(record.source(), None));
        }
        Ok(residual_of(&DelayedModel { base: self.model.base, order: self.model.order, delay_s: self.delay_s }, record))
    }
}

/// Residual of a model on a record, with only its start and a constant offset free.
pub(super) fn residual_of(model: &DelayedModel, record: &Record) -> RecordResidual {
    let lag = match model.order {
        Order::Second => Lag::None,
        Order::Third => Lag::Fixed(1.0 / model.base.p()),
    };
    let layout = Layout { lag, declared_delay_s: Some(model.delay_s), sign: model.base.k().signum() };
    let simulators = [(record, Simulator::new(record))];
    let problem = OutputError::new(layout, &simulators, vec![Noise::white(1.0)]);
    // A damping ratio of zero has no logarithm; the minimum of a search is close to it.
    problem.residuals(&layout.vector(model)).pop().unwrap_or_else(|| RecordResidual::all(record))
}
