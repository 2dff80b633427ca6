//! The interface to [`fmi_export`]: start values, variables, memory, steps.
//!
//! Between communication points an input is held at its value; if its derivative was set, it is linear from that value until the input or
//! its derivative is set again. Setting only the value means: held from here.

use std::{
    path::PathBuf,
    sync::{Mutex, OnceLock, PoisonError},
};

use fmi_export::{Error, EventUpdate, Kind, Model, Phase, Request, Result, Value};

use super::{
    access::reserve_history,
    actuator_model::ActuatorModel,
    guid::guid,
    identifier::{MODEL_IDENTIFIER, MODEL_RESOURCE},
    memory::Memory,
    model_exchange,
    start::Start,
    variables::{Slot, Variable, Variables, variables},
};
use crate::{actuator::Actuator, parameters};

/// Start values of the model with this GUID: the default ones, or those of the model file in the resources.
fn start_values(request: &Request) -> Result<Start> {
    static READ: Mutex<Vec<(String, Start)>> = Mutex::new(Vec::new());
    let own = own_guid();
    let wanted = request.guid.as_deref().ok_or_else(|| Error::new("fmuGUID", "NULL", own))?;
    if wanted == own {
        return Ok(Start::default());
    }
    // The GUID is a hash of the start values: values read once are valid for every instance.
    let read = || READ.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, start)) = read().iter().find(|(guid, _)| guid == wanted) {
        return Ok(start.clone());
    }
    let start = read_start_values(request, wanted, own)?;
    read().push((wanted.to_owned(), start.clone()));
    Ok(start)
}

/// GUID of the default start values.
fn own_guid() -> &'static str {
    static OWN: OnceLock<String> = OnceLock::new();
    OWN.get_or_init(|| guid(&Start::default()))
}

/// Start values from the model file in the resources, if its GUID matches.
fn read_start_values(request: &Request, wanted: &str, own: &str) -> Result<Start> {
    let remedy = "take binary and modelDescription.xml from the same FMU";
    let refuse = |found: String| crate::error::Error::new("fmuGUID", found, own).remedy(remedy);
    let files: Vec<PathBuf> =
        request.resource_folders().into_iter().map(|folder| folder.join(MODEL_RESOURCE)).collect();
    let file = files.iter().find(|file| file.is_file()).or(files.first());
    let file = file.ok_or_else(|| refuse(format!("{wanted} and no fmuResourceLocation")))?;
    let text =
        std::fs::read_to_string(file).map_err(|error| refuse(format!("{wanted}, and {}: {error}", file.display())))?;
    let start = Start::from_model(&parameters::Model::parse(&text).map_err(|error| error.at(file, None))?);
    if guid(&start) == wanted {
        return Ok(start);
    }
    let allowed = format!("{own} or {}", guid(&start));
    Err(crate::error::Error::new("fmuGUID", wanted, allowed).remedy(remedy).at(file, None).into())
}

impl Model for ActuatorModel {
    type Start = Start;
    type Slot = Slot;
    type Memory = Memory;

    const IDENTIFIER: &'static str = MODEL_IDENTIFIER;
    const KINDS: &'static [Kind] = &[Kind::ModelExchange, Kind::CoSimulation];
    const STATES: usize = model_exchange::STATES;
    const EVENT_INDICATORS: usize = Actuator::EVENT_INDICATORS;

    fn start(request: &Request) -> Result<Start> {
        start_values(request)
    }

    fn guid(start: &Start) -> String {
        guid(start)
    }

    fn new(start: &Start, kind: Kind) -> Self {
        Self::with_memory(kind, start.identity.unit, Memory::new(&start.settings))
    }

