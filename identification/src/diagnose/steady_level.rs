//! Whether a bias of the sensor is one: the same in all records. Levels that differ from record to record are those of a reference that was set anew.

use super::{fitted::Fitted, hypothesis::MeasurementTerm, trace::Trace};

/// Levels of three or four records differ when they scatter by more than so many of their standard errors, which chance does in one case of a
/// hundred,
const DIFFERENT_SIGMAS: f64 = 2.3;
/// and by more than this share of their mean.
const DIFFERENT_SHARE: f64 = 0.25;

/// Whether the bias that a hypothesis adds is the same in the records of some fits of it; true where it adds none.
#[allow(clippy::cast_precision_loss)] // counts of records and samples
pub fn is_steady(fits: &[(&Fitted, &[Trace<'_>])]) -> bool {
    let Some(place) = fits[0].0.space.terms().position(|term| term == MeasurementTerm::Bias) else { return true };
    let levels: Vec<[f64; 2]> = fits
        .iter()
        .flat_map(|(fitted, traces)| fitted.factors.iter().zip(&fitted.noise).zip(*traces))
        .map(|((factors, noise), trace)| {
            // At the middle, where offset and drift are known best together.
            let level = factors[2 * place] + factors[2 * place + 1] * 0.5 * trace.record.duration_s();
            // Of an autoregression the mean has the variance of its density at frequency 0.
            let response = (1.0 - noise.coefficients.iter().sum::<f64>()).abs().max(f64::MIN_POSITIVE);
            [level, noise.innovation_rms / response / (trace.evaluated_samples() as f64).sqrt()]
        })
        .collect();
    let count = levels.len() as f64;
    let mean = levels.iter().map(|[level, _]| level).sum::<f64>() / count;
    let scatter = (levels.iter().map(|[level, _]| (level - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0)).sqrt();
    let error = (levels.iter().map(|[_, error]| error * error).sum::<f64>() / count).sqrt();
    scatter < DIFFERENT_SIGMAS * error || scatter < DIFFERENT_SHARE * mean.abs()
}
