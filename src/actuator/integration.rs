//! The actuator as a hybrid system for ODE solvers: states, modes, derivatives, event indicators.
//!
//! ```text
//! states      x, δ, δ̇, and the memory of the output effects
//! ẋ = p (k_t c - x)      (order 2: x = k_t c, and the state is constant)
//! δ̇, δ̈                   of the drive in its mode (motion/integration.rs)
//! ```
//!
//! Modes are selected by [`Actuator::select_modes`] at events and constant between them. An event indicator is positive while a
//! condition of the mode holds and changes its sign where the mode ends.

use serde::{Deserialize, Serialize};

use super::{
    constants::{Actuator, OutputEffect},
    signals::Failure,
    state::State,
};
use crate::{
    command::EffectInputs,
    effects::{EVENT_EFFECTS, INTEGRATED, MEMORY, UNLIMITED},
    motion::{DriveMode, DriveOperation, DriveState, InstantaneousForcing, LoopTerms},
    operator::{EventCondition, Piece, Signal},
    parameters::Order,
    transition::Ramp,
};

/// Modes of the drive and of the effects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Modes {
    drive: DriveMode,
    failure: Failure,
    /// For every effect with events, active or not.
    conditions: [EventCondition; EVENT_EFFECTS],
}

impl Modes {
    /// The failure for which the modes were selected.
    #[must_use]
    pub fn failure(&self) -> Failure {
        self.failure
    }
}

/// Inputs at an instant, with the command evaluated through the command side.
#[derive(Debug, Clone)]
pub struct EvaluatedInputs {
    /// Output of the command side [deg].
    command: f64,
    /// Its derivative, 0 where unknown [deg/s].
    slope: f64,
    /// Inputs of its effects.
    of_effects: EffectInputs,
    /// Memory of its effects.
    memory: [f64; MEMORY],
    /// The piece of the command that led here, with its start [s].
    piece: (f64, Piece),
    /// Hinge load [deg] and its derivative, 0 where unknown.
    load: Ramp,
}

/// Derivatives of the continuous states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateDerivatives {
    /// ẋ [deg/s]
    pub pole: f64,
    /// [deg/s]
    pub position: f64,
    /// [deg/s²]
    pub rate: f64,
    /// Of the memory of the output effects.
    pub memory: [f64; INTEGRATED],
}

/// Index of the first entry of the memory that belongs to output effects.
pub(crate) const FIRST_INTEGRATED: usize = MEMORY - INTEGRATED;

impl Actuator {
    /// Number of event indicators.
    pub const EVENT_INDICATORS: usize = LoopTerms::EVENT_INDICATORS + 2 * EVENT_EFFECTS;

    /// Evaluates the command side along a linear command piece that starts at `from` \[s\], the time to which the memory in the state refers.
    /// History knots from `until` \[s\] on are not reached yet.
    #[must_use]
    pub fn evaluate_inputs(
        &self,
        state: &State,
        (from, until): (f64, f64),
        command: Piece,
        load: Ramp,
    ) -> EvaluatedInputs {
        let (mut memory, mut of_effects) = (state.memory, EffectInputs::default());
        let reached = self.command.evaluate(&state.history, &mut memory, (from, until), command, &mut of_effects);
        let piece = (from, command);
        EvaluatedInputs { command: reached.value, slope: reached.slope, of_effects, memory, piece, load }
    }

    /// Stores the memory of the command side and the past command in the state.
    pub fn store_command_history(&self, state: &mut State, inputs: &EvaluatedInputs) {
        state.memory[..FIRST_INTEGRATED].copy_from_slice(&inputs.memory[..FIRST_INTEGRATED]);
        let (from, piece) = inputs.piece;
        self.command.forget(&mut state.history, from);
        self.command.record(&mut state.history, from, piece);
    }

    /// Delay of the command \[s\].
    #[must_use]
    pub fn delay(&self) -> f64 {
        self.command.delay
    }

    /// Forcing of the drive in this state.
    fn forcing(&self, state: &State, failure: Failure, inputs: &EvaluatedInputs) -> InstantaneousForcing {
        let terms = &self.terms;
        let demand = self.command.demand_at(inputs.command, state.time);
        let (pole, slope) = match self.order {
            Order::Third => (state.pole, self.base.p() * (demand - state.pole)),
            Order::Second => (demand, self.command.demand_at(inputs.slope, state.time)),
        };
        let Ramp { value: load, slope: load_slope } = inputs.load;
        let active = |target: f64, slope: f64| InstantaneousForcing {
            target,
            load,
            slopes: [slope, load_slope],
            operation: DriveOperation::Active,
        };
        match failure {
            Failure::None => active(pole, slope),
            Failure::Passive => InstantaneousForcing { operation: DriveOperation::Passive, ..active(pole, slope) },
            Failure::Stuck => InstantaneousForcing { operation: DriveOperation::Stuck, ..active(pole, slope) },
            Failure::HardoverPositive => active(terms.max.min(UNLIMITED), 0.0),
            Failure::HardoverNegative => active(terms.min.max(-UNLIMITED), 0.0),
        }
    }