    #[inline]
    fn variables() -> &'static Variables {
        variables()
    }

    #[inline]
    fn get(&self, slot: Slot, _now: Phase) -> Result<Value> {
        self.value(slot)
    }

    fn set(&mut self, slot: Slot, value: Value) {
        self.memory.assign(slot, value);
    }

    fn set_all(&mut self, items: impl Iterator<Item = (Slot, Value)> + Clone, now: Phase) -> Result<()> {
        self.assign(items, now)
    }

    #[inline]
    fn set_one(&mut self, slot: Slot, value: Value, now: Phase) -> Result<()> {
        match (slot, value) {
            (Slot::Command, Value::Real(command)) if now != Phase::EventMode => self.memory.command.set_value(command),
            (Slot::Load, Value::Real(load)) if now != Phase::EventMode => self.memory.load.set_value(load),
            _ => return self.assign_one(slot, value, now),
        }
        Ok(())
    }

    #[inline]
    fn memory(&self) -> &Memory {
        &self.memory
    }

    fn restore(&mut self, memory: Memory, now: Phase) -> Result<()> {
        self.restore_from(&memory, now)
    }

    #[inline]
    fn restore_from(&mut self, memory: &Memory, now: Phase) -> Result<()> {
        // The actuator is a function of the settings. Masters that repeat steps restore the same settings every time.
        let is_unchanged = self.actuator.is_some() && memory.version == self.memory.version && now.is_initialized();
        if !is_unchanged {
            self.restore_actuator(memory, now)?;
        }
        self.outputs.set(None);
        self.memory.clone_from(memory);
        Ok(())
    }

    fn check(memory: &Memory, kind: Kind, now: Phase) -> Result<()> {
        memory.check(kind, now.is_initialized())
    }

    /// Refuses a selection without data in the report, inconsistent parameters of an effect, an initial position beyond a stop.
    fn initialize(&mut self, time: f64) -> Result<()> {
        let actuator = self.memory.settings.actuator()?;
        let initial = self.memory.settings.initial_position;
        let unit = self.unit;
        if actuator.holding_command(initial).is_none() {
            let allowed = "a position that some command holds, through the effects on the command";
            return Err(Error::new("initial_position", format!("{initial} {unit}"), allowed));
        }
        let (min, max) = actuator.stops();
        if !(min..=max).contains(&initial) {
            let allowed = format!("{min} to {max} {unit}, the position_limit");
            return Err(Error::new("initial_position", format!("{initial} {unit}"), allowed));
        }
        // Nothing is refused from here on: a refused initialization has changed nothing.
        let mut state = actuator.at_rest(initial);
        reserve_history(&actuator, &mut state);
        let exchange = (self.kind == Kind::ModelExchange).then(|| self.first_modes(&actuator, &mut state));
        (self.memory.start_time, self.memory.state, self.memory.exchange) = (time, Some(state), exchange);
        self.workspace.clear();
        self.outputs.set(None);
        self.actuator = Some(actuator);
        Ok(())
    }

    fn partial_derivative(&self, unknown: &'static Variable, known: &'static Variable, now: Phase) -> Result<f64> {
        self.by_step(unknown, known, now)
    }

    #[inline]
    fn step(&mut self, time: f64, duration: f64) -> Result<()> {
        self.advance(time, duration)
    }

    #[inline]
    fn take_warning(&mut self) -> Option<String> {
        self.warning.take().map(str::to_owned)
    }

    fn set_input_derivatives(&mut self, items: &[(&'static Variable, i32, f64)]) -> Result<()> {
        self.set_slopes(items)
    }

    fn output_derivative(&self, variable: &'static Variable, order: i32) -> Result<f64> {
        self.slope(variable, order)
    }

    fn set_time(&mut self, time: f64) {
        self.write_time(time);
    }

    fn states(&self, into: &mut [f64]) {
        self.write_states(into);
    }

    fn set_states(&mut self, states: &[f64]) {
        self.read_states(states);
    }

    fn nominals(&self, into: &mut [f64]) {
        model_exchange::nominals(into, self.unit);
    }

    fn derivatives(&self, into: &mut [f64]) -> Result<()> {
        self.write_derivatives(into)
    }

    fn event_indicators(&self, into: &mut [f64]) -> Result<()> {
        self.write_event_indicators(into)
    }

    fn enter_event_mode(&mut self) -> Result<()> {
        self.begin_event()
    }

    fn new_discrete_states(&mut self) -> Result<EventUpdate> {
        self.update_discrete_states()
    }

    fn completed_integrator_step(&mut self) -> Result<bool> {
        let inputs = self.advance_command_side()?;
        self.needs_event(&inputs)
    }
}
