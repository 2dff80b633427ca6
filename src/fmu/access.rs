//! Variables: getting, setting, derivatives.

use fmi_export::{Error, Kind, Phase, Result, Value};

use super::{
    actuator_model::ActuatorModel,
    last_step::{LastStep, StepRecord},
    memory::{Memory, SettingsVersion, is_parameter},
    model_exchange::STATES,
    settings::Settings,
    start_values::start_value,
    variables::{Causality, Kind as Type, Slot, Variable},
};
use crate::{
    actuator::{Actuator, Inputs, Outputs, State, Workspace},
    command::Change,
    transition::Ramp,
};

/// Half the distance of a central difference over a step, relative to the input (at least a typical one, 1 deg). Between two events the
/// motion is linear in its inputs except for the cubic spring, so that the truncation error is negligible.
const DIFFERENCE: f64 = 1e-4;

/// Minimum step length [s] that is recorded over a delay without allocation.
const SHORTEST_STEP_S: f64 = 1e-4;

/// Reserves capacity for the command history. Memory that is never written is not committed.
pub(super) fn reserve_history(actuator: &Actuator, state: &mut State) {
    if actuator.delay() > 0.0 {
        state.history.reserve((actuator.delay() / SHORTEST_STEP_S) as usize + 16);
    }
}

/// Equal to the last bit.
fn is_same(one: Value, other: Value) -> bool {
    match (one, other) {
        (Value::Real(one), Value::Real(other)) => one.to_bits() == other.to_bits(),
        _ => one == other,
    }
}

impl ActuatorModel {
    /// Value of a variable.
    #[inline]
    pub(super) fn value(&self, slot: Slot) -> Result<Value> {
        if let (Some(actuator), Some(state)) = (&self.actuator, &self.memory.state) {
            match slot {
                Slot::Position | Slot::Deflection if !actuator.acts_behind_drive() => {
                    return Ok(Value::Real(state.position));
                }
                Slot::Rate => return Ok(Value::Real(state.rate)),
                _ => {}
            }
        }
        self.evaluated_value(slot)
    }

    #[inline(never)]
    fn evaluated_value(&self, slot: Slot) -> Result<Value> {
        match slot {
            Slot::Position => self.outputs().map(|outputs| Value::Real(outputs.position)),
            Slot::Deflection => self.outputs().map(|outputs| Value::Real(outputs.deflection)),
            Slot::Rate => self.outputs().map(|outputs| Value::Real(outputs.rate)),
            Slot::Saturated => self.outputs().map(|outputs| Value::Boolean(outputs.saturated)),
            _ => self.value_but_outputs(slot),
        }
    }

    fn value_but_outputs(&self, slot: Slot) -> Result<Value> {
        Ok(match slot {
            Slot::Command => Value::Real(self.memory.command.value()),
            Slot::Load => Value::Real(self.memory.load.value()),
            Slot::Failure => Value::Integer(self.memory.failure),
            Slot::Active(index) => Value::Real(self.memory.settings.base()?.values()[index]),
            Slot::State(index) => {
                let mut states = [0.0; STATES];
                self.write_states(&mut states);
                Value::Real(states[index])
            }
            Slot::Slope(index) => {
                let mut derivatives = [0.0; STATES];
                self.write_derivatives(&mut derivatives)?;
                Value::Real(derivatives[index])
            }
            _ => start_value(slot, &self.memory.settings)
                .ok_or_else(|| Error::new("variable", format!("{slot:?}"), "one with a value"))?,
        })
    }

    fn outputs(&self) -> Result<Outputs> {
        // In model exchange the host changes the state before it requests values.
        if self.kind == Kind::ModelExchange {
            return self.computed_outputs();
        }
        if let Some(outputs) = self.outputs.get() {
            return Ok(outputs);
        }
        let outputs = self.computed_outputs()?;
        self.outputs.set(Some(outputs));
        Ok(outputs)
    }

    fn computed_outputs(&self) -> Result<Outputs> {
        if self.memory.state.is_some() {
            let (actuator, state) = self.initialized()?;
            return Ok(actuator.outputs(state));
        }
        let settings = &self.memory.settings;
        let actuator = settings.actuator()?;
        Ok(actuator.outputs(&actuator.at_rest(settings.initial_position)))
    }

    /// Sets all variables or none.
    pub(super) fn assign(&mut self, items: impl Iterator<Item = (Slot, Value)> + Clone, now: Phase) -> Result<()> {
        if now == Phase::EventMode || items.clone().any(|(slot, _)| is_parameter(slot)) {
            return self.assign_at_event(items, now);
        }
        items.for_each(|(slot, value)| self.memory.assign(slot, value));
        Ok(())
    }

    /// As above for one.
    #[inline(never)]
    pub(super) fn assign_one(&mut self, slot: Slot, value: Value, now: Phase) -> Result<()> {
        self.assign(std::iter::once((slot, value)), now)
    }

