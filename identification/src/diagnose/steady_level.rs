//! Whether a bias of the sensor is the same in all records. Levels that differ between records are those of a reference that was set anew.

use super::{fitted::Fitted, hypothesis::MeasurementTerm, trace::Trace};
use crate::signal::record::{rms, without_mean};

/// Scatter of the levels of three or four records over their standard error, above which they differ: by chance in one case of a hundred.
const DIFFERENT_SIGMAS: f64 = 2.3;
/// Scatter over what the levels have in common, which must be exceeded as well.
const DIFFERENT_SHARE: f64 = 0.25;

/// The bias of one record: an offset [deg] at its start and a drift [deg/s].
struct RecordBias {
    offset: f64,
    drift: f64,
    duration_s: f64,
    samples: f64,
    /// Standard error of its level at the middle of the record, where offset and drift together are known best [deg].
    error: f64,
}

/// Whether the bias that a hypothesis adds, an offset and a drift, is the same in the records of several fits; true where it adds none.
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn is_steady(fits: &[(&Fitted, &[Trace<'_>])]) -> bool {
    let Some(place) = fits[0].0.space.terms().position(|term| term == MeasurementTerm::Bias) else { return true };
    let biases: Vec<RecordBias> = fits
        .iter()
        .flat_map(|(fitted, traces)| fitted.factors.iter().zip(&fitted.noise).zip(*traces))
        .map(|((factors, noise), trace)| {
            let samples = trace.evaluated_samples() as f64;
            // The mean of an autoregression has the variance of its density at frequency 0.
            let response = (1.0 - noise.coefficients.iter().sum::<f64>()).abs().max(f64::MIN_POSITIVE);
            RecordBias {
                offset: factors[2 * place],
                drift: factors[2 * place + 1],
                duration_s: trace.record.duration_s(),
                samples,
                error: noise.innovation_rms / response / samples.sqrt(),
            }
        })
        .collect();
    is_common(&biases)
}

/// Whether biases are the same: with one drift, from the start of each record on, their levels at the middle of the records give one offset.
#[allow(clippy::cast_precision_loss)] // counts of records
fn is_common(biases: &[RecordBias]) -> bool {
    let count = biases.len() as f64;
    let sum = |of: &dyn Fn(&RecordBias) -> f64| biases.iter().map(of).sum::<f64>();
    // The variance of a drift falls with the samples and with the square of the duration.
    let weight = |bias: &RecordBias| bias.samples * bias.duration_s.powi(2);
    let drift = sum(&|bias| weight(bias) * bias.drift) / sum(&weight).max(f64::MIN_POSITIVE);
    let by_drift = |bias: &RecordBias| 0.5 * drift * bias.duration_s;
    let rest = |bias: &RecordBias| bias.offset + 0.5 * bias.drift * bias.duration_s - by_drift(bias);
    let offset = sum(&rest) / count;
    let scatter = (sum(&|bias| (rest(bias) - offset).powi(2)) / (count - 1.0).max(1.0)).sqrt();
    let error = (sum(&|bias| bias.error.powi(2)) / count).sqrt();
    let common = (sum(&|bias| (offset + by_drift(bias)).powi(2)) / count).sqrt();
    scatter < DIFFERENT_SIGMAS * error || scatter < DIFFERENT_SHARE * common
}

/// Size of the level of a residual, and its root mean square about it.
#[allow(clippy::cast_precision_loss)] // a count of samples
pub fn level_and_deviation(residual: &[f64]) -> [f64; 2] {
    let level = residual.iter().sum::<f64>() / residual.len().max(1) as f64;
    [level.abs(), rms(&without_mean(residual))]
}

#[cfg(test)]
mod tests {
    use super::{RecordBias, is_common};

    fn bias(offset: f64, drift: f64, duration_s: f64) -> RecordBias {
        RecordBias { offset, drift, duration_s, samples: 200.0 * duration_s, error: 1e-3 }
    }

    #[test]
    fn a_drift_that_begins_anew_with_each_record_is_one_whatever_their_durations() {
        assert!(is_common(&[bias(0.0, -0.01, 25.0), bias(0.0, -0.01, 10.0), bias(0.0, -0.01, 5.0)]));
        assert!(is_common(&[bias(0.1, 0.0, 25.0), bias(0.1, 0.0, 10.0), bias(0.1, 0.0, 5.0)]));
    }

    #[test]
    fn levels_that_are_set_anew_are_none() {
        assert!(!is_common(&[bias(0.1, 0.0, 25.0), bias(-0.05, 0.0, 25.0), bias(0.02, 0.0, 25.0)]));
        // Differences within their errors are not significant.
        assert!(is_common(&[bias(1e-3, 0.0, 25.0), bias(-1e-3, 0.0, 25.0), bias(0.0, 0.0, 25.0)]));
    }
}
