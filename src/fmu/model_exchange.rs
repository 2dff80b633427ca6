//! Model exchange: the host integrates. States are x, δ, δ̇ and the memory of the output effects; modes are selected at events.
//!
//! The command side interpolates the command linearly between two instants at which the host completes an integrator step or
//! enters event mode: exact for commands of steps and ramps whose breakpoints are input events, an error of h² c̈ / 8 for a smooth
//! command and accepted steps h. The delay stores these pieces. A breakpoint of the command is a time event where the delay ends.

use fmi_export::{Error, EventUpdate, Result, Value};

use super::{
    actuator_model::ActuatorModel, model_exchange_state::ModelExchangeState, settings::failure, variables::Slot,
};
use crate::{
    actuator::{Actuator, EvaluatedInputs, FIRST_INTEGRATED, State, StateDerivatives},
    effects::{CHAIN, INTEGRATED},
    operator::Piece,
    parameters::PositionUnit,
    transition::Ramp,
};

/// Number of continuous states of the drive: x, δ, δ̇.
pub const INTEGRATED_STATES: usize = 3;

/// Number of continuous states: those of the drive and the memory of the output effects.
pub const STATES: usize = INTEGRATED_STATES + INTEGRATED;

impl ActuatorModel {
    /// Selects the first modes, at the end of initialization, for an actuator at rest.
    pub(super) fn first_modes(&self, actuator: &Actuator, state: &mut State) -> ModelExchangeState {
        let ([command, load], failure) = (self.inputs().map(Ramp::held), failure(self.memory.failure));
        let piece = Piece { value: command.value, slope: 0.0, length: 0.0, time_resolution: 0.0 };
        // The first command is a step from the command at rest.
        let breakpoints = if actuator.delay() > 0.0 { vec![state.time] } else { Vec::new() };
        let until = breakpoints.first().copied().unwrap_or(f64::INFINITY);
        let inputs = actuator.evaluate_inputs(state, (state.time, until), piece, load);
        let modes = actuator.select_modes(state, None, failure, &inputs);
        ModelExchangeState {
            reference: state.time,
            command,
            load,
            is_breakpoint: false,
            breakpoints,
            unconfirmed: None,
            is_requested: false,
            has_jumped: false,
            modes,
        }
    }

    /// Actuator, state and modes with the inputs evaluated at the time of the state.
    fn evaluated(&self) -> Result<(&Actuator, &State, &ModelExchangeState, EvaluatedInputs)> {
        let (actuator, state) = self.initialized()?;
        let exchange = self.memory.exchange.as_ref();
        let exchange = exchange.ok_or_else(|| Error::new("instance", "co-simulation", "model exchange"))?;
        let inputs = exchange.evaluate_inputs(actuator, state, self.inputs());
        Ok((actuator, state, exchange, inputs))
    }

    /// Derivatives of the states; in co-simulation and initialization mode, in the modes selected for the present state.
    pub(super) fn derivatives(&self) -> Result<StateDerivatives> {
        if self.memory.exchange.is_some() {
            let (actuator, state, exchange, inputs) = self.evaluated()?;
            return Ok(actuator.derivatives(state, &exchange.modes, &inputs));
        }
        let initial;
        let (actuator, mut state) = if let Ok((actuator, state)) = self.initialized() {
            (actuator, state.clone())
        } else {
            initial = self.memory.settings.actuator()?;
            (&initial, initial.at_rest(self.memory.settings.initial_position))
        };
        let [command, load] = self.inputs().map(Ramp::held);
        let piece = Piece { value: command.value, slope: 0.0, length: 0.0, time_resolution: 0.0 };
        let inputs = actuator.evaluate_inputs(&state, (state.time, f64::INFINITY), piece, load);
        let modes = actuator.select_modes(&mut state, None, failure(self.memory.failure), &inputs);
        Ok(actuator.derivatives(&state, &modes, &inputs))
    }

    /// Sets the time of the host.
    pub(super) fn write_time(&mut self, time: f64) {
        let since_start = time - self.memory.start_time;
        if let Some(state) = &mut self.memory.state {
            state.time = since_start;
        }
    }

    /// Writes the continuous states.
    pub(super) fn write_states(&self, into: &mut [f64]) {
        let rest;
        let state = if let Some(state) = &self.memory.state {
            state
        } else if let Ok(actuator) = self.memory.settings.actuator() {
            rest = actuator.at_rest(self.memory.settings.initial_position);
            &rest
        } else {
            // Parameters may not be consistent yet.
            return into.fill(0.0);
        };
        into[..3].copy_from_slice(&[state.pole, state.position, state.rate]);
        into[3..].copy_from_slice(&state.memory[FIRST_INTEGRATED..]);
    }

    /// Reads the continuous states.
    pub(super) fn read_states(&mut self, states: &[f64]) {
        if let Some(state) = &mut self.memory.state {
            (state.pole, state.position, state.rate) = (states[0], states[1], states[2]);
            state.memory[FIRST_INTEGRATED..].copy_from_slice(&states[3..]);
        }
    }

    /// Writes the derivatives of the continuous states.
    pub(super) fn write_derivatives(&self, into: &mut [f64]) -> Result<()> {
        let StateDerivatives { pole, position, rate, memory } = self.derivatives()?;
        into[..3].copy_from_slice(&[pole, position, rate]);
        into[3..].copy_from_slice(&memory);
        Ok(())
    }

