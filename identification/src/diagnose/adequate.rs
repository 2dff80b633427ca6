//! Whether an explanation is adequate: its residual is noise and its parameters are plausible for such an actuator.

use super::{
    evidence::{RIVAL_BIC_RANGE, pooled_deviation},
    fitted::Fitted,
    hypothesis::MeasurementTerm,
    late,
    notes::coloured,
    predictable::{ADEQUATE_SHARE, NOISE_SHARE, Predictable, predictable},
    selection::StructureSelection,
    steady_level::is_steady,
    trace::Trace,
};
use crate::inspect::deviation;

/// Deviation of the residual of one record over that of another, at least, for a rest that changes slowly not to be noise of the sensor.
const UNEVEN: f64 = 1.5;
/// Mean square beside an effect over that of the given model, about the levels, above which the effect explains the smaller part.
const SMALLER_PART: f64 = 0.5;

impl StructureSelection<'_> {
    /// Whether an explanation, or the base where there is none, is adequate.
    pub fn is_adequate(&self, explanation: Option<&Fitted>, base: &Fitted) -> bool {
        let current = explanation.unwrap_or(base);
        let most = if explanation.is_some() { ADEQUATE_SHARE } else { NOISE_SHARE };
        !current.space.is_base_at_bound(&current.x)
            && current.space.is_plausible(&current.model)
            && self.misfit(current).is_some_and(|misfit| misfit.is_noise())
            && self.predictable(current).is_some_and(|predictable| predictable.share < most)
            && self.bias_is_steady(current)
            && !self.is_lag_of_structure(current)
    }

    /// A delay or lag that is adequate and about as likely as a shifted base which is not: whitening may hide a difference that functions of the motion
    /// show. None for an explanation with effects.
    pub fn lag_instead_of_base(&self, found: &Fitted, base: &Fitted, candidates: &[Fitted]) -> Option<Fitted> {
        let is_as_likely = |other: &&Fitted| {
            other.space.hypothesis.lag().is_some_and(|lag| other.space.hypothesis.effects == [lag.name])
                && other.bic < found.bic + RIVAL_BIC_RANGE
                && self.is_significant(other, base)
                && self.is_adequate(Some(other), base)
        };
        let likely = candidates.iter().filter(|_| found.space.hypothesis.effects.is_empty()).filter(is_as_likely);
        likely.min_by(|a, b| a.bic.total_cmp(&b.bic)).cloned()
    }

    /// Whether effects explain the smaller part of the difference, and the rest changes slowly and differs between records. Noise of a sensor does not
    /// depend on the record: it is a disturbance, or what the motion causes and no function of it shows.
    pub fn leaves_uneven_slow_rest(&self, found: &Fitted, given: &Fitted) -> bool {
        let left = pooled_deviation(&found.residuals) / pooled_deviation(&given.residuals);
        if found.space.hypothesis.effects.is_empty() || left * left < SMALLER_PART || coloured(found).is_none() {
            return false;
        }
        let Some(there) = found.on(&self.check) else { return false };
        let each = found.residuals.iter().chain(&there.residuals).map(|residual| deviation(residual));
        let (least, greatest) =
            each.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), one| (low.min(one), high.max(one)));
        greatest > UNEVEN * least
    }

    /// Whether a delay or lag is due to the structure of the model: its third-order base is far from the given one, as when fitted to an actuator of
    /// higher order.
    fn is_lag_of_structure(&self, fitted: &Fitted) -> bool {
        let lag = fitted.space.hypothesis.lag();
        lag.is_some_and(|lag| late::is_of_structure(lag, &fitted.model, self.given))
    }

    /// Whether a bias of the sensor, if there is one, is the same in the fit and in the check records.
    fn bias_is_steady(&self, fitted: &Fitted) -> bool {
        let has_bias = fitted.space.terms().any(|term| term == MeasurementTerm::Bias);
        !has_bias
            || fitted.on(&self.check).is_some_and(|there| is_steady(&[(fitted, &self.fit), (&there, &self.check)]))
    }

    /// The part of a residual that the motion predicts, over all records.
    pub fn predictable(&self, fitted: &Fitted) -> Option<Predictable> {
        self.predictables.of(fitted, || self.find_predictable(fitted))
    }

    fn find_predictable(&self, fitted: &Fitted) -> Option<Predictable> {
        let there = fitted.on(&self.check)?;
        let traces: Vec<Trace<'_>> = self.fit.iter().chain(&self.check).cloned().collect();
        let residuals: Vec<Vec<f64>> = fitted.residuals.iter().chain(&there.residuals).cloned().collect();
        Some(predictable(&fitted.model, &residuals, &traces))
    }

    /// The same on the fit records alone.
    pub fn predictable_when_fitted(&self, fitted: &Fitted) -> Predictable {
        predictable(&fitted.model, &fitted.residuals, &self.fit)
    }
}
