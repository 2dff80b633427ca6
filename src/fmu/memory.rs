//! Everything that a saved state of the slave holds.

use serde::{Deserialize, Serialize};

use super::{
    calls::Phase,
    settings::{Settings, failure},
    variables::{Causality, Kind, Slot, Variable, variables},
};
use crate::{
    actuator::{Inputs, State},
    error::{Error, Result},
    transition::Ramp,
};

/// A value on its way in or out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// Of a Real.
    Real(f64),
    /// Of an Integer or of an Enumeration (item number).
    Integer(i32),
    /// Of a Boolean.
    Boolean(bool),
}

/// An input between two communication points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Input {
    value: f64,
    slope: f64,
    value_is_new: bool,
    slope_is_new: bool,
}

impl Input {
    pub fn value(&self) -> f64 {
        self.value
    }

    pub fn set_value(&mut self, value: f64) {
        (self.value, self.value_is_new) = (value, true);
    }

    pub fn set_slope(&mut self, slope: f64) {
        (self.slope, self.slope_is_new) = (slope, true);
    }

    /// Held from here where only the value was set; else on the line it is on.
    pub fn ramp(&self) -> Ramp {
        let held = self.value_is_new && !self.slope_is_new;
        Ramp { value: self.value, slope: if held { 0.0 } else { self.slope } }
    }

    pub fn advance(&mut self, duration: f64) {
        let ramp = self.ramp();
        *self = Self { value: ramp.at(duration), slope: ramp.slope, value_is_new: false, slope_is_new: false };
    }
}

/// The step that led to a communication point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct LastStep {
    /// [s]
    pub duration: f64,
    /// What came in.
    pub inputs: Inputs,
    /// Where it started, kept where effects act and its derivatives have no closed form.
    pub before: Option<State>,
}

/// Everything that a saved state holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Memory {
    pub phase: Phase,
    pub settings: Settings,
    pub start_time: f64,
    pub time: f64,
    pub stop_time: Option<f64>,
    pub command: Input,
    pub load: Input,
    /// Item of the enumeration.
    pub failure: i32,
    /// From the end of initialization on.
    pub state: Option<State>,
    pub last_step: Option<LastStep>,
}

impl Memory {
    pub fn new(start: &Settings) -> Self {
        Self {
            phase: Phase::Instantiated,
            settings: start.clone(),
            start_time: 0.0,
            time: 0.0,
            stop_time: None,
            command: Input::default(),
            load: Input::default(),
            failure: 1,
            state: None,
            last_step: None,
        }
    }

    /// What comes in from here on.
    pub fn inputs(&self) -> Inputs {
        Inputs { command: self.command.ramp(), load: self.load.ramp(), failure: failure(self.failure) }
    }

    pub fn is_initialized(&self) -> bool {
        matches!(self.phase, Phase::Stepping | Phase::Terminated)
    }

    /// Refuses what no sequence of calls could have produced.
    pub fn check(&self) -> Result<()> {
        let mut numbers =
            vec![self.start_time, self.time, self.command.value, self.command.slope, self.load.value, self.load.slope];
        numbers.extend(self.stop_time);
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
        if self.is_initialized() != self.state.is_some() {
            return Err(Error::new(
                "FMU state",
                "a motion before its initialization, or none after",
                "both or neither",
            ));
        }
        if self.settings.effects.len() != Settings::default().effects.len() {
            return Err(Error::new(
                "FMU state",
                format!("{} effect parameters", self.settings.effects.len()),
                "as many as the model has",
            ));
        }
        for variable in variables().iter().filter(|variable| variable.causality == Causality::Parameter) {
            if let Some(value) = start_value(variable, &self.settings) {
                check_range(variable, value)?;
            }
        }
        if self.is_initialized() {
            self.settings.actuator()?;
        }
        Ok(())
    }

