//! Diagnosis: where simulation and records disagree, which effect the model lacks, and with what evidence.
//!
//! [`diagnose`] is a selection of model structure by forward selection and backward elimination: the base is refitted, every effect of the chain is
//! screened and fitted beside it, an effect must be significant on fit and on check records, and the residual must be noise in the end. A false alarm
//! is the worst result; that no effect explains the difference is a valid one.

mod adequacy;
mod adequate;
mod as_likely;
mod brief_limit;
mod candidates;
mod changed;
mod check_only;
mod common_level;
mod conclusion;
mod contacts;
mod coordinate;
mod coordinates;
mod delay_response;
mod derivatives;
mod detectable;
mod diagnosis;
mod evidence;
mod far_from_given;
mod fitted;
mod folds;
mod given_effects;
mod healthy;
mod held;
mod hold_out;
mod hum_of_command;
mod hypothesis;
mod idle_sides;
mod jacobian;
mod judgement;
mod late;
mod lead;
mod lead_forms;
mod leading_combination;
mod leading_lag;
mod leading_mode;
mod leading_oscillation;
mod leading_stop;
mod leave_one_out;
mod level_at_start;
mod linear_rival;
mod located;
pub mod location;
mod location_over_frequency;
mod measured_noise;
pub mod next_test;
mod notes;
mod outcome;
mod output_error;
mod past_stop;
mod plain_fit;
mod plausibility;
mod predictable;
mod quantisation;
pub mod quantiser;
mod record_apart;
pub mod regressors;
mod remembered;
mod rivals;
mod screening;
mod search;
mod selection;
mod sensitivities;
mod shift;
mod shown_alone;
mod similarity;
mod space;
mod spectral_peak;
mod stages;
mod steady_level;
mod steady_rate;
mod term_errors;
mod thinned;
#[cfg(test)]
mod three_records;
mod trace;
mod transferred;
mod unseen;
mod verdict;
mod whittle;
mod wide;

pub use adequacy::Misfit;
pub use detectable::Detectable;
pub use diagnosis::{Candidate, Diagnosis, Finding, Lead, ParameterEstimate, Parts, RecordTerms, Verdict};
pub use evidence::{REQUIRED_BIC_LEAD, REQUIRED_HOLD_OUT_GAIN, RIVAL_BIC_RANGE};
pub use hold_out::{Division, divide};
pub use trace::ROUNDING;

use std::time::{Duration, Instant};

use crate::{
    progress::{Report, Work},
    signal::record::{Record, rms, without_mean},
};
use actuator_fmu::{
    error::{Error, Result},
    parameters::{Base, Model, Order},
};
use healthy::share_left;
use measured_noise::MeasuredNoise;
use outcome::Outcome;
use selection::{Extent, StructureSelection};
use stages::{CONCLUSION, stages};
use thinned::{MOST_SAMPLES_WHOLE, Thinning, is_stretch, thinned};
use trace::Trace;

/// Finds what is missing in a model. Repeats of healthy motion (`reference`) give the noise and the residual of the given model on a healthy
/// actuator. A search that reaches its time limit ends with the best result so far, and the result says so.
///
/// # Errors
/// No records; records in different units or in another unit than the model; a model whose motion diverges on them.
pub fn diagnose(
    given: &Model,
    fit: &[Record],
    check: &[Record],
    reference: &[Record],
    limit: Option<Duration>,
) -> Result<Diagnosis> {
    diagnose_reporting(given, fit, check, reference, limit, None)
}

/// The same, reporting the completed share of the search.
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
    let searched = with_fastest_pole_first(given, first).unwrap_or_else(|| given.clone());
    let noise = MeasuredNoise::of(&fit.iter().chain(check).collect::<Vec<&Record>>(), reference);
    let deadline = limit.map(|limit| Instant::now() + limit);
    let samples: usize = fit.iter().chain(check).map(Record::len).sum();
    let work = Work::new(stages(samples), report);
    let mut selection = StructureSelection::new(&searched, fit, check, noise, deadline, &work);
    selection.healthy_share = share_left(&searched, reference.iter().map(|record| Trace::new(record, &searched.base)));
    let diagnosis = explained(selection, fit, check);
    work.end();
    diagnosis.map(|diagnosis| diagnosis.of_given(&searched, given))
}

