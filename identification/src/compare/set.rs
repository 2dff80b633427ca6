//! The compared items: a model, its label, and its test condition.

use nalgebra::Complex;
use serde::{Serialize, Serializer, ser::SerializeStruct};

use super::condition::Condition;
use crate::frequency::DelayedModel;
use actuator_fmu::parameters::{Base, Model};

/// A model and its label; its condition if known.
#[derive(Debug, Clone, PartialEq)]
pub struct Set {
    /// Set name or file.
    pub label: String,
    /// Surface, stage and load case.
    pub condition: Option<Condition>,
    /// The dynamics.
    pub model: Model,
    /// Delay between command and actuator \[s\].
    pub delay_s: f64,
    /// Covariance of ln |k|, ln ω, ln ζ, the lag 1/p \[s\] and the delay \[s\], if estimated.
    pub covariance: Option<[[f64; 5]; 5]>,
}

impl Set {
    /// A model with unknown condition and covariance.
    #[must_use]
    pub fn new(label: impl Into<String>, model: Model) -> Self {
        Self { label: label.into(), condition: None, model, delay_s: 0.0, covariance: None }
    }

    /// A model file: the delay is that of the model.
    #[must_use]
    pub fn of_model(label: impl Into<String>, model: Model) -> Self {
        let delay_s = model.effects.active_values_of("delay").map_or(0.0, |values| values[0]);
        Self { delay_s, ..Self::new(label, model) }
    }

    /// Its response at a frequency \[Hz\], with the delay and the linear effects of the model:
    ///
    /// ```text
    /// stiffness  ω² → ω² (1 + s) in the denominator    sensor_lag  1 / (1 + time s)
    /// structural_mode  1 - gain + gain ω_m² / (s² + 2 damping ω_m s + ω_m²)
    /// ```
    #[must_use]
    pub fn response(&self, frequency_hz: f64) -> Complex<f64> {
        let Self { model, delay_s, .. } = self;
        let effect = |name| model.effects.active_values_of(name);
        let s = Complex::new(0.0, std::f64::consts::TAU * frequency_hz);
        let mut response =
            DelayedModel { base: model.base, order: model.order, delay_s: *delay_s }.response(frequency_hz);
        if let Some(&[stiffness, _]) = effect("hinge_load") {
            let ratio = s / model.base.omega();
            let without = ratio * (ratio + 2.0 * model.base.zeta()) + 1.0;
            response *= without / (without + stiffness);
        }
        if let Some(&[time]) = effect("sensor_lag") {
            response /= s * time + 1.0;
        }
        if let Some(&[mode_hz, damping, gain]) = effect("structural_mode") {
            let ratio = s / (std::f64::consts::TAU * mode_hz);
            response *= (ratio * (ratio + 2.0 * damping) + 1.0).inv() * gain + (1.0 - gain);
        }
        response
    }

    /// Effects of the model that no linear response shows, except for contributions of a sensor that are independent of the actuator.
    #[must_use]
    pub fn left_out(&self) -> Vec<&'static str> {
        const SHOWN: [&str; 4] = ["delay", "hinge_load", "sensor_lag", "structural_mode"];
        const ADDED: [&str; 2] = ["chatter", "sensor_bias"];
        let names = self.model.effects.active().map(|(effect, _)| effect.name);
        names.filter(|name| !SHOWN.contains(name) && !ADDED.contains(name)).collect()
    }
}

impl Serialize for Set {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Set", 8)?;
        fields.serialize_field("label", &self.label)?;
        fields.serialize_field("order", self.model.order.short())?;
        for (parameter, value) in Base::PARAMETERS.iter().zip(self.model.base.values()) {
            fields.serialize_field(parameter.name, &value)?;
        }
        fields.serialize_field("delay_s", &self.delay_s)?;
        match self.left_out() {
            left_out if left_out.is_empty() => fields.skip_field("left_out")?,
            left_out => fields.serialize_field("left_out", &left_out)?,
        }
        fields.end()
    }
}
