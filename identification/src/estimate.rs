//! Parameter estimation: records to parameters with their uncertainty.
//!
//! [`fit`] is the entry point: maximum likelihood on the records themselves (`likelihood`, the default) or the report's weighted least
//! squares on frequency responses (`report`).

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
/// No record; records in different units; a declared delay with which no model explains the records, although one without it does; for the
/// report's method, records from which Welch's method gives no response.
pub fn fit(records: &[Record], settings: &Settings) -> Result<Fit> {
    fit_reporting(records, settings, None)
}

/// As above, with a progress callback.
///
/// # Errors
/// As [`fit`].
pub fn fit_reporting(records: &[Record], settings: &Settings, report: Option<Report<'_>>) -> Result<Fit> {
    let Some(first) = records.first() else { return Err(Error::new("records", "none", "one or more")) };
    if let Some(other) = records.iter().find(|record| record.unit() != first.unit()) {
        let found = format!("{} and {}", first.unit(), other.unit());
        return Err(Error::new("units of the records", found, "one unit").at(other.source(), None));
    }
    let fit_with = |settings: &Settings, report| match settings.method {
        Method::Likelihood => likelihood::fit(records, settings, report),
        Method::Report => report::fit(records, settings),
    };
    let mut fit = fit_with(settings, report)?;
    if let DelayChoice::Declared(delay) = settings.delay
        && delay > 0.0
        && left(&fit) > UNEXPLAINED
    {
        let without = fit_with(&Settings { delay: DelayChoice::Declared(0.0), ..settings.clone() }, None)?;
        if left(&without) < 0.5 * left(&fit) {
            let percent = |fit| 100.0 * left(fit);
            let left =
                format!("a model leaves {:.0} % of the positions, {:.0} % without", percent(&fit), percent(&without));
            return Err(Error::new("delay", format!("{delay} s, with which {left}"), "a delay that the records have")
                .remedy("give it in seconds (5 ms are 0.005), or have it estimated: --delay free"));
        }
    }
    fit.model.identity.unit = first.unit();
    Ok(fit)
}

/// Relative residual rms above which a model explains nothing of a position.
const UNEXPLAINED: f64 = 0.5;

/// Minimum relative residual rms of a model over the records.
fn left(fit: &Fit) -> f64 {
    fit.records.iter().map(|record| record.residual_share).fold(f64::INFINITY, f64::min)
}
