//! Diagnosis: where simulation and records disagree, which effect the model lacks, and with what evidence.
//!
//! [`diagnose`] is a selection of model structure by forward selection and backward elimination: the base is refitted, every effect of
//! the chain is screened and fitted beside it, an effect must be significant on fitted and on hold-out records, and the residual must be
//! noise in the end. A false alarm is the worst answer of all; "none of these" is an answer.

mod adequacy;
mod candidates;
mod conclusion;
mod diagnosis;
mod evidence;
mod fitted;
mod hold_out;
mod hypothesis;
pub mod location;
pub mod next_test;
mod output_error;
mod quantisation;
pub mod quantiser;
pub mod regressors;
mod screening;
mod search;
mod selection;
mod space;
mod spectral_peak;
mod trace;
mod verdict;
mod whittle;

pub use adequacy::Misfit;
pub use diagnosis::{Candidate, Diagnosis, Finding, ParameterEstimate, RecordTerms, Verdict};
pub use evidence::{REQUIRED_BIC_LEAD, REQUIRED_HOLD_OUT_GAIN, RIVAL_BIC_RANGE};
pub use hold_out::{Division, divide};

use crate::signal::record::{Record, rms};
use actuator_fmu::{
    error::{Error, Result},
    parameters::{Base, Model},
};
use fitted::{Fitted, SearchEffort};
use hypothesis::Hypothesis;
use selection::StructureSelection;
use space::{FAST_POLE_RATIO, Space, has_slow_pole};
use trace::Trace;

/// Finds what is missing in a model.
///
/// # Errors
/// No records, records in different units or in another one than the model, a model that cannot move through them.
pub fn diagnose(given: &Model, fit: &[Record], check: &[Record]) -> Result<Diagnosis> {
    let Some(first) = fit.first() else { return Err(Error::new("records", "none", "one or more")) };
    if let Some(other) = fit.iter().chain(check).find(|record| record.unit() != first.unit()) {
        let found = format!("{} and {}", first.unit(), other.unit());
        return Err(Error::new("units of the records", found, "one unit").at(other.source(), None));
    }
    if first.unit() != given.unit() {
        let found = format!("{} of a model in {}", first.unit(), given.unit());
        return Err(Error::new("unit of the records", found, "one unit").at(first.source(), None));
    }
    let diagnosis = diagnose_with(given, fit, check)?;
    if diagnosis.verdict != Verdict::Unexplained {
        return Ok(diagnosis);
    }
    // A fit without a missing effect may put part of it into a lag.
    let Some(without_lag) = without_slow_pole(given, fit) else { return Ok(diagnosis) };
    let second = diagnose_with(&without_lag, fit, check)?;
    if !matches!(second.verdict, Verdict::Named | Verdict::Ambiguous) {
        return Ok(diagnosis);
    }
    let mut notes = second.notes;
    notes.push(format!(
        "the given p of {:.0} 1/s was taken for a part of what is missing; the base is without it, its k, omega and zeta fitted anew",
        given.base.p()
    ));
    Ok(Diagnosis { before: given.clone(), notes, ..second })
}

/// The whole workflow, from one given model.
fn diagnose_with(given: &Model, fit: &[Record], check: &[Record]) -> Result<Diagnosis> {
    let mut selection = StructureSelection::new(given, fit, check);
    selection.identify_quantiser();
    let diagnosis = run(&selection)?;
    // The noise ahead of the quantiser shows once the rest is explained.
    if selection.identify_quantiser_noise(&diagnosis.best) { run(&selection) } else { Ok(diagnosis) }
}

/// Search and conclusion.
fn run(selection: &StructureSelection<'_>) -> Result<Diagnosis> {
    let diverging = || Error::new("model", "a motion without end through these records", "a stable actuator");
    let outcome = selection.select().ok_or_else(diverging)?;
    let best = outcome.explanation.as_ref().unwrap_or(&outcome.given);
    let (checked, reference) =
        best.on(&selection.check).zip(outcome.base.on(&selection.check)).ok_or_else(diverging)?;
    selection.conclude(&outcome, best, &checked, &reference)
}

/// Where the given pole is a slow one: the best model without its lag.
fn without_slow_pole(given: &Model, fit: &[Record]) -> Option<Model> {
    // Half to twice of these are the damping ratios of all actuators.
    const DAMPING_RATIOS: [f64; 2] = [0.3, 0.7];
    let [k, _, omega, _] = given.base.values();
    if !has_slow_pole(given) {
        return None;
    }
    let refitted = DAMPING_RATIOS.iter().filter_map(|zeta| {
        let start =
            Model { base: Base::from_values([k, FAST_POLE_RATIO * omega, omega, *zeta]).ok()?, ..given.clone() };
        let traces: Vec<Trace<'_>> = fit.iter().map(|record| Trace::new(record, &start.base)).collect();
        let free = Hypothesis { base_free: true, ..Hypothesis::default() };
        Fitted::search(Space::new(free, &start, &start.base, 0.0), &traces, SearchEffort::Full)
    });
    refitted.min_by(|a, b| a.bic.total_cmp(&b.bic)).map(|best| best.model)
}

/// Root mean square of several columns together.
#[must_use]
pub fn pooled_rms(columns: &[Vec<f64>]) -> f64 {
    rms(&columns.iter().flatten().copied().collect::<Vec<f64>>())
}
