//! The interface to [`fmi_export`]: start values, variables, memory, steps.
//!
//! Between communication points an input is held at the value it was set to; if its derivative was set, it is linear from that value
//! on, until the input or its derivative is set again. Setting only the value means: held from here.

use fmi_export::{Error, EventUpdate, Kind, Model, Phase, Request, Result, Value};

use super::{
    actuator_model::ActuatorModel,
    guid::guid,
    identifier::{MODEL_IDENTIFIER, MODEL_RESOURCE},
    memory::{LastStep, Memory},
    model_exchange,
    start::Start,
    variables::{Slot, Variable, variables},
};
use crate::{
    actuator::{Actuator, Failure},
    parameters,
};

/// Start values of the model with this GUID: the default ones, or those of the model file in the resources.
fn start_values(request: &Request) -> Result<Start> {
    let own = Start::default();
    let wanted = request.guid.as_deref().ok_or_else(|| Error::new("fmuGUID", "NULL", guid(&own)))?;
    if wanted == guid(&own) {
        return Ok(own);
    }
    let remedy = "take binary and modelDescription.xml from the same FMU";
    let refuse = |found: String| crate::error::Error::new("fmuGUID", found, guid(&own)).remedy(remedy);
    let folder = request.resource_folder().ok_or_else(|| refuse(format!("{wanted} and no fmuResourceLocation")))?;
    let file = folder.join(MODEL_RESOURCE);
    let text =
        std::fs::read_to_string(&file).map_err(|error| refuse(format!("{wanted}, and {}: {error}", file.display())))?;
    let start = Start::from_model(&parameters::Model::parse(&text).map_err(|error| error.at(&file, None))?);
    if guid(&start) == wanted {
        return Ok(start);
    }
    let allowed = format!("{} or {}", guid(&own), guid(&start));
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

    fn variables() -> &'static [Variable] {
        variables()
    }

    fn get(&self, slot: Slot, _now: Phase) -> Result<Value> {
        self.value(slot)
    }

    fn set(&mut self, slot: Slot, value: Value) {
        self.memory.assign(slot, value);
    }

    fn set_all(&mut self, items: impl Iterator<Item = (Slot, Value)> + Clone, now: Phase) -> Result<()> {
        self.assign(items, now)
    }

    fn memory(&self) -> &Memory {
        &self.memory
    }

    fn restore(&mut self, memory: Memory, now: Phase) -> Result<()> {
        // The actuator follows from the settings. Masters that repeat steps restore the same settings every time.
        let unchanged = self.actuator.is_some() && memory.settings == self.memory.settings;
        if !now.is_initialized() {
            self.actuator = None;
        } else if !unchanged {
            self.actuator = Some(memory.settings.actuator()?);
            self.workspace.clear();
        }
        self.memory = memory;
        Ok(())
    }

    fn check(memory: &Memory, kind: Kind, now: Phase) -> Result<()> {
        memory.check(kind, now.is_initialized())
    }

    /// Refuses a selection without data in the report, inconsistent parameters of an effect, an initial position beyond a stop.
    fn initialize(&mut self, time: f64) -> Result<()> {
        let actuator = self.memory.settings.actuator()?;
        let initial = self.memory.settings.initial_position;
        let (min, max) = actuator.stops();
        if !(min..=max).contains(&initial) {
            let unit = self.unit;
            let allowed = format!("{min} to {max} {unit}, the position_limit");
            return Err(Error::new("initial_position", format!("{initial} {unit}"), allowed));
        }
        self.memory.start_time = time;
        self.memory.state = Some(actuator.at_rest(initial));
        self.workspace.clear();
        self.actuator = Some(actuator);
        if self.kind == Kind::ModelExchange { self.start_model_exchange() } else { Ok(()) }
    }

    fn partial_derivative(&self, unknown: &'static Variable, known: &'static Variable, now: Phase) -> Result<f64> {
        self.by_step(unknown, known, now)
    }

    fn step(&mut self, time: f64, duration: f64) -> Result<()> {
        let memory = &mut self.memory;
        let (Some(actuator), Some(before)) = (&self.actuator, memory.state.as_ref()) else {
            return self.initialized().map(|_| ());
        };
        let inputs = memory.inputs();
        if ![inputs.command.at(duration), inputs.load.at(duration)].iter().all(|value| value.is_finite()) {
            return Err(Error::new("inputs at the end of this step", format!("{inputs:?}"), "finite numbers"));
        }
        let mut state = before.clone();
        state.time = time - memory.start_time;
        actuator.step(&mut state, &mut self.workspace, inputs, duration)?;
        let before = memory.state.replace(state).filter(|_| !actuator.is_linear() || inputs.failure != Failure::None);
        memory.command.advance(duration);
        memory.load.advance(duration);
        memory.last_step = Some(LastStep { duration, inputs, before });
        Ok(())
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
        self.advance_command_side().map(drop)
    }

    fn new_discrete_states(&mut self) -> Result<EventUpdate> {
        self.update_discrete_states()
    }

    fn completed_integrator_step(&mut self) -> Result<bool> {
        let inputs = self.advance_command_side()?;
        self.needs_event(&inputs)
    }
}
