//! What a fit comes to: the model, its errors, and how each record is explained.

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
    /// Standard error; none where the method states none.
    pub std_error: Option<f64>,
    /// 95 % interval; none where the method states none.
    pub interval_95: Option<[f64; 2]>,
    /// Whether it lies at the edge of what is allowed.
    pub at_bound: bool,
}

/// What the records say of the first-order pole p.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pole {
    /// Only that it is above this [1/s], with 95 % confidence: a number for p would be an invention.
    Above(f64),
    /// A number, which then stands among the estimates.
    Found,
    /// The method has no way to tell.
    Untold,
}

/// How one record is explained.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RecordFit {
    /// Its file.
    pub source: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Samples.
    pub samples: usize,
    /// Root mean square of measured less modelled position.
    pub residual_rms: f64,
    /// The same as a share of the position's own.
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

/// Where one start led.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StartResult {
    /// k, p, ω, ζ.
    pub start: [f64; 4],
    /// k, p, ω, ζ.
    pub end: [f64; 4],
    /// The cost there.
    pub cost: f64,
    /// Steps.
    pub iterations: usize,
    /// How it ended.
    pub ending: String,
    /// Whether a rule of convergence ended it.
    pub converged: bool,
    /// Whether it led to the best end found: k, ω and ζ within 1 %, or, by likelihood, no standard error away from it.
    pub at_best: bool,
}

/// How much the records speak for one model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evidence {
    /// In words, `second order`.
    pub model: String,
    /// Numbers estimated.
    pub parameters: usize,
    /// Bayesian information criterion above that of the best; 10 is strong evidence against it.
    pub delta_bic: f64,
}

/// The result of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The model, with standard errors and where it came from.
    pub model: Model,
    /// How it was estimated.
    pub method: Method,
    /// What was estimated, nuisances of single records left out.
    pub estimates: Vec<Estimate>,
    /// Correlations of the estimates, in their order; empty where the method states none.
    pub correlations: Vec<Vec<f64>>,
    /// Covariance of ln |k|, ln ω, ln ζ, the lag 1/p [s] and the delay [s], for what follows from them together, such as responses.
    /// Zero for a lag that the model does not have and a delay that was declared; none where the method states no errors.
    pub covariance: Option<[[f64; 5]; 5]>,
    /// What is known of p.
    pub pole: Pole,
    /// Delay [s], declared or estimated; in the model it is the effect `delay`.
    pub delay_s: f64,
    /// How the search ended, in words.
    pub ending: String,
    /// Whether it ended at a minimum.
    pub converged: bool,
    /// Names of parameters at the edge of what is allowed.
    pub at_bound: Vec<String>,
    /// What the records cannot tell, in words.
    pub not_identifiable: Vec<String>,
    /// Where each start led.
    pub starts: Vec<StartResult>,
    /// Unit of positions, residuals and offsets.
    pub unit: &'static str,
    /// Root mean square of measured less modelled position, over all records.
    pub residual_rms: f64,
    /// Standard deviation of the white noise behind the residual.
    pub innovation_rms: f64,
    /// Order of the autoregression that describes the colour of the noise, 0 for white noise; none where the method estimates none: the report's
    /// takes what is left as it is.
    pub noise_order: Option<usize>,
    /// Samples that white noise would need to say as much; all of them where the method estimates no noise.
    pub effective_samples: f64,
    /// Each record.
    pub records: Vec<RecordFit>,
    /// Models compared, the best one first.
    pub evidence: Vec<Evidence>,
    /// What to keep in mind.
    pub notes: Vec<String>,
}

impl Fit {
    /// Measured less modelled position of another record, at its times, with nothing free but where it starts and a constant
    /// offset.
    ///
    /// # Errors
    /// A record in another unit.
    pub fn residual_on(&self, record: &Record) -> Result<Vec<f64>> {
        Ok(self.remainder_on(record)?.residual)
    }

    /// How a record that was not fitted is predicted, with nothing free but where it starts and a constant offset.
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

/// What a model leaves of a record, with nothing free but where it starts and a constant offset.
pub(super) fn residual_of(model: &DelayedModel, record: &Record) -> RecordResidual {
    let lag = match model.order {
        Order::Second => Lag::None,
        Order::Third => Lag::Fixed(1.0 / model.base.p()),
    };
    let layout = Layout { lag, declared_delay_s: Some(model.delay_s), sign: model.base.k().signum() };
    let simulators = [(record, Simulator::new(record))];
    let problem = OutputError::new(layout, &simulators, vec![Noise::white(1.0)]);
    // A damping ratio of zero has no logarithm; the least one of a search is next to it.
    problem.residuals(&layout.vector(model)).pop().unwrap_or_else(|| RecordResidual::all(record))
}