    /// Puts a checked value where it belongs.
    pub fn assign(&mut self, slot: Slot, value: Value) {
        let settings = &mut self.settings;
        match (slot, value) {
            (Slot::Command, Value::Real(value)) => self.command.set_value(value),
            (Slot::Load, Value::Real(value)) => self.load.set_value(value),
            (Slot::Failure, Value::Integer(value)) => self.failure = value,
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

/// Value at the start of an input or parameter; nothing for what is calculated.
pub(super) fn start_value(variable: &Variable, settings: &Settings) -> Option<Value> {
    Some(match variable.slot {
        Slot::Command | Slot::Load => Value::Real(0.0),
        Slot::Failure => Value::Integer(1),
        Slot::Surface => Value::Integer(settings.surface),
        Slot::Stage => Value::Integer(settings.stage),
        Slot::LoadCase => Value::Integer(settings.load_case),
        Slot::SetNumber => Value::Integer(settings.set_number),
        Slot::Order => Value::Integer(settings.order),
        Slot::Source => Value::Integer(settings.source),
        Slot::Custom(index) => Value::Real(settings.custom[index]),
        Slot::InitialPosition => Value::Real(settings.initial_position),
        Slot::Effect(index) => Value::Real(settings.effects[index]),
        Slot::Position | Slot::Deflection | Slot::Rate | Slot::Saturated | Slot::Active(_) => return None,
    })
}

/// Refuses a value of another type or outside the range of the variable.
pub(super) fn check_range(variable: &Variable, value: Value) -> Result<()> {
    let refuse =
        |found: String, allowed: String| Err(Error::new(format!("value of `{}`", variable.name), found, allowed));
    match (&variable.kind, value) {
        (Kind::Real { range, unit, .. }, Value::Real(value)) => {
            let (min, max) = range.unwrap_or((f64::MIN, f64::MAX));
            if (min..=max).contains(&value) {
                return Ok(());
            }
            let allowed = if range.is_some() { format!("{min} to {max} {unit}") } else { "finite numbers".into() };
            refuse(format!("{value} {unit}"), allowed)
        }
        (Kind::Integer { min, max }, Value::Integer(value)) if (*min..=*max).contains(&value) => Ok(()),
        (Kind::Integer { min, max }, Value::Integer(value)) => refuse(value.to_string(), format!("{min} to {max}")),
        (Kind::Enumeration(of), Value::Integer(value)) => {
            if (1..=of.items.len()).contains(&usize::try_from(value).unwrap_or(0)) {
                return Ok(());
            }
            let items: Vec<String> =
                of.items.iter().zip(1..).map(|(name, number)| format!("{number} = {name}")).collect();
            refuse(value.to_string(), items.join(", "))
        }
        (Kind::Boolean, Value::Boolean(_)) => Ok(()),
        (kind, value) => refuse(value.kind().into(), kind.wanted().into()),
    }
}

impl Value {
    /// Its type in words.
    pub fn kind(self) -> &'static str {
        match self {
            Self::Real(_) => "a Real",
            Self::Integer(_) => "an Integer",
            Self::Boolean(_) => "a Boolean",
        }
    }
}

impl Kind {
    /// True for a value of this type.
    pub(super) fn takes(&self, value: Value) -> bool {
        matches!(
            (self, value),
            (Self::Real { .. }, Value::Real(_))
                | (Self::Integer { .. } | Self::Enumeration(_), Value::Integer(_))
                | (Self::Boolean, Value::Boolean(_))
        )
    }

    /// The type in words.
    pub(super) fn wanted(&self) -> &'static str {
        match self {
            Self::Real { .. } => "a Real",
            Self::Integer { .. } => "an Integer",
            Self::Boolean => "a Boolean",
            Self::Enumeration(_) => "an Enumeration (set and read as an Integer)",
        }
    }
}

/// The variable of a value reference.
pub(super) fn variable(reference: u32) -> Result<&'static Variable> {
    let all = variables();
    usize::try_from(reference)
        .ok()
        .and_then(|index| all.get(index))
        .ok_or_else(|| Error::new("value reference", reference.to_string(), format!("0 to {}", all.len() - 1)))
}
