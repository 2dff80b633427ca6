//! Where simulation and measured records disagree, what is missing in the model, and how sure that is.
//!
//! [`diagnose`] reads as the workflow does: the base is refitted, every effect of the chain is tried beside it, what wins has to
//! win on records that it was not fitted to, more effects are added one at a time and those that are not needed are taken back, and
//! what is left has to be noise. Adding an effect to noise is the worst answer of all; "none of these" is an answer.

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
mod quantiser;
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
pub use diagnosis::{Candidate, Diagnosis, Finding, OfRecord, ParameterEstimate, Verdict};
pub use evidence::{CHECK_GAIN, MARGIN, RIVAL};
pub use hold_out::{Division, divide};

use crate::signal::record::{Record, rms};
use actuator_fmu::{
    error::{Error, Result},
    parameters::{Base, Model},
};
use fitted::{Care, Fitted};
use hypothesis::Hypothesis;
use selection::Study;
use space::{SWIFT_POLE, Space, has_near_pole};
use trace::Trace;

/// Finds what is missing in a model.
///
/// # Errors
/// No records, records in different units, a model that cannot move through them.
pub fn diagnose(given: &Model, fit: &[Record], check: &[Record]) -> Result<Diagnosis> {
    let Some(first) = fit.first() else { return Err(Error::new("records", "none", "one or more")) };
    if let Some(other) = fit.iter().chain(check).find(|record| record.unit() != first.unit()) {
        let found = format!("{} and {}", first.unit(), other.unit());
        return Err(Error::new("units of the records", found, "one unit").at(other.source(), None));
    }
    let diagnosis = diagnose_with(given, fit, check)?;
    if diagnosis.verdict != Verdict::Unexplained {
        return Ok(diagnosis);
    }
    // A fit that does not know of an effect hides part of it in a lag.
    let Some(swift) = without_near_pole(given, fit) else { return Ok(diagnosis) };
    let second = diagnose_with(&swift, fit, check)?;
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
    let mut study = Study::new(given, fit, check);
    study.expect_rounding();
    let diagnosis = run(&study)?;
    // The noise ahead of the quantiser shows once the rest is explained.
    if study.expect_rounding_of(&diagnosis.best) { run(&study) } else { Ok(diagnosis) }
}

fn run(study: &Study<'_>) -> Result<Diagnosis> {
    let stuck = || Error::new("model", "a motion without end through these records", "a stable actuator");
    let outcome = study.explain().ok_or_else(stuck)?;
    let best = outcome.explanation.as_ref().unwrap_or(&outcome.given);
    let (checked, reference) = best.on(&study.check).zip(outcome.base.on(&study.check)).ok_or_else(stuck)?;
    study.in_words(&outcome, best, &checked, &reference)
}

/// Where the given pole is a lag that shows: the best model without that lag.
fn without_near_pole(given: &Model, fit: &[Record]) -> Option<Model> {
    // Half and twice of these hold all that actuators have.
    const DAMPING_RATIOS: [f64; 2] = [0.3, 0.7];
    let [k, _, omega, _] = given.base.values();
    if !has_near_pole(given) {
        return None;
    }
    let refitted = DAMPING_RATIOS.iter().filter_map(|zeta| {
        let start = Model { base: Base::from_values([k, SWIFT_POLE * omega, omega, *zeta]).ok()?, ..given.clone() };
        let traces: Vec<Trace<'_>> = fit.iter().map(|record| Trace::new(record, &start.base)).collect();
        let free = Hypothesis { base_free: true, ..Hypothesis::default() };
        Fitted::search(Space::new(free, &start, &start.base, 0.0), &traces, Care::Fine)
    });
    refitted.min_by(|a, b| a.bic.total_cmp(&b.bic)).map(|best| best.model)
}

/// Root mean square of several columns together.
#[must_use]
pub fn pooled_rms(columns: &[Vec<f64>]) -> f64 {
    rms(&columns.iter().flatten().copied().collect::<Vec<f64>>())
}