    /// As above with parameters among them, and in event mode.
    fn assign_at_event(&mut self, items: impl Iterator<Item = (Slot, Value)> + Clone, now: Phase) -> Result<()> {
        let is_change = |(slot, value): (Slot, Value)| {
            is_parameter(slot)
                && start_value(slot, &self.memory.settings).is_none_or(|present| !is_same(present, value))
        };
        if items.clone().any(is_change) {
            self.outputs.set(None);
            if now.is_initialized() {
                let mut memory = Memory::new(&self.memory.settings);
                items.clone().for_each(|(slot, value)| memory.assign(slot, value));
                self.change_settings(memory.settings)?;
            }
            items.clone().for_each(|(slot, value)| self.memory.assign(slot, value));
        }
        if now == Phase::EventMode {
            items.clone().for_each(|(slot, value)| self.mark_breakpoint(slot, value));
        }
        let inputs = items.filter(|(slot, _)| !is_parameter(*slot));
        inputs.for_each(|(slot, value)| self.memory.assign(slot, value));
        Ok(())
    }

    /// The actuator for a memory that is about to be restored.
    #[inline(never)]
    pub(super) fn restore_actuator(&mut self, memory: &Memory, now: Phase) -> Result<()> {
        self.actuator = if now.is_initialized() { Some(memory.settings.actuator()?) } else { None };
        self.workspace.clear();
        Ok(())
    }

    /// Replaces the parameters during a simulation.
    fn change_settings(&mut self, settings: Settings) -> Result<()> {
        let actuator = settings.actuator()?;
        let states = self.continuous_states();
        if let (Some(before), Some(state)) = (&self.actuator, &mut self.memory.state) {
            actuator.transfer_state(state, before, self.memory.command.value());
            reserve_history(&actuator, state);
            if (actuator.delay() > 0.0) != (before.delay() > 0.0)
                && let LastStep::WithEffects(last) = &mut self.memory.last_step
            {
                last.change = Change::None;
            }
        }
        (self.memory.settings, self.memory.version) = (settings, SettingsVersion::new());
        self.actuator = Some(actuator);
        self.workspace.clear();
        if self.memory.exchange.is_some() {
            self.update_modes()?;
            let has_jumped = states != self.continuous_states();
            self.memory.exchange.iter_mut().for_each(|exchange| exchange.has_jumped |= has_jumped);
        }
        Ok(())
    }