    /// Selects the modes after an event and projects the state onto them.
    #[must_use]
    pub fn select_modes(
        &self,
        state: &mut State,
        before: Option<&Modes>,
        failure: Failure,
        inputs: &EvaluatedInputs,
    ) -> Modes {
        let forcing = self.forcing(state, failure, inputs);
        let from = DriveState { position: state.position, rate: state.rate };
        let (point, drive) = self.terms.select_mode(before.map(|modes| modes.drive), from, forcing);
        (state.position, state.rate, state.saturated) = (point.position, point.rate, drive.is_saturated());
        let mut conditions = [EventCondition::None; EVENT_EFFECTS];
        self.command.event_conditions(&inputs.memory, &inputs.of_effects, &mut conditions);
        let [slope, _] = self.terms.derivatives(drive, point, forcing);
        let mut signal = Signal { value: state.position, slope };
        for effect in &self.output_effects {
            let memory = &mut state.memory[effect.memory..];
            let condition = effect.operator.event_condition(&effect.parameters, memory, signal);
            let slope = effect.operator.slope(&effect.parameters, memory, signal, condition);
            signal = Signal { value: effect.operator.value(&effect.parameters, memory, signal.value), slope };
            conditions[effect.condition_index] = condition;
        }
        Modes { drive, failure, conditions }
    }

    /// Derivatives of the continuous states in these modes.
    #[must_use]
    pub fn derivatives(&self, state: &State, modes: &Modes, inputs: &EvaluatedInputs) -> StateDerivatives {
        let pole = match self.order {
            Order::Third => self.base.p() * (self.command.demand_at(inputs.command, state.time) - state.pole),
            Order::Second => 0.0,
        };
        let mut memory = [0.0; MEMORY];
        let [position, rate] = self.visit_output_effects(state, modes, inputs, |effect, input, _, condition| {
            let into = &mut memory[effect.memory..];
            effect.operator.memory_derivatives(
                &effect.parameters,
                &state.memory[effect.memory..],
                input,
                condition,
                into,
            );
        });
        let mut rates = StateDerivatives { pole, position, rate, memory: [0.0; INTEGRATED] };
        rates.memory.copy_from_slice(&memory[FIRST_INTEGRATED..]);
        rates
    }

    /// Event indicators: distances from the ends of the conditions of these modes.
    #[must_use]
    pub fn event_indicators(
        &self,
        state: &State,
        modes: &Modes,
        inputs: &EvaluatedInputs,
    ) -> [f64; Self::EVENT_INDICATORS] {
        let mut indicators = [1.0; Self::EVENT_INDICATORS];
        let (drive, effects) = indicators.split_at_mut(LoopTerms::EVENT_INDICATORS);
        let point = DriveState { position: state.position, rate: state.rate };
        drive.copy_from_slice(&self.terms.event_indicators(
            modes.drive,
            point,
            self.forcing(state, modes.failure, inputs),
        ));
        self.command.event_indicators(&modes.conditions, &inputs.of_effects, inputs.command, effects);
        self.visit_output_effects(state, modes, inputs, |effect, input, output, condition| {
            effects[2 * effect.condition_index..][..2].copy_from_slice(&condition.event_indicators(input, output));
        });
        indicators
    }

    /// Visits the output effects in their order, each with its input, output and condition; returns the derivatives of the drive.
    fn visit_output_effects(
        &self,
        state: &State,
        modes: &Modes,
        inputs: &EvaluatedInputs,
        mut visit: impl FnMut(&OutputEffect, Signal, f64, EventCondition),
    ) -> [f64; 2] {
        let point = DriveState { position: state.position, rate: state.rate };
        let rates = self.terms.derivatives(modes.drive, point, self.forcing(state, modes.failure, inputs));
        let mut signal = Signal { value: state.position, slope: rates[0] };
        for effect in &self.output_effects {
            let (memory, condition) = (&state.memory[effect.memory..], modes.conditions[effect.condition_index]);
            let value = effect.operator.value(&effect.parameters, memory, signal.value);
            visit(effect, signal, value, condition);
            signal = Signal { value, slope: effect.operator.slope(&effect.parameters, memory, signal, condition) };
        }
        rates
    }

    /// True where a command effect gained or lost its condition: a reversal of the command, which no event indicator shows.
    #[must_use]
    pub fn has_command_reversal(&self, modes: &Modes, inputs: &EvaluatedInputs) -> bool {
        let mut conditions = [EventCondition::None; EVENT_EFFECTS];
        self.command.event_conditions(&inputs.memory, &inputs.of_effects, &mut conditions);
        let is_absent = |condition: &EventCondition| *condition == EventCondition::None;
        self.command
            .condition_indices()
            .any(|index| is_absent(&conditions[index]) != is_absent(&modes.conditions[index]))
    }
}
