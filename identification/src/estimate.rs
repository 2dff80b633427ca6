//! Parameter estimation: records to parameters with their uncertainty.
//!
//! [`fit`] does it, by maximum likelihood on the records themselves (`likelihood`, the default) or by the report's weighted
//! least squares on frequency responses (`report`).

mod covariance;
mod dependence;
mod layout;
mod likelihood;
pub(crate) mod noise;
mod outcome;
mod output_error;
mod pole;
mod quasi_newton;
mod rate_noise;
mod report;
mod result;
mod search;
mod settings;
mod simulation;

use crate::{progress::Report, signal::record::Record};
use actuator_fmu::error::{Error, Result};

pub use pole::LagPrior;
pub use result::{Estimate, Evidence, Fit, Pole, RecordFit, StartResult};
pub use settings::{DelayChoice, Method, OrderChoice, PhaseUnit, Settings};

/// Estimates a model from records of one actuator under one condition.
///
/// # Errors
/// No record; records in different units; for the report's method, records from which Welch's method can make no response.
pub fn fit(records: &[Record], settings: &Settings) -> Result<Fit> {
    fit_reporting(records, settings, None)
}

/// The same, with word of how much of the search is done.
///
/// # Errors
/// As [`fit`].
pub fn fit_reporting(records: &[Record], settings: &Settings, report: Option<Report<'_>>) -> Result<Fit> {
    let Some(first) = records.first() else { return Err(Error::new("records", "none", "one or more")) };
    if let Some(other) = records.iter().find(|record| record.unit() != first.unit()) {
        let found = format!("{} and {}", first.unit(), other.unit());
        return Err(Error::new("units of the records", found, "one unit").at(other.source(), None));
    }
    let mut fit = match settings.method {
        Method::Likelihood => likelihood::fit(records, settings, report),
        Method::Report => report::fit(records, settings),
    }?;
    fit.model.identity.unit = first.unit();
    Ok(fit)
}
