//! The co-simulation slave, in safe code.
//!
//! A refused call changes nothing. Between communication points the command is held at the value it was set to; if its
//! derivative was set it moves linearly from that value, and goes on so until the command or its derivative is set
//! again. Setting only the value means: held from here.

use std::{
    collections::BTreeMap,
    sync::atomic::{AtomicUsize, Ordering},
};

use serde::{Deserialize, Serialize};

use super::{
    calls::{self, Call, Phase},
    guid::guid,
    log::{Log, Status},
    settings::Settings,
    snapshot,
    variables::{Causality, Kind, Slot, Variability, Variable, variables},
};
use crate::{
    actuator::{Actuator, State, Transitions},
    error::{Error, Result},
    parameters::Base,
    transition::Ramp,
};

/// A value on its way in or out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// Of a Real.
    Real(f64),
    /// Of an Integer or of an Enumeration (item number).
    Integer(i32),
}

/// An input between two communication points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
struct Input {
    value: f64,
    slope: f64,
    value_is_new: bool,
    slope_is_new: bool,
}

impl Input {
    fn ramp(&self) -> Ramp {
        let held = self.value_is_new && !self.slope_is_new;
        Ramp { value: self.value, slope: if held { 0.0 } else { self.slope } }
    }

    fn advance(&mut self, duration: f64) {
        let ramp = self.ramp();
        *self = Self { value: ramp.at(duration), slope: ramp.slope, value_is_new: false, slope_is_new: false };
    }
}

/// Everything that a saved state holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Memory {
    phase: Phase,
    settings: Settings,
    time: f64,
    stop_time: Option<f64>,
    command: Input,
    state: State,
    /// Duration of the step that led here [s].
    last_step: Option<f64>,
}

/// One instance.
#[derive(Debug)]
pub struct Slave {
    /// Start values of this model; what `fmi2Reset` goes back to.
    start: Settings,
    guid: String,
    memory: Memory,
    actuator: Option<Actuator>,
    transitions: Transitions,
    saved: BTreeMap<usize, Memory>,
    pub(super) log: Log,
}

/// Handles of saved states are used once in a process, so that one instance never takes another's for its own.
static NEXT_STATE: AtomicUsize = AtomicUsize::new(1);

/// Two times that differ by less than this share of the step, or of the time itself, are the same communication point:
/// masters add up their steps in their own way.
const SAME_TIME: f64 = 1e-6;

impl Memory {
    fn new(start: &Settings) -> Self {
        Self {
            phase: Phase::Instantiated,
            settings: *start,
            time: 0.0,
            stop_time: None,
            command: Input::default(),
            state: State::at_rest(start.initial_position),
            last_step: None,
        }
    }

    /// Refuses what no sequence of calls could have produced.
    fn check(&self) -> Result<()> {
        let State { pole, position, rate } = self.state;
        let numbers = [
            self.time,
            self.command.value,
            self.command.slope,
            pole,
            position,
            rate,
            self.stop_time.unwrap_or(0.0),
            self.last_step.unwrap_or(1.0),
        ];
        if let Some(number) = numbers.iter().find(|number| !number.is_finite()) {
            return Err(Error::new("FMU state", number.to_string(), "finite numbers"));
        }
        for variable in variables().iter().filter(|variable| variable.causality == Causality::Parameter) {
            if let Some(value) = start_value(variable, &self.settings) {
                check_range(variable, value)?;
            }
        }
        Ok(())
    }
}

/// Value at the start of an input or parameter; nothing for what is calculated.
pub(super) fn start_value(variable: &Variable, settings: &Settings) -> Option<Value> {
    Some(match variable.slot {
        Slot::Command => Value::Real(0.0),
        Slot::Surface => Value::Integer(settings.surface),
        Slot::Stage => Value::Integer(settings.stage),
        Slot::LoadCase => Value::Integer(settings.load_case),
        Slot::SetNumber => Value::Integer(settings.set_number),
        Slot::Order => Value::Integer(settings.order),
        Slot::Source => Value::Integer(settings.source),
        Slot::Custom(index) => Value::Real(settings.custom[index]),
        Slot::InitialPosition => Value::Real(settings.initial_position),
        Slot::Position | Slot::Deflection | Slot::Rate | Slot::Active(_) => return None,
    })
}

