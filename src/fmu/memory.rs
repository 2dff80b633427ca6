//! The memory of an instance: the content of a saved state.

use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

use fmi_export::{Error, Kind, Result, Value};

use super::{
    last_step::LastStep,
    model_exchange_state::ModelExchangeState,
    settings::{Settings, failure},
    start_values::start_value,
    variables::{Causality, Slot, variables},
};
use crate::{
    actuator::{Inputs, State},
    transition::Ramp,
};

/// An input between two communication points: linear if its derivative was set after the value, otherwise held.
///
/// Value and derivative are not adjacent, for the reason given in [`State`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct Input {
    value: f64,
    /// The derivative was set since the last communication point.
    slope_is_new: bool,
    slope: f64,
}

impl Input {
    /// Value at the communication point.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Sets the value, which is held unless a new derivative follows.
    #[inline]
    pub fn set_value(&mut self, value: f64) {
        self.value = value;
        if !self.slope_is_new {
            self.slope = 0.0;
        }
    }

    /// Sets the derivative.
    pub fn set_slope(&mut self, slope: f64) {
        (self.slope, self.slope_is_new) = (slope, true);
    }

    /// The input from here on.
    #[inline]
    pub fn ramp(&self) -> Ramp {
        Ramp { value: self.value, slope: self.slope }
    }

    /// True if it is 0 and stays so.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.ramp().is_zero()
    }

    /// Advances by `duration` [s].
    #[inline]
    pub fn advance(&mut self, duration: f64) {
        if self.slope != 0.0 {
            self.value += self.slope * duration;
        }
        self.slope_is_new = false;
    }
}

/// Item of the enumeration of failures.
pub const NO_FAILURE: i32 = 1;

/// Identifies settings without comparing them: the number changes whenever they do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SettingsVersion(u64);

impl SettingsVersion {
    pub fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// True for a variable of the settings.
#[inline]
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
    pub last_step: LastStep,
    /// From the end of initialization on, for a model-exchange instance.
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

    /// Without allocation if the capacity of the history suffices, and without copying unchanged settings.
    #[inline]
    fn clone_from(&mut self, source: &Self) {
        if !self.copy_motion(source) {
            self.copy(source);
        }
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
            last_step: LastStep::None,
            exchange: None,
        }
    }

    /// Fast path: copies what changes without effects and delay; false if more has to be copied.
    #[inline]
    fn copy_motion(&mut self, source: &Self) -> bool {
        let is_alike = self.version == source.version
            && self.last_step.is_linear()
            && self.exchange.is_none()
            && source.exchange.is_none();
        match (&mut self.state, &source.state, &source.last_step) {
            (Some(own), Some(state), LastStep::Linear { duration, command })
                if is_alike && own.history.is_empty() && state.history.is_empty() =>
            {
                own.set_all_but_history(state);
                self.last_step.set_linear(*duration, *command);
                self.copy_inputs(source);
                true
            }
            _ => false,
        }
    }

    #[inline]
    fn copy_inputs(&mut self, source: &Self) {
        let Self { start_time, command, load, failure, .. } = *source;
        (self.start_time, self.command, self.load, self.failure) = (start_time, command, load, failure);
    }

    #[inline(never)]
    fn copy(&mut self, source: &Self) {
        if self.version != source.version {
            (self.settings, self.version) = (source.settings.clone(), source.version);
        }
        self.copy_inputs(source);
        self.state.clone_from(&source.state);
        self.last_step.clone_from(&source.last_step);
        // Copying `None` over `None` would copy the whole value.
        if self.exchange.is_some() || source.exchange.is_some() {
            self.exchange.clone_from(&source.exchange);
        }
    }

    /// Inputs from here on.
    #[inline]
    pub fn inputs(&self) -> Inputs {
        Inputs { command: self.command.ramp(), load: self.load.ramp(), failure: failure(self.failure) }
    }

    /// Refuses a memory that no sequence of calls can have produced.
    pub fn check(&self, kind: Kind, is_initialized: bool) -> Result<()> {
        let mut numbers = vec![self.start_time];
        let last = self.last_step.inputs();
        let ramps = [self.command.ramp(), self.load.ramp()].into_iter();
        for ramp in ramps.chain(last.iter().flat_map(|(_, inputs)| [inputs.command, inputs.load])) {
            numbers.extend([ramp.value, ramp.slope]);
        }
        numbers.extend(last.map(|(duration, _)| duration));
        let states = self.state.iter().chain(self.last_step.before());
        for state in states {
            numbers.extend([state.time, state.pole, state.position, state.rate]);
            numbers.extend(&state.memory);
            numbers.extend(state.history.iter().flat_map(|knot| [knot.time, knot.value, knot.slope]));
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

    #[inline(never)]
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
