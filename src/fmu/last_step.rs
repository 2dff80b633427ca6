//! The last step before a communication point, from which the directional derivatives of co-simulation are computed.

use serde::{Deserialize, Serialize};

use crate::{
    actuator::{Inputs, State},
    command::Change,
    transition::Ramp,
};

/// The last step before a communication point.
#[derive(Debug, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // on the heap it would be allocated in a step
pub enum LastStep {
    /// No step yet.
    None,
    /// A step without effects: derivatives in closed form.
    Linear {
        /// [s]
        duration: f64,
        /// Command during the step.
        command: Ramp,
    },
    /// A step with effects, a load or a failure.
    WithEffects(StepRecord),
}

/// Data needed to repeat a step.
#[derive(Debug, Serialize, Deserialize)]
pub struct StepRecord {
    /// [s]
    pub duration: f64,
    /// Inputs during the step.
    pub inputs: Inputs,
    /// State at its start, without the history.
    pub before: State,
    /// Change of the history by the step.
    pub change: Change,
}

impl Clone for StepRecord {
    fn clone(&self) -> Self {
        Self { before: self.before.clone(), ..*self }
    }

    #[inline]
    fn clone_from(&mut self, source: &Self) {
        let Self { duration, inputs, before, change } = source;
        (self.duration, self.inputs, self.change) = (*duration, *inputs, *change);
        self.before.clone_from(before);
    }
}

impl Clone for LastStep {
    fn clone(&self) -> Self {
        match self {
            Self::None => Self::None,
            Self::Linear { duration, command } => Self::Linear { duration: *duration, command: *command },
            Self::WithEffects(record) => Self::WithEffects(record.clone()),
        }
    }

    #[inline]
    fn clone_from(&mut self, source: &Self) {
        match (self, source) {
            (Self::WithEffects(own), Self::WithEffects(other)) => own.clone_from(other),
            (own, Self::Linear { duration, command }) => own.set_linear(*duration, *command),
            (own, other) => *own = other.clone(),
        }
    }
}

impl LastStep {
    /// A step without effects.
    #[inline]
    pub fn set_linear(&mut self, duration_s: f64, ramp: Ramp) {
        match self {
            Self::Linear { duration, command } => (*duration, *command) = (duration_s, ramp),
            other => other.replace(Self::Linear { duration: duration_s, command: ramp }),
        }
    }

    #[cold]
    #[inline(never)]
    fn replace(&mut self, by: Self) {
        *self = by;
    }

    /// True for a step without effects.
    #[inline]
    pub fn is_linear(&self) -> bool {
        matches!(self, Self::Linear { .. })
    }

    /// Duration [s] and inputs, if there is a step.
    pub fn inputs(&self) -> Option<(f64, Inputs)> {
        match self {
            Self::None => None,
            Self::Linear { duration, command } => Some((*duration, Inputs::command(*command))),
            Self::WithEffects(record) => Some((record.duration, record.inputs)),
        }
    }

    /// The state before a step with effects.
    pub fn before(&self) -> Option<&State> {
        if let Self::WithEffects(record) = self { Some(&record.before) } else { None }
    }
}
