//! Whether an explanation is adequate: its residual is noise and its parameters are plausible for such an actuator.

use super::{
    fitted::Fitted,
    hypothesis::MeasurementTerm,
    late,
    predictable::{ADEQUATE_SHARE, NOISE_SHARE, Predictable, predictable},
    selection::StructureSelection,
    steady_level::is_steady,
    trace::Trace,
};

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