fn check_range(variable: &Variable, value: Value) -> Result<()> {
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
        (Kind::Integer { min, max }, Value::Integer(value)) if !(*min..=*max).contains(&value) => {
            refuse(value.to_string(), format!("{min} to {max}"))
        }
        (Kind::Enumeration(of), Value::Integer(value))
            if !(1..=of.items.len()).contains(&usize::try_from(value).unwrap_or(0)) =>
        {
            let items: Vec<String> =
                of.items.iter().zip(1..).map(|(name, number)| format!("{number} = {name}")).collect();
            refuse(value.to_string(), items.join(", "))
        }
        (Kind::Integer { .. } | Kind::Enumeration(_), Value::Integer(_)) => Ok(()),
        (_, Value::Real(_)) => refuse("a Real".into(), "an Integer or Enumeration".into()),
        (_, Value::Integer(_)) => refuse("an Integer".into(), "a Real".into()),
    }
}

fn variable(reference: u32) -> Result<&'static Variable> {
    let all = variables();
    usize::try_from(reference)
        .ok()
        .and_then(|index| all.get(index))
        .ok_or_else(|| Error::new("value reference", reference.to_string(), format!("0 to {}", all.len() - 1)))
}

fn wrong_type(reference: u32, wanted: &str) -> Error {
    let name = variable(reference).map_or("", |variable| &variable.name);
    Error::new("value reference", format!("{reference}, which is `{name}`"), format!("references of {wanted}"))
}

impl Slave {
    /// An instance of the model with these start values.
    #[must_use]
    pub fn new(start: Settings, logging_on: bool) -> Self {
        Self {
            start,
            guid: guid(&start),
            memory: Memory::new(&start),
            actuator: None,
            transitions: Transitions::default(),
            saved: BTreeMap::new(),
            log: Log::new(logging_on),
        }
    }

    fn check(&self, call: Call) -> Result<()> {
        calls::check(call, self.memory.phase)
    }

    fn enter(&mut self, phase: Phase) {
        self.memory.phase = phase;
        self.log.add(Status::Ok, format!("at {} s: {}", self.memory.time, phase.name()));
    }

    /// `fmi2SetupExperiment`
    ///
    /// # Errors
    /// Wrong phase, times that are not finite, a stop before the start.
    pub fn setup_experiment(&mut self, start_time: f64, stop_time: Option<f64>) -> Result<()> {
        self.check(Call::SetupExperiment)?;
        if !start_time.is_finite() {
            return Err(Error::new("startTime", start_time.to_string(), "a finite number"));
        }
        if let Some(stop) = stop_time.filter(|stop| stop.is_nan() || *stop < start_time) {
            return Err(Error::new("stopTime", stop.to_string(), format!("startTime = {start_time} or later")));
        }
        self.memory.time = start_time;
        self.memory.stop_time = stop_time.filter(|stop| stop.is_finite());
        Ok(())
    }

