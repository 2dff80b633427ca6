//! Diagnosis: where simulation and records disagree, which effect the model lacks, and with what evidence.
//!
//! [`diagnose`] is a selection of model structure by forward selection and backward elimination: the base is refitted, every effect of
//! the chain is screened and fitted beside it, an effect must be significant on fitted and on hold-out records, and the residual must be
//! noise in the end. A false alarm is the worst answer of all; "none of these" is an answer.

mod adequacy;
mod candidates;
mod check_only;
mod conclusion;
mod detectable;
mod diagnosis;
mod evidence;
mod fitted;
mod folds;
mod hold_out;
mod hypothesis;
mod late;
mod leave_one_out;
mod linear_rival;
pub mod location;
mod measured_noise;
pub mod next_test;
mod outcome;
mod output_error;
mod plain_fit;
mod predictable;
mod quantisation;
pub mod quantiser;
pub mod regressors;
mod screening;
mod search;
mod selection;
mod shift;
mod space;
mod spectral_peak;
mod stages;
mod steady_level;
mod thinned;
mod trace;
mod unseen;
mod verdict;
mod whittle;
mod wide;

pub use adequacy::Misfit;
pub use detectable::Detectable;
pub use diagnosis::{Candidate, Diagnosis, Finding, Lead, ParameterEstimate, Parts, RecordTerms, Verdict};
pub use evidence::{REQUIRED_BIC_LEAD, REQUIRED_HOLD_OUT_GAIN, RIVAL_BIC_RANGE};
pub use hold_out::{Division, divide};

use std::time::{Duration, Instant};

use crate::{
    progress::{Report, Work},
    signal::record::{Record, rms},
};
use actuator_fmu::{
    error::{Error, Result},
    parameters::Model,
};
use measured_noise::MeasuredNoise;
use selection::StructureSelection;
use stages::{CONCLUSION, stages};
use thinned::{MOST_SAMPLES_WHOLE, Thinning, thinned};

/// Finds what is missing in a model. Repeats of healthy motion (`reference`) tell the noise; a search that reaches its time limit ends with
/// the best so far, and says so.
///
/// # Errors
/// No records, records in different units or in another one than the model, a model that cannot move through them.
pub fn diagnose(
    given: &Model,
    fit: &[Record],
    check: &[Record],
    reference: &[Record],
    limit: Option<Duration>,
) -> Result<Diagnosis> {
    diagnose_reporting(given, fit, check, reference, limit, None)
}

/// The same, with word of how much of the search is done.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_reporting(
    given: &Model,
    fit: &[Record],
    check: &[Record],
    reference: &[Record],
    limit: Option<Duration>,
    report: Option<Report<'_>>,
) -> Result<Diagnosis> {
    let Some(first) = fit.first() else { return Err(Error::new("records", "none", "one or more")) };
    if let Some(other) = fit.iter().chain(check).find(|record| record.unit() != first.unit()) {
        let found = format!("{} and {}", first.unit(), other.unit());
        return Err(Error::new("units of the records", found, "one unit").at(other.source(), None));
    }
    if first.unit() != given.unit() {
        let found = format!("{} of a model in {}", first.unit(), given.unit());
        return Err(Error::new("unit of the records", found, "one unit").at(first.source(), None));
    }
    let noise = MeasuredNoise::of(&fit.iter().chain(check).collect::<Vec<&Record>>(), reference);
    let deadline = limit.map(|limit| Instant::now() + limit);
    let samples: usize = fit.iter().chain(check).map(Record::len).sum();
    let work = Work::new(stages(samples), report);
    let diagnosis = explained(StructureSelection::new(given, fit, check, noise, deadline, &work), fit, check);
    work.end();
    diagnosis
}

/// The search on all samples, or on a part of them where they are many.
fn explained(mut whole: StructureSelection<'_>, fit: &[Record], check: &[Record]) -> Result<Diagnosis> {
    let (given, work) = (whole.given, whole.work);
    let samples: usize = fit.iter().chain(check).map(Record::len).sum();
    if samples <= MOST_SAMPLES_WHOLE {
        whole.identify_quantiser();
        let outcome = whole.select().ok_or_else(diverging)?;
        // The noise ahead of the quantiser shows once the rest is explained.
        let best = outcome.explanation.as_ref().unwrap_or(&outcome.given).model.clone();
        let outcome =
            if whole.identify_quantiser_noise(&best) { whole.select().ok_or_else(diverging)? } else { outcome };
        return whole.diagnosis(&outcome);
    }
    let bandwidth_hz = given.base.omega() / std::f64::consts::TAU;
    let all: Vec<&Record> = fit.iter().chain(check).collect();
    let mut thinning = Thinning::FINE;
    loop {
        let mut thin_fit = thinned(&all, bandwidth_hz, thinning);
        let thin_check = thin_fit.split_off(fit.len());
        let (noise, deadline) = (whole.noise.clone(), whole.deadline);
        let mut part = StructureSelection::new(given, &thin_fit, &thin_check, noise, deadline, work);
        part.identify_quantiser();
        let outcome = part.select().ok_or_else(diverging)?;
        work.begin(CONCLUSION);
        whole.quantise_as(&part);
        let outcome = whole.transferred(outcome).ok_or_else(diverging)?;
        // Parts may lack what the whole shows.
        let is_last = thinning.most_samples >= MOST_SAMPLES_WHOLE.min(samples);
        if is_last || whole.holds(&outcome) || whole.is_over() {
            return whole.diagnosis(&outcome);
        }
        thinning.most_samples *= 4;
    }
}

fn diverging() -> Error {
    Error::new("model", "a motion without end through these records", "a stable actuator")
}

/// Root mean square of several columns together.
#[must_use]
pub fn pooled_rms(columns: &[Vec<f64>]) -> f64 {
    rms(&columns.iter().flatten().copied().collect::<Vec<f64>>())
}