/// The same linear actuator with the fastest of three real poles as p: the motion of a single pole is known at any step size, whereas a pair with a
/// fast pole takes many steps in each interval. None unless the pair is overdamped and its fast pole is faster than p and than the sampling, and none
/// where an effect other than a delay acts.
fn with_fastest_pole_first(given: &Model, record: &Record) -> Option<Model> {
    // Time constants of the fast pole in a sampling interval above which it is worth it.
    const TIME_CONSTANTS: f64 = 4.0;
    let [k, p, omega, zeta] = given.base.values();
    let slow = given.base.pair_decay();
    let fast = omega * omega / slow;
    let is_stiff = zeta > 1.0 && fast > p && fast * record.sampling().interval_s() > TIME_CONSTANTS;
    let is_linear = given.effects.active().all(|(effect, _)| effect.name == "delay");
    if given.order != Order::Third || !is_stiff || !is_linear {
        return None;
    }
    let omega = (slow * p).sqrt();
    let base = Base::from_values([k, fast, omega, 0.5 * (slow + p) / omega]).ok()?;
    Some(Model { base, ..given.clone() })
}

/// Searches on all samples, or on a part of them where there are more than `MOST_SAMPLES_WHOLE`.
fn explained(mut whole: StructureSelection<'_>, fit: &[Record], check: &[Record]) -> Result<Diagnosis> {
    let samples: usize = fit.iter().chain(check).map(Record::len).sum();
    if samples <= MOST_SAMPLES_WHOLE {
        whole.identify_quantiser();
        let outcome = whole.select().ok_or_else(diverging)?;
        // The noise ahead of the quantiser can be measured once the rest is explained.
        let best = outcome.explanation.as_ref().unwrap_or(&outcome.given).model.clone();
        let outcome =
            if whole.identify_quantiser_noise(&best) { whole.select().ok_or_else(diverging)? } else { outcome };
        return whole.diagnosis(&outcome);
    }
    let mut thinning = Thinning::FINE;
    let (first, has_stretches) = loop {
        let OfParts { outcome, has_stretches, leaves_more } = on_parts(&mut whole, fit, check, thinning, Extent::All)?;
        // Parts may not show what the whole records show.
        let is_last = thinning.most_samples >= MOST_SAMPLES_WHOLE.min(samples);
        if is_last || (whole.holds(&outcome) && !leaves_more) || whole.is_over() {
            break (outcome, has_stretches);
        }
        thinning.most_samples *= 4;
    };
    let first = if has_stretches { whole.with_bias(first) } else { first };
    let is_explained = !first.is_unexplained() && !first.is_delay_or_base();
    if is_explained || !has_stretches || whole.is_over() {
        return whole.diagnosis(&whole.with_stop(first));
    }
    // Stretches may not reach a limit, or may show another lag or base than the whole records.
    let quantiser = whole.quantiser();
    let OfParts { outcome: second, .. } = on_parts(&mut whole, fit, check, Thinning::WHOLE, Extent::Singles)?;
    if !second.is_unexplained() {
        return whole.diagnosis(&second);
    }
    whole.quantise(quantiser);
    whole.diagnosis(&whole.with_stop(Outcome { was_cut: second.was_cut, ..first }))
}

/// What thinned records gave.
struct OfParts {
    /// Refined on the whole records.
    outcome: Outcome,
    /// Whether any thinned record is a stretch.
    has_stretches: bool,
    /// Whether an adequate explanation leaves far more of a whole record than of its stretch.
    leaves_more: bool,
}