    /// `fmi2EnterInitializationMode`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn enter_initialization_mode(&mut self) -> Result<()> {
        self.check(Call::EnterInitializationMode)?;
        self.enter(Phase::Initialization);
        Ok(())
    }

    /// `fmi2ExitInitializationMode`
    ///
    /// # Errors
    /// Wrong phase; a selection for which the report has no data.
    pub fn exit_initialization_mode(&mut self) -> Result<()> {
        self.check(Call::ExitInitializationMode)?;
        self.apply_settings()?;
        self.memory.state = State::at_rest(self.memory.settings.initial_position);
        self.enter(Phase::Stepping);
        Ok(())
    }

    fn apply_settings(&mut self) -> Result<()> {
        let base = self.memory.settings.base()?;
        self.actuator = Some(Actuator::new(base, self.memory.settings.order()));
        self.transitions.forget();
        Ok(())
    }

    /// `fmi2Terminate`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn terminate(&mut self) -> Result<()> {
        self.check(Call::Terminate)?;
        self.enter(Phase::Terminated);
        Ok(())
    }

    /// `fmi2Reset`: as after instantiation. Saved states stay valid.
    ///
    /// # Errors
    /// None at present.
    pub fn reset(&mut self) -> Result<()> {
        self.check(Call::Reset)?;
        self.memory = Memory::new(&self.start);
        self.actuator = None;
        Ok(())
    }

    /// Value of a variable now.
    ///
    /// # Errors
    /// Wrong reference; parameters in use of a selection without data.
    pub fn get(&self, reference: u32) -> Result<Value> {
        self.check(Call::Get)?;
        let variable = variable(reference)?;
        if let (Slot::Command, _) | (_, None) = (variable.slot, start_value(variable, &self.memory.settings)) {
            return self.quantity(variable.slot).map(Value::Real);
        }
        start_value(variable, &self.memory.settings)
            .ok_or_else(|| Error::new("variable", &variable.name, "one with a value"))
    }

    /// As [`Slave::get`], of a Real.
    ///
    /// # Errors
    /// Those of [`Slave::get`], or another type.
    pub fn get_real(&self, reference: u32) -> Result<f64> {
        match self.get(reference)? {
            Value::Real(value) => Ok(value),
            Value::Integer(_) => Err(wrong_type(reference, "a Real")),
        }
    }

    /// As [`Slave::get`], of an Integer or Enumeration.
    ///
    /// # Errors
    /// Those of [`Slave::get`], or another type.
    pub fn get_integer(&self, reference: u32) -> Result<i32> {
        match self.get(reference)? {
            Value::Integer(value) => Ok(value),
            Value::Real(_) => Err(wrong_type(reference, "an Integer or Enumeration")),
        }
    }

    fn state(&self) -> State {
        match self.memory.phase {
            Phase::Instantiated | Phase::Initialization => State::at_rest(self.memory.settings.initial_position),
            Phase::Stepping | Phase::Terminated => self.memory.state,
        }
    }

    fn quantity(&self, slot: Slot) -> Result<f64> {
        Ok(match slot {
            Slot::Position | Slot::Deflection => self.state().position,
            Slot::Rate => self.state().rate,
            Slot::Active(index) => self.memory.settings.base()?.values()[index],
            _ => self.memory.command.value,
        })
    }

    /// Sets variables, all of them or, if one is refused, none.
    ///
    /// # Errors
    /// Wrong reference, type, range or phase; a variable that cannot be set.
    pub fn set(&mut self, items: impl Iterator<Item = (u32, Value)> + Clone) -> Result<()> {
        let mut parameters_change = false;
        for (reference, value) in items.clone() {
            let variable = variable(reference)?;
            match variable.causality {
                Causality::Input => self.check(Call::Set),
                Causality::Parameter if variable.variability == Variability::Tunable => self.check(Call::Set),
                Causality::Parameter => self.check(Call::SetFixed),
                Causality::Output | Causality::CalculatedParameter => Err(Error::new(
                    "variable to set",
                    format!("`{}`, which is calculated", variable.name),
                    "inputs and parameters",
                )),
            }
            .map_err(|error| error.remedy(format!("value of `{}` not set", variable.name)))?;
            check_range(variable, value)?;
            parameters_change |= variable.causality == Causality::Parameter;
        }
        for (reference, value) in items {
            self.assign(variable(reference)?.slot, value);
        }
        if parameters_change && self.memory.phase == Phase::Stepping {
            self.apply_settings()?;
        }
        Ok(())
    }

    fn assign(&mut self, slot: Slot, value: Value) {
        let settings = &mut self.memory.settings;
        match (slot, value) {
            (Slot::Command, Value::Real(value)) => {
                self.memory.command.value = value;
                self.memory.command.value_is_new = true;
            }
            (Slot::Custom(index), Value::Real(value)) => settings.custom[index] = value,
            (Slot::InitialPosition, Value::Real(value)) => settings.initial_position = value,
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

    /// `fmi2SetRealInputDerivatives`, all of them or none.
    ///
    /// # Errors
    /// Wrong phase, reference, order or value.
    pub fn set_input_derivatives(&mut self, items: &[(u32, i32, f64)]) -> Result<()> {
        self.check(Call::SetInputDerivatives)?;
        for (reference, order, value) in items {
            let variable = variable(*reference)?;
            if variable.slot != Slot::Command {
                return Err(Error::new("input derivative", format!("`{}`", variable.name), "`command`"));
            }
            if *order != 1 {
                return Err(Error::new("order of an input derivative", order.to_string(), "1"));
            }
            if !value.is_finite() {
                return Err(Error::new(
                    format!("derivative of `{}`", variable.name),
                    value.to_string(),
                    "finite numbers",
                ));
            }
        }
        if let Some((_, _, value)) = items.last() {
            self.memory.command.slope = *value;
            self.memory.command.slope_is_new = true;
        }
        Ok(())
    }

    fn actuator(&self) -> Result<&Actuator> {
        self.actuator.as_ref().ok_or_else(|| Error::new("instance", "no parameters in use", "an initialized instance"))
    }

    /// `fmi2GetRealOutputDerivatives` of one output.
    ///
    /// # Errors
    /// Wrong phase, reference or order.
    pub fn output_derivative(&self, reference: u32, order: i32) -> Result<f64> {
        self.check(Call::GetOutputDerivatives)?;
        let variable = variable(reference)?;
        if order != 1 {
            return Err(Error::new("order of an output derivative", order.to_string(), "1"));
        }
        match variable.slot {
            Slot::Position | Slot::Deflection => Ok(self.memory.state.rate),
            Slot::Rate => Ok(self.actuator()?.acceleration(&self.memory.state, self.memory.command.value)),
            _ => {
                Err(Error::new("output derivative", format!("`{}`", variable.name), "`position`, `deflection`, `rate`"))
            }
        }
    }

    /// Partial derivative of an unknown by a known, as `fmi2GetDirectionalDerivative` sums them: in initialization mode
    /// of what is calculated by the parameters; afterwards of the outputs by the command, over the last step (the
    /// function f_doStep of section 4.1 of the standard).
    ///
    /// # Errors
    /// Wrong phase; a variable that is no unknown or no known in this phase.
    pub fn partial_derivative(&self, unknown: u32, known: u32) -> Result<f64> {
        self.check(Call::GetDirectionalDerivative)?;
        let (unknown, known) = (variable(unknown)?, variable(known)?);
        let initializing = self.memory.phase == Phase::Initialization;
        let is_unknown = match unknown.causality {
            Causality::Output => true,
            Causality::CalculatedParameter => initializing,
            _ => false,
        };
        if !is_unknown {
            return Err(Error::new(
                "unknown of a directional derivative",
                format!("`{}`", unknown.name),
                "an output, or in initialization mode a calculated parameter",
            ));
        }
        let is_real = matches!(known.kind, Kind::Real { .. });
        let is_known =
            is_real && (known.causality == Causality::Input || initializing && known.causality == Causality::Parameter);
        if !is_known {
            return Err(Error::new(
                "known of a directional derivative",
                format!("`{}`", known.name),
                "`command`, or in initialization mode a Real parameter",
            ));
        }
        if initializing {
            let settings = &self.memory.settings;
            return Ok(match (unknown.slot, known.slot) {
                (Slot::Position | Slot::Deflection, Slot::InitialPosition) => 1.0,
                (Slot::Active(one), Slot::Custom(other)) if one == other && settings.is_custom() => 1.0,
                _ => 0.0,
            });
        }
        let Some(duration) = self.memory.last_step else { return Ok(0.0) };
        let (position, rate) = self.actuator()?.by_command(duration);
        Ok(if unknown.slot == Slot::Rate { rate } else { position })
    }

    /// `fmi2DoStep`: lands exactly on `current + duration`.
    ///
    /// # Errors
    /// Wrong phase, a step that is not positive and finite, another communication point than the one reached, a step past
    /// the stop time, a motion beyond the range of numbers.
    pub fn do_step(&mut self, current: f64, duration: f64) -> Result<()> {
        self.check(Call::DoStep)?;
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(Error::new("communicationStepSize", format!("{duration} s"), "finite numbers above 0"));
        }
        let memory = &self.memory;
        let tolerance = SAME_TIME * duration + 1e3 * f64::EPSILON * memory.time.abs();
        if (current - memory.time).abs() > tolerance || current.is_nan() {
            return Err(Error::new(
                "currentCommunicationPoint",
                format!("{current} s"),
                format!("{} s, where the last step ended", memory.time),
            ));
        }
        let end = current + duration;
        if let Some(stop) = memory.stop_time.filter(|stop| end > stop + tolerance) {
            return Err(Error::new("end of the step", format!("{end} s"), format!("up to the stop time of {stop} s")));
        }
        let mut state = memory.state;
        let command = memory.command.ramp();
        let actuator = *self.actuator()?;
        actuator.step(&mut state, &mut self.transitions, command, duration);
        let next = command.at(duration);
        if ![state.pole, state.position, state.rate, next].iter().all(|number| number.is_finite()) {
            return Err(Error::new(
                "motion in this step",
                format!("{state:?} for a command of {} deg", command.value),
                "finite numbers",
            ));
        }
        self.memory.state = state;
        self.memory.command.advance(duration);
        self.memory.time = end;
        self.memory.last_step = Some(duration);
        Ok(())
    }

    /// `fmi2CancelStep`
    ///
    /// # Errors
    /// Always: no step is ever pending.
    pub fn cancel_step(&self) -> Result<()> {
        self.check(Call::CancelStep)
    }

    /// Time of the last communication point [s], for `fmi2GetRealStatus`.
    ///
    /// # Errors
    /// Wrong phase.
    pub fn last_successful_time(&self) -> Result<f64> {
        self.check(Call::GetStatus)?;
        Ok(self.memory.time)
    }

    /// `fmi2GetFMUstate`: saves the state, into `existing` if that is a saved state, and returns its handle.
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn save(&mut self, existing: Option<usize>) -> Result<usize> {
        self.check(Call::State)?;
        self.store(self.memory.clone(), existing)
    }

    fn store(&mut self, memory: Memory, existing: Option<usize>) -> Result<usize> {
        let handle = match existing {
            Some(handle) => self.saved(handle).map(|_| handle)?,
            None => NEXT_STATE.fetch_add(1, Ordering::Relaxed),
        };
        self.saved.insert(handle, memory);
        Ok(handle)
    }

    fn saved(&self, handle: usize) -> Result<&Memory> {
        self.saved.get(&handle).ok_or_else(|| {
            Error::new("FMU state", format!("handle {handle:#x}"), "states got from this instance and not yet freed")
        })
    }

    /// `fmi2SetFMUstate`
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn restore(&mut self, handle: usize) -> Result<()> {
        self.check(Call::State)?;
        self.memory = self.saved(handle)?.clone();
        self.actuator = None;
        match self.memory.phase {
            Phase::Stepping | Phase::Terminated => self.apply_settings(),
            Phase::Instantiated | Phase::Initialization => Ok(()),
        }
    }

    /// `fmi2FreeFMUstate`
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn free(&mut self, handle: usize) -> Result<()> {
        self.saved(handle)?;
        self.saved.remove(&handle);
        Ok(())
    }

    /// `fmi2SerializeFMUstate`
    ///
    /// # Errors
    /// A handle that is not one of this instance's.
    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>> {
        snapshot::to_bytes(self.saved(handle)?, &self.guid)
    }

    /// `fmi2DeSerializeFMUstate`: returns the handle of a new saved state, or of `existing` overwritten.
    ///
    /// # Errors
    /// Bytes that are corrupt or belong to another model.
    pub fn deserialize(&mut self, bytes: &[u8], existing: Option<usize>) -> Result<usize> {
        self.check(Call::State)?;
        let memory: Memory = snapshot::from_bytes(bytes, &self.guid)?;
        memory.check()?;
        if !matches!(memory.phase, Phase::Instantiated | Phase::Initialization) {
            memory.settings.base()?;
        }
        self.store(memory, existing)
    }

    /// Parameters in use.
    ///
    /// # Errors
    /// A selection without data.
    pub fn base(&self) -> Result<Base> {
        self.memory.settings.base()
    }
}
