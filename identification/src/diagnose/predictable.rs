//! The part of a residual that the motion predicts on unused samples: the size of a misfit, whatever its cause.
//!
//! Noise cannot be predicted, whatever its colour; slow errors of a model can. The residual is regressed on functions of the simulated motion
//! ([`super::regressors`]) and on a linear model of the command, and scored across records and on alternating parts within records:
//!
//! ```text
//! share = 1 - (out-of-sample sum of squares) / (sum of squares),    the larger of the two
//! ```

use super::{
    folds::Folds,
    regressors::{Scales, regressors},
    trace::{Motion, Trace},
};
use crate::{inspect::laguerre, parallel};
use actuator_fmu::parameters::Model;

/// Predictable share of a residual below which it is noise.
pub const NOISE_SHARE: f64 = 0.02;

/// Predictable share of a residual below which an explanation may be named.
pub const ADEQUATE_SHARE: f64 = 0.08;

/// Rms of a residual over the largest one of a record's positions below which it is no misfit.
const NEGLIGIBLE_SHARE: f64 = 1e-4;

/// Predictable shares of a residual.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Predictable {
    /// By the functions of the motion and the linear model together.
    pub share: f64,
    /// By the linear model of the command alone.
    pub linear_share: f64,
    /// Root mean square of the residual.
    pub rms: f64,
}

/// Predictable shares of the residual of a model on some records.
pub fn predictable(model: &Model, residuals: &[Vec<f64>], traces: &[Trace<'_>]) -> Predictable {
    let motions: Option<Vec<Motion>> = parallel::map(traces, |trace| trace.motion(model)).into_iter().collect();
    let Some(motions) = motions else { return Predictable::default() };
    let scales = Scales::of(&motions);
    let linear = parallel::map(traces, |trace| linear_columns(trace, 1.0 / model.base.omega()));
    // All records have the same columns; the load of a record without one is zero.
    let is_loaded = traces.iter().any(|trace| trace.record.load().is_some());
    let no_load = |trace: &Trace<'_>| {
        let is_missing = is_loaded && trace.record.load().is_none();
        is_missing.then(|| vec![0.0; trace.record.len() - trace.settling])
    };
    let all: Vec<Vec<Vec<f64>>> = parallel::indexed(traces.len(), |index| {
        let (trace, linear) = (&traces[index], &linear[index]);
        let of_motion = regressors(trace, &motions[index], scales).into_iter();
        // Levels are removed from each record; a steady drift is no function of the motion.
        let of_motion = of_motion.filter(|regressor| !matches!(regressor.name, "constant" | "time" | "command"));
        of_motion.map(|regressor| regressor.values).chain(no_load(trace)).chain(linear.iter().cloned()).collect()
    });
    let (all, linear) = rayon::join(|| Folds::new(&all, residuals), || Folds::new(&linear, residuals));
    let square: f64 = all.squares().iter().sum();
    let count: usize = residuals.iter().map(Vec::len).sum();
    #[allow(clippy::cast_precision_loss)] // a count of samples
    let rms = (square / count.max(1) as f64).sqrt();
    // Without noise the residual is rounding and the tolerance of the search.
    let moved = traces.iter().map(|trace| crate::signal::record::rms(trace.record.position())).fold(0.0, f64::max);
    if rms < NEGLIGIBLE_SHARE * moved {
        return Predictable { rms, ..Predictable::default() };
    }
    Predictable { share: share(&all), linear_share: share(&linear), rms }
}

/// The larger of the shares across and within records.
fn share(folds: &Folds) -> f64 {
    let square: f64 = folds.squares().iter().sum();
    let of = |left: Vec<f64>| 1.0 - left.iter().sum::<f64>() / square.max(f64::MIN_POSITIVE);
    of(folds.left_across_records()).max(of(folds.left_within_records())).max(0.0)
}

/// The command and its Laguerre filters of one time constant [s], over the evaluated samples.
pub fn linear_columns(trace: &Trace<'_>, time_constant_s: f64) -> Vec<Vec<f64>> {
    linear_columns_of(trace.record.command(), trace, time_constant_s)
}

/// The same for another signal of a record than its command.
pub fn linear_columns_of(signal: &[f64], trace: &Trace<'_>, time_constant_s: f64) -> Vec<Vec<f64>> {
    let alpha = (-trace.record.sampling().interval_s() / time_constant_s).exp();
    // Scaled to a response of 1 to a constant, whatever the sampling.
    let constant = (1.0 - alpha * alpha).sqrt() / (1.0 - alpha);
    let columns = laguerre::columns(signal, alpha).into_iter().skip(1).enumerate();
    columns
        .map(|(place, column)| {
            let scale = if place == 0 { 1.0 } else { 1.0 / constant };
            column[trace.settling..].iter().map(|value| scale * value).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::three_records::three_records;
    use actuator_fmu::parameters::{Model, table};

    #[test]
    fn records_of_which_one_alone_holds_a_load_are_compared_all_the_same() {
        let given = Model::from_set(&table()[0]);
        let mut records = three_records(&given, 3.0);
        let loaded = records.remove(1);
        let load = loaded.command().iter().map(|value| value * value).collect();
        records.push(loaded.with_load(Some(load)));
        let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &given.base)).collect();
        let residuals: Vec<Vec<f64>> = traces
            .iter()
            .map(|trace| trace.record.load().unwrap_or(trace.record.command())[trace.settling..].to_vec())
            .collect();
        // The motion predicts both residuals: the command, and its square.
        assert!(predictable(&given, &residuals, &traces).share > 0.99);
    }
}
