//! The memory of an instance: everything that a saved state contains.

use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

use fmi_export::{Error, Kind, Result, Value};

use super::{
    model_exchange_state::ModelExchangeState,
    settings::{Settings, failure},
    start_values::start_value,
    variables::{Causality, Slot, variables},
};
use crate::{
    actuator::{Inputs, State},
    command::Change,
    transition::Ramp,
};

/// An input between two communication points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Input {
    value: f64,
    slope: f64,
    value_is_new: bool,
    slope_is_new: bool,
}

impl Input {
    /// Value at the communication point.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Sets the value.
    pub fn set_value(&mut self, value: f64) {
        (self.value, self.value_is_new) = (value, true);
    }

    /// Sets the derivative.
    pub fn set_slope(&mut self, slope: f64) {
        (self.slope, self.slope_is_new) = (slope, true);
    }

    /// Held where only the value was set, else linear.
    #[inline]
    pub fn ramp(&self) -> Ramp {
        let held = self.value_is_new && !self.slope_is_new;
        Ramp { value: self.value, slope: if held { 0.0 } else { self.slope } }
    }

    /// True where it is 0 and stays so.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.ramp() == Ramp::default()
    }

    /// Advances by `duration` [s].
    #[inline]
    pub fn advance(&mut self, duration: f64) {
        let ramp = self.ramp();
        *self = Self { value: ramp.at(duration), slope: ramp.slope, value_is_new: false, slope_is_new: false };
    }
}

/// The step that led to a communication point.
#[derive(Debug, Serialize, Deserialize)]
pub struct LastStep {
    /// [s]
    pub duration: f64,
    /// Inputs during the step.
    pub inputs: Inputs,
    /// State at its start but for the history, stored where effects act, so that the derivatives have no closed form.
    pub before: Option<State>,
    /// What the step has changed in the history.
    pub change: Change,
}

/// Item of the enumeration of failures.
pub const NO_FAILURE: i32 = 1;

impl LastStep {
    /// A step without effects.
    pub fn linear(command: Ramp, duration: f64) -> Self {
        Self { duration, inputs: Inputs::command(command), before: None, change: Change::None }
    }
}

impl Clone for LastStep {
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

/// Tells settings apart without comparing them: the number changes whenever they do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SettingsVersion(u64);

impl SettingsVersion {
    pub fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// True for a variable of the settings.
pub fn is_parameter(slot: Slot) -> bool {
    !matches!(slot, Slot::Command | Slot::Load | Slot::Failure)
}

/// Memory of an instance.
#[derive(Debug, Serialize, Deserialize)]
pub struct Memory {
    pub settings: Settings,
    #[serde(skip, default = "SettingsVersion::new")]
    pub version: SettingsVersion,
    pub start_time: f64,
    pub command: Input,
    pub load: Input,
    /// Item of the enumeration.
    pub failure: i32,
    /// From the end of initialization on.
    pub state: Option<State>,
    pub last_step: Option<LastStep>,
    /// From the end of initialization on, of a model-exchange instance.
    pub(super) exchange: Option<ModelExchangeState>,
}

impl Clone for Memory {
    fn clone(&self) -> Self {
        Self {
            settings: self.settings.clone(),
            state: self.state.clone(),
            last_step: self.last_step.clone(),
            exchange: self.exchange.clone(),
            ..*self
        }
    }

    /// Without allocation, where the past command has room, and without copying settings that are the same.
    fn clone_from(&mut self, source: &Self) {
        if self.version != source.version {
            (self.settings, self.version) = (source.settings.clone(), source.version);
        }
        let Self { start_time, command, load, failure, .. } = *source;
        (self.start_time, self.command, self.load, self.failure) = (start_time, command, load, failure);
        self.state.clone_from(&source.state);
        self.last_step.clone_from(&source.last_step);
        self.exchange.clone_from(&source.exchange);
    }
}

impl Memory {
    /// As after instantiation.
    pub fn new(start: &Settings) -> Self {
        Self {
            settings: start.clone(),
            version: SettingsVersion::new(),
            start_time: 0.0,
            command: Input::default(),
            load: Input::default(),
            failure: NO_FAILURE,
            state: None,
            last_step: None,
            exchange: None,
        }
    }

    /// Inputs from here on.
    #[inline]
    pub fn inputs(&self) -> Inputs {
        Inputs { command: self.command.ramp(), load: self.load.ramp(), failure: failure(self.failure) }
    }

    /// Refuses a memory that no sequence of calls can have produced.
    pub fn check(&self, kind: Kind, is_initialized: bool) -> Result<()> {
        let mut numbers =
            vec![self.start_time, self.command.value, self.command.slope, self.load.value, self.load.slope];
        let states = self.state.iter().chain(self.last_step.iter().filter_map(|last| last.before.as_ref()));
        for state in states {
            numbers.extend([state.time, state.pole, state.position, state.rate]);
            numbers.extend(&state.memory);
            numbers.extend(state.history.iter().flat_map(|knot| [knot.time, knot.value, knot.slope]));
        }
        if let Some(last) = &self.last_step {
            let Inputs { command, load, .. } = last.inputs;
            numbers.extend([last.duration, command.value, command.slope, load.value, load.slope]);
        }
        if let Some(number) = numbers.iter().find(|number| !number.is_finite()) {
            return Err(Error::new("FMU state", number.to_string(), "finite numbers"));
        }
        if is_initialized != self.state.is_some() {
            return Err(Error::new(
                "FMU state",
                "a motion before its initialization, or none after",
                "both or neither",
            ));
        }
        let exchanges = kind == Kind::ModelExchange && is_initialized;
        if exchanges != self.exchange.is_some() || self.exchange.as_ref().is_some_and(|exchange| !exchange.is_finite())
        {
            return Err(Error::new("FMU state", "modes that cannot be", "those of an instance of this kind"));
        }
        for variable in variables().iter().filter(|variable| variable.causality == Causality::Parameter) {
            if let Some(value) = start_value(variable.slot, &self.settings) {
                variable.check_range(value)?;
            }
        }
        if is_initialized {
            self.settings.actuator()?;
        }
        Ok(())
    }

    /// Stores a checked value.
    #[inline]
    pub fn assign(&mut self, slot: Slot, value: Value) {
        match (slot, value) {
            (Slot::Command, Value::Real(value)) => self.command.set_value(value),
            (Slot::Load, Value::Real(value)) => self.load.set_value(value),
            (Slot::Failure, Value::Integer(value)) => self.failure = value,
            _ => self.assign_parameter(slot, value),
        }
    }

    fn assign_parameter(&mut self, slot: Slot, value: Value) {
        self.version = SettingsVersion::new();
        let settings = &mut self.settings;
        match (slot, value) {
            (Slot::Custom(index), Value::Real(value)) => settings.custom[index] = value,
            (Slot::InitialPosition, Value::Real(value)) => settings.initial_position = value,
            (Slot::Effect(index), Value::Real(value)) => settings.effects[index] = value,
            (Slot::Surface, Value::Integer(value)) => settings.surface = value,
            (Slot::Stage, Value::Integer(value)) => settings.stage = value,
            (Slot::LoadCase, Value::Integer(value)) => settings.load_case = value,
            (Slot::SetNumber, Value::Integer(value)) => settings.set_number = value,
            (Slot::Order, Value::Integer(value)) => settings.order = value,
            (Slot::Source, Value::Integer(value)) => settings.source = value,
            // Types and causalities have been checked.
            _ => {}
        }
    }
}
