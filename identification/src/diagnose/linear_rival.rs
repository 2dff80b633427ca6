//! The flexible linear rival: how much of the records any linear system would explain on samples that it was not fitted to.
//!
//! A nonlinear name must beat it: where it does not, the base has another structure, and no effect is missing.

use rayon::prelude::*;

use super::{folds::Folds, predictable::linear_columns, trace::Trace};

/// Time constants of the Laguerre filters, as multiples of 1/ω.
const TIME_CONSTANTS: [f64; 4] = [0.3, 1.0, 3.0, 10.0];

/// Mean square of what the best flexible linear model leaves of each record, fitted to the others and to alternating parts.
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn left_by_linear(traces: &[Trace<'_>], omega: f64) -> Vec<f64> {
    let targets: Vec<Vec<f64>> =
        traces.iter().map(|trace| trace.record.position()[trace.settling..].to_vec()).collect();
    let each: Vec<Vec<f64>> = TIME_CONSTANTS
        .par_iter()
        .map(|multiple| {
            let columns: Vec<Vec<Vec<f64>>> =
                traces.iter().map(|trace| linear_columns(trace, multiple / omega)).collect();
            let folds = Folds::new(&columns, &targets);
            // One record may hold what no other does.
            let across = folds.left_across_records();
            across.into_iter().zip(folds.left_within_records()).map(|(across, within)| across.min(within)).collect()
        })
        .collect();
    let best = each.into_iter().min_by(|a, b| a.iter().sum::<f64>().total_cmp(&b.iter().sum()));
    let counts = targets.iter().map(|target| target.len().max(1) as f64);
    best.unwrap_or_default().into_iter().zip(counts).map(|(left, count)| left / count).collect()
}
