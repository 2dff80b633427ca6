//! What is compared: a model, what it is called, and under what condition it was tested.

use nalgebra::Complex;
use serde::{Serialize, Serializer, ser::SerializeStruct};

use super::condition::Condition;
use crate::frequency::DelayedModel;
use actuator_fmu::parameters::{Base, Model};

/// A model and what it is called; its condition where it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Set {
    /// Set name or file.
    pub label: String,
    /// Surface, stage and load case.
    pub condition: Option<Condition>,
    /// The dynamics.
    pub model: Model,
    /// Delay between command and actuator [s].
    pub delay_s: f64,
    /// Covariance of ln |k|, ln ω, ln ζ, the lag 1/p [s] and the delay [s], where they were estimated.
    pub covariance: Option<[[f64; 5]; 5]>,
}

impl Set {
    /// A model of which neither condition nor covariance is known.
    #[must_use]
    pub fn new(label: impl Into<String>, model: Model) -> Self {
        Self { label: label.into(), condition: None, model, delay_s: 0.0, covariance: None }
    }

    /// Its response at a frequency [Hz], delay included.
    #[must_use]
    pub fn response(&self, frequency_hz: f64) -> Complex<f64> {
        let Self { model, delay_s, .. } = self;
        DelayedModel { base: model.base, order: model.order, delay_s: *delay_s }.response(frequency_hz)
    }
}

impl Serialize for Set {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Set", 7)?;
        fields.serialize_field("label", &self.label)?;
        fields.serialize_field("order", self.model.order.short())?;
        for (parameter, value) in Base::PARAMETERS.iter().zip(self.model.base.values()) {
            fields.serialize_field(parameter.name, &value)?;
        }
        fields.serialize_field("delay_s", &self.delay_s)?;
        fields.end()
    }
}