/// Searches on thinned records and refines the result on the whole ones.
fn on_parts(
    whole: &mut StructureSelection<'_>,
    fit: &[Record],
    check: &[Record],
    thinning: Thinning,
    extent: Extent,
) -> Result<OfParts> {
    let all: Vec<&Record> = fit.iter().chain(check).collect();
    let mut thin_fit = thinned(&all, whole.given.base.omega() / std::f64::consts::TAU, thinning);
    let has_stretches = thin_fit.iter().zip(&all).any(|(thin, record)| is_stretch(thin, record));
    let thin_check = thin_fit.split_off(fit.len());
    let (noise, deadline) = (whole.noise.clone(), whole.deadline);
    let mut part = StructureSelection::new(whole.given, &thin_fit, &thin_check, noise, deadline, whole.work);
    part.extent = extent;
    part.healthy_share = whole.healthy_share;
    part.identify_quantiser();
    let outcome = part.select().ok_or_else(diverging)?;
    whole.work.begin(CONCLUSION);
    whole.quantise(part.quantiser());
    let of_parts = outcome.last().residuals.clone();
    let outcome = whole.transferred(outcome).ok_or_else(diverging)?;
    let leaves_more = has_stretches && outcome.is_adequate_and_leaves_more_than(&of_parts);
    Ok(OfParts { outcome, has_stretches, leaves_more })
}

fn diverging() -> Error {
    Error::new("model", "a diverging motion on these records", "a stable actuator")
}

/// Root mean square of the residual of a model over all records together, about the levels and after the settling time; none where the motion
/// diverges.
#[must_use]
pub fn rms_left(model: &Model, records: &[Record]) -> Option<f64> {
    let left = |record: &Record| {
        let trace = Trace::new(record, &model.base);
        let simulated = trace.position(model)?;
        let pairs = record.position().iter().zip(simulated).skip(trace.settling);
        let left = trace.where_measured(pairs.map(|(measured, simulated)| measured - simulated).collect());
        Some(without_mean(&left))
    };
    let each: Option<Vec<Vec<f64>>> = records.iter().map(left).collect();
    each.map(|each| pooled_rms(&each))
}

/// Root mean square of several columns together.
#[must_use]
pub fn pooled_rms(columns: &[Vec<f64>]) -> f64 {
    rms(&columns.iter().flatten().copied().collect::<Vec<f64>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::{Command, Interpolation};
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{PositionUnit, table},
    };

    /// |H| at s = jω, squared.
    fn gain(model: &Model, w: f64) -> f64 {
        let [k, p, omega, zeta] = model.base.values();
        let first = p * p / (p * p + w * w);
        k * k * first * omega.powi(4) / ((omega * omega - w * w).powi(2) + (2.0 * zeta * omega * w).powi(2))
    }

    #[test]
    fn a_model_with_a_fast_pole_in_its_pair_is_searched_from_as_the_same_with_that_pole_alone() {
        let time: Vec<f64> = (0..400).map(|n| f64::from(n) / 100.0).collect();
        let command = Command { time: time.clone(), command: time.iter().map(|t| t.sin()).collect() };
        let record = Record::new(command, time, PositionUnit::default(), Interpolation::Held, "sine").unwrap();
        let with =
            |values: [f64; 4]| Model { base: Base::from_values(values).unwrap(), ..Model::from_set(&table()[0]) };
        let given = with([1.1, 60.0, 700.0, 8.0]);
        let form = with_fastest_pole_first(&given, &record).unwrap();
        for w in [0.1, 10.0, 50.0, 300.0, 2e4] {
            assert!((gain(&form, w) / gain(&given, w) - 1.0).abs() < 1e-9, "{w}");
        }
        assert!(form.base.p() > 1e4 && form.base.omega() * form.base.zeta() < 100.0);
        // Nothing to gain, and an effect between the poles.
        assert!(with_fastest_pole_first(&with([1.1, 60.0, 70.0, 0.8]), &record).is_none());
        let effects = Effects::default().with(find("rate_limit").unwrap(), &[50.0, 50.0]).unwrap();
        assert!(with_fastest_pole_first(&Model { effects, ..given }, &record).is_none());
    }
}