    /// Writes the event indicators.
    pub(super) fn write_event_indicators(&self, into: &mut [f64]) -> Result<()> {
        if self.memory.state.is_none() {
            into.fill(1.0);
            return Ok(());
        }
        let (actuator, state, exchange, inputs) = self.evaluated()?;
        into.copy_from_slice(&actuator.event_indicators(state, &exchange.modes, &inputs));
        Ok(())
    }

    /// Advances the command side to the time of the host.
    pub(super) fn advance_command_side(&mut self) -> Result<EvaluatedInputs> {
        let (_, state, exchange, inputs) = self.evaluated()?;
        let (time, values, has_moved) = (state.time, self.inputs(), state.time > exchange.reference);
        if let (true, Some(actuator), Some(state)) = (has_moved, &self.actuator, &mut self.memory.state) {
            actuator.store_command_history(state, &inputs);
        }
        if let Some(exchange) = &mut self.memory.exchange {
            exchange.advance(time, values);
        }
        Ok(inputs)
    }

    /// Enters event mode: records whether the event was requested.
    pub(super) fn begin_event(&mut self) -> Result<()> {
        let inputs = self.advance_command_side()?;
        let is_requested = self.needs_event(&inputs)?;
        let (actuator, state) = self.initialized()?;
        let (now, delay) = (state.time, actuator.delay());
        if let Some(exchange) = &mut self.memory.exchange {
            exchange.is_requested = is_requested || exchange.is_due(now, delay);
        }
        Ok(())
    }

    /// True if a condition of the modes no longer holds, even if no event indicator changed sign during the step, or if a failure was set
    /// since the last event.
    pub(super) fn needs_event(&self, inputs: &EvaluatedInputs) -> Result<bool> {
        let (actuator, state, exchange, _) = self.evaluated()?;
        let indicators = actuator.event_indicators(state, &exchange.modes, inputs);
        Ok(indicators.iter().any(|indicator| *indicator < 0.0)
            || exchange.modes.failure() != failure(self.memory.failure)
            || actuator.has_command_reversal(&exchange.modes, inputs))
    }

    /// Command and load as set by the host [deg].
    fn inputs(&self) -> [f64; 2] {
        [self.memory.command.value(), self.memory.load.value()]
    }

    /// The host sets an input in event mode.
    pub(super) fn mark_breakpoint(&mut self, slot: Slot, value: Value) {
        match (slot, value, &mut self.memory.exchange) {
            (Slot::Command, Value::Real(value), Some(exchange)) => exchange.set_command(value),
            (Slot::Load, Value::Real(value), Some(exchange)) => exchange.set_load(value),
            _ => {}
        }
    }

    /// Event iteration: selects the modes; reports changes of the continuous states and the time of the next event.
    pub(super) fn update_discrete_states(&mut self) -> Result<EventUpdate> {
        let (has_changed, next_event) = self.update_modes()?;
        let has_jumped = self.memory.exchange.as_mut().is_some_and(|exchange| std::mem::take(&mut exchange.has_jumped));
        Ok(EventUpdate { needs_another: false, states_changed: has_changed || has_jumped, next_event })
    }

    /// Selects the modes; returns whether continuous states change, and the time of the next event.
    pub(super) fn update_modes(&mut self) -> Result<(bool, Option<f64>)> {
        self.advance_command_side()?;
        self.evaluated()?;
        let (before, values) = (self.continuous_states(), self.inputs());
        let taken = (&self.actuator, self.memory.state.take(), self.memory.exchange.take());
        let (Some(actuator), Some(mut state), Some(mut exchange)) = taken else { return Ok((false, None)) };
        let (now, delay) = (state.time, actuator.delay());
        (exchange.command.value, exchange.load.value) = (values[0], values[1]);
        if delay == 0.0 {
            (exchange.breakpoints, exchange.unconfirmed) = (Vec::new(), None);
        } else if exchange.is_breakpoint && exchange.breakpoints.last() != Some(&now) {
            exchange.breakpoints.push(now);
        }
        exchange.is_breakpoint = false;
        while exchange.is_due(now, delay) {
            let breakpoint = exchange.breakpoints.remove(0);
            // The host may stop one rounding earlier.
            state.history.move_knots(breakpoint, breakpoint.min(now - delay));
        }
        let inputs = exchange.evaluate_inputs(actuator, &state, values);
        let failure = failure(self.memory.failure);
        exchange.modes = actuator.select_modes(&mut state, Some(&exchange.modes), failure, &inputs);
        let next_event = exchange.breakpoints.first().map(|breakpoint| self.memory.start_time + breakpoint + delay);
        (self.memory.state, self.memory.exchange) = (Some(state), Some(exchange));
        Ok((before != self.continuous_states(), next_event))
    }

    /// The continuous states now.
    pub(super) fn continuous_states(&self) -> [f64; STATES] {
        let mut states = [0.0; STATES];
        self.write_states(&mut states);
        states
    }
}

/// Nominal values of the continuous states, all of which are positions or rates, with positions in `unit`.
pub(super) fn nominals(into: &mut [f64], unit: PositionUnit) {
    into[..3].copy_from_slice(&[1.0, 1.0, 100.0]);
    let of_effects = CHAIN.iter().flat_map(|effect| effect.state_variables());
    into[3..].iter_mut().zip(of_effects).for_each(|(nominal, (_, state_variable))| *nominal = state_variable.nominal);
    into.iter_mut().for_each(|nominal| *nominal *= unit.typical());
}