    /// Sets the derivatives of all inputs or none.
    pub(super) fn set_slopes(&mut self, items: &[(&'static Variable, i32, f64)]) -> Result<()> {
        for (variable, order, value) in items {
            let name = &variable.name;
            if !matches!(variable.slot, Slot::Command | Slot::Load) {
                return Err(Error::new("input derivative", format!("`{name}`"), "`command`, `load`"));
            }
            if *order != 1 {
                return Err(Error::new(format!("order of the derivative of `{name}`"), order.to_string(), "1"));
            }
            if !value.is_finite() {
                return Err(Error::new(format!("derivative of `{name}`"), value.to_string(), "finite numbers"));
            }
        }
        for (variable, _, value) in items {
            match variable.slot {
                Slot::Load => self.memory.load.set_slope(*value),
                _ => self.memory.command.set_slope(*value),
            }
        }
        Ok(())
    }

    /// First derivative of an output.
    pub(super) fn slope(&self, variable: &Variable, order: i32) -> Result<f64> {
        if order != 1 {
            return Err(Error::new(format!("order of the derivative of `{}`", variable.name), order.to_string(), "1"));
        }
        let index = match variable.slot {
            Slot::Position => 0,
            Slot::Deflection => 1,
            Slot::Rate => 2,
            _ => {
                let found = format!("`{}`", variable.name);
                return Err(Error::new("output derivative", found, "`position`, `deflection`, `rate`"));
            }
        };
        let (actuator, state) = self.initialized()?;
        Ok(actuator.slopes(state, self.memory.inputs())?[index])
    }

    /// Partial derivative: in initialization mode of calculated parameters with respect to parameters, afterwards of outputs with respect
    /// to inputs over the last step (the function f_doStep of section 4.1 of the standard).
    pub(super) fn by_step(&self, unknown: &Variable, known: &Variable, now: Phase) -> Result<f64> {
        let initializing = now == Phase::Initialization;
        let exchanges = self.kind == Kind::ModelExchange;
        let is_unknown = match unknown.causality {
            Causality::Output => matches!(unknown.kind, Type::Real { .. }),
            Causality::Local => initializing || exchanges && matches!(unknown.slot, Slot::Slope(_)),
            Causality::CalculatedParameter => initializing,
            _ => false,
        };
        if !is_unknown {
            let allowed =
                "a Real output, in model exchange a derivative, in initialization mode a calculated parameter";
            return Err(Error::new("unknown of a directional derivative", format!("`{}`", unknown.name), allowed));
        }
        let is_real = matches!(known.kind, Type::Real { .. });
        let is_known = known.causality == Causality::Input
            || initializing && known.causality == Causality::Parameter
            || !initializing && matches!(known.slot, Slot::State(_));
        if !(is_real && is_known) {
            let allowed = "`command`, `load`, a continuous state, or in initialization mode a Real parameter";
            return Err(Error::new("known of a directional derivative", format!("`{}`", known.name), allowed));
        }
        if initializing {
            return self.initial_derivative(unknown.slot, known.slot);
        }
        if exchanges || matches!(known.slot, Slot::State(_)) {
            return self.at_instant(unknown.slot, known.slot);
        }
        let Some((duration, inputs)) = self.memory.last_step.inputs() else { return Ok(0.0) };
        let (actuator, state) = self.initialized()?;
        match &self.memory.last_step {
            LastStep::WithEffects(StepRecord { before, change, .. }) => {
                let mut before = before.clone();
                before.history.clone_from(&state.history);
                before.history.undo(*change);
                self.by_input(actuator, &before, (duration, inputs), unknown.slot, known.slot)
            }
            _ if known.slot == Slot::Command => {
                let (position, rate) = actuator.by_command(duration);
                Ok(if unknown.slot == Slot::Rate { rate } else { position })
            }
            // Without effects the step is linear, so that the derivative is the same from rest.
            _ => self.by_input(actuator, &actuator.at_rest(0.0), (duration, inputs), unknown.slot, known.slot),
        }
    }

    /// Closed form if the dependence on the parameter is linear, otherwise a difference quotient.
    fn initial_derivative(&self, unknown: Slot, known: Slot) -> Result<f64> {
        let settings = &self.memory.settings;
        match (unknown, known) {
            (Slot::Active(one), Slot::Custom(other)) => Ok(f64::from(one == other && settings.is_custom())),
            (Slot::Position | Slot::Deflection, Slot::InitialPosition) => {
                let actuator = settings.actuator()?;
                let [position, deflection] = actuator.by_initial_position(settings.initial_position);
                Ok(if unknown == Slot::Position { position } else { deflection })
            }
            (Slot::Position, Slot::Effect(_)) | (Slot::State(_) | Slot::Slope(_), _) => {
                self.by_start_value(unknown, known)
            }
            _ => Ok(0.0),
        }
    }

    /// Difference quotient with respect to a start value: central, or one-sided at a bound.
    fn by_start_value(&self, unknown: Slot, known: Slot) -> Result<f64> {
        let Value::Real(here) = self.value(known)? else { return Ok(0.0) };
        let shifted = |by: f64| -> Result<f64> {
            let mut memory = self.memory.clone();
            memory.assign(known, Value::Real(here + by));
            let model = ActuatorModel::with_memory(Kind::CoSimulation, self.unit, memory);
            match model.value(unknown)? {
                Value::Real(value) => Ok(value),
                other => Err(Error::new("unknown of a directional derivative", other.kind(), "a Real")),
            }
        };
        let by = DIFFERENCE * here.abs().max(1.0);
        let (above, below, here) = (shifted(by), shifted(-by), shifted(0.0)?);
        match (above, below) {
            (Ok(above), Ok(below)) => Ok((above - below) / (2.0 * by)),
            (Ok(above), Err(_)) => Ok((above - here) / by),
            (Err(_), Ok(below)) => Ok((here - below) / by),
            (Err(error), Err(_)) => Err(error),
        }
    }

    /// Central difference of an output at the end of the last step with respect to an input during it.
    fn by_input(
        &self,
        actuator: &Actuator,
        before: &State,
        (duration, inputs): (f64, Inputs),
        unknown: Slot,
        known: Slot,
    ) -> Result<f64> {
        let change = |ramp: &mut Ramp, share: f64| {
            let by = DIFFERENCE * ramp.value.abs().max(self.unit.typical());
            ramp.value += share * by;
            by
        };
        let run = |share: f64| -> Result<(f64, f64)> {
            let mut inputs = inputs;
            let by =
                if known == Slot::Load { change(&mut inputs.load, share) } else { change(&mut inputs.command, share) };
            let mut state = before.clone();
            actuator.step(&mut state, &mut Workspace::default(), inputs, duration)?;
            let Outputs { position, deflection, rate, .. } = actuator.outputs(&state);
            Ok(match unknown {
                Slot::Rate => (rate, by),
                Slot::Deflection => (deflection, by),
                _ => (position, by),
            })
        };
        let ((above, by), (below, _)) = (run(1.0)?, run(-1.0)?);
        Ok((above - below) / (2.0 * by))
    }
}
