//! Healthy reference records: nothing has changed where the residual of the given model is as large a share of their motion.

use super::{plain_fit::PlainFit, selection::StructureSelection, trace::Trace};
use crate::signal::record::{rms, without_mean};
use actuator_fmu::parameters::Model;

/// Rms of the residual relative to the motion, over the same on the healthy records: nothing has changed within this factor.
const UNCHANGED: f64 = 1.3;

/// Sum of squares of a model's residual over that of the positions about their mean, on all records; none without records, or where the motion
/// diverges.
#[allow(clippy::cast_precision_loss)] // a count of samples
pub fn share_left<'a>(model: &Model, traces: impl Iterator<Item = Trace<'a>>) -> Option<f64> {
    let traces: Vec<Trace<'_>> = traces.collect();
    let as_it_is = PlainFit::as_it_is(model, &traces)?;
    let square = |values: &[f64]| values.len() as f64 * rms(values).powi(2);
    let left: f64 = as_it_is.residuals.iter().map(|residual| square(residual)).sum();
    let moved: f64 = traces.iter().map(|trace| square(&without_mean(trace.record.position()))).sum();
    (moved > 0.0).then(|| left / moved)
}

impl StructureSelection<'_> {
    /// Why nothing has changed: the residual of the given model is the same share of the motion on the healthy reference records. None otherwise.
    pub fn as_healthy(&self) -> Option<String> {
        let healthy = self.healthy_share?;
        let here = share_left(self.given, self.fit.iter().chain(&self.check).cloned())?;
        let is_unchanged = (here / healthy).ln().abs() < 2.0 * UNCHANGED.ln();
        is_unchanged.then(|| {
            let [here, healthy] = [here, healthy].map(|share| 100.0 * share.sqrt());
            format!(
                "the residual of the given model is {here:.1} % of the motion, and {healthy:.1} % on the healthy reference: what is missing has not changed"
            )
        })
    }
}
