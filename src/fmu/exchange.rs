//! Model exchange: the host integrates. States are x, δ, δ̇ and the memory of the effects behind the drive; modes are chosen at
//! events.
//!
//! The command is what the host says it is now. Between two instants at which the host calls a step completed, or an event,
//! the command side takes it to be straight: exact for commands made of steps and ramps whose corners are input events,
//! and an error of h² c̈ / 8 for a smooth command and accepted steps h. The delay keeps these pieces. Corners of the command are
//! time events when they come out of the delay.

use fmi_export::{Discrete, Error, Result};
use serde::{Deserialize, Serialize};

use super::{Unit, settings::failure, variables::Slot};
use crate::{
    actuator::{Actuator, FIRST_INTEGRATED, Modes, Rates, State, Surroundings},
    effects::{CHAIN, INTEGRATED},
    operator::Piece,
    transition::Ramp,
};

/// Continuous states: x, δ, δ̇ and the memory of the effects behind the drive.
pub const STATES: usize = 3 + INTEGRATED;

/// Where the host is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Exchange {
    /// The command side is known up to here [s since the start].
    reference: f64,
    /// Command and load there [deg]; their slopes until there, 0 where they may have turned [deg/s].
    command: Ramp,
    load: Ramp,
    /// The host has set the command while time stood still.
    is_corner: bool,
    /// When the command had corners that have not come out of the delay yet [s since the start].
    corners: Vec<f64>,
    modes: Modes,
}

/// Instants that differ by less than this share are one: hosts compare event times with about that tolerance.
const SAME_TIME: f64 = 2e-9;

impl Exchange {
    /// True for finite numbers and modes that can be.
    pub fn is_sound(&self) -> bool {
        let ramps = [self.command, self.load].into_iter().flat_map(|ramp| [ramp.value, ramp.slope]);
        let finite = ramps.chain([self.reference]).chain(self.corners.iter().copied()).all(f64::is_finite);
        finite && self.modes.is_sound()
    }

    /// What comes in at the state's time, with these inputs.
    fn surroundings(&self, actuator: &Actuator, state: &State, [command, load]: [f64; 2]) -> Surroundings {
        let length = (state.time - self.reference).max(0.0);
        let instant = 4.0 * f64::EPSILON * state.time.abs();
        let since = |before: Ramp, now| if length > instant { slope(before.value, now, length) } else { before.slope };
        let (rate, pull) = (since(self.command, command), since(self.load, load));
        // Numbers so far apart that their difference is none come as a step.
        let is_line = length > instant && (command - self.command.value).is_finite();
        let (value, length) = if is_line { (self.command.value, length) } else { (command, 0.0) };
        let piece = Piece { value, slope: rate, length, instant };
        let until = self.corners.first().copied().unwrap_or(f64::INFINITY);
        actuator.surroundings(state, (self.reference, until), piece, Ramp { value: load, slope: pull })
    }

    /// Inputs are known up to here.
    fn advance(&mut self, time: f64, [command, load]: [f64; 2]) {
        let length = time - self.reference;
        if length > 0.0 {
            let on = |before: Ramp, now| Ramp { value: now, slope: slope(before.value, now, length) };
            (self.command, self.load) = (on(self.command, command), on(self.load, load));
            self.reference = time;
        }
    }
}

/// Slope of a straight line, 0 where it is beyond numbers [deg/s].
fn slope(before: f64, now: f64, length_s: f64) -> f64 {
    let slope = (now - before) / length_s;
    if slope.is_finite() { slope } else { 0.0 }
}

impl Unit {
    /// The drive has been initialized: the first modes.
    pub(super) fn begin_exchange(&mut self) -> Result<()> {
        let (actuator, state) = self.moving()?;
        let [command, load] = self.inputs().map(Ramp::held);
        let (mut state, failure) = (state.clone(), failure(self.memory.failure));
        let piece = Piece { value: command.value, slope: 0.0, length: 0.0, instant: 0.0 };
        // A command that is not the one at rest comes as a step.
        let corners = if actuator.delay() > 0.0 { vec![state.time] } else { Vec::new() };
        let until = corners.first().copied().unwrap_or(f64::INFINITY);
        let around = actuator.surroundings(&state, (state.time, until), piece, load);
        let modes = actuator.settle(&mut state, None, failure, &around);
        let reference = state.time;
        self.memory.state = Some(state);
        self.memory.exchange = Some(Exchange { reference, command, load, is_corner: false, corners, modes });
        Ok(())
    }

    fn here(&self) -> Result<(&Actuator, &State, &Exchange, Surroundings)> {
        let (actuator, state) = self.moving()?;
        let exchange = self.memory.exchange.as_ref();
        let exchange = exchange.ok_or_else(|| Error::new("instance", "co-simulation", "model exchange"))?;
        let around = exchange.surroundings(actuator, state, self.inputs());
        Ok((actuator, state, exchange, around))
    }

    /// Rates of the states now; where nobody integrates, in the modes that would be chosen now.
    pub(super) fn rates(&self) -> Result<Rates> {
        if self.memory.exchange.is_some() {
            let (actuator, state, exchange, around) = self.here()?;
            return Ok(actuator.rates(state, &exchange.modes, &around));
        }
        let made;
        let (actuator, mut state) = if let Ok((actuator, state)) = self.moving() {
            (actuator, state.clone())
        } else {
            made = self.memory.settings.actuator()?;
            (&made, made.at_rest(self.memory.settings.initial_position))
        };
        let [command, load] = self.inputs().map(Ramp::held);
        let piece = Piece { value: command.value, slope: 0.0, length: 0.0, instant: 0.0 };
        let around = actuator.surroundings(&state, (state.time, f64::INFINITY), piece, load);
        let modes = actuator.settle(&mut state, None, failure(self.memory.failure), &around);
        Ok(actuator.rates(&state, &modes, &around))
    }

    /// The host moves its time, if it is the one who does.
    pub(super) fn move_time(&mut self, time: f64) {
        let since_start = time - self.memory.start_time;
        if let Some(state) = &mut self.memory.state {
            state.time = since_start;
        }
    }

    pub(super) fn write_states(&self, into: &mut [f64]) {
        let rest;
        let state = if let Some(state) = &self.memory.state {
            state
        } else if let Ok(actuator) = self.memory.settings.actuator() {
            rest = actuator.at_rest(self.memory.settings.initial_position);
            &rest
        } else {
            // Parameters that do not go together yet.
            return into.fill(0.0);
        };
        into[..3].copy_from_slice(&[state.pole, state.position, state.rate]);
        into[3..].copy_from_slice(&state.memory[FIRST_INTEGRATED..]);
    }

    pub(super) fn read_states(&mut self, states: &[f64]) {
        if let Some(state) = &mut self.memory.state {
            (state.pole, state.position, state.rate) = (states[0], states[1], states[2]);
            state.memory[FIRST_INTEGRATED..].copy_from_slice(&states[3..]);
        }
    }

    pub(super) fn write_rates(&self, into: &mut [f64]) -> Result<()> {
        let Rates { pole, position, rate, memory } = self.rates()?;
        into[..3].copy_from_slice(&[pole, position, rate]);
        into[3..].copy_from_slice(&memory);
        Ok(())
    }

    pub(super) fn write_margins(&self, into: &mut [f64]) -> Result<()> {
        if self.memory.state.is_none() {
            into.fill(1.0);
            return Ok(());
        }
        let (actuator, state, exchange, around) = self.here()?;
        into.copy_from_slice(&actuator.margins(state, &exchange.modes, &around));
        Ok(())
    }

    /// The command side is known up to now.
    pub(super) fn catch_up(&mut self) -> Result<Surroundings> {
        let (actuator, state, exchange, around) = self.here()?;
        let mut state = state.clone();
        if state.time > exchange.reference {
            actuator.remember(&mut state, &around);
        }
        let (time, inputs) = (state.time, self.inputs());
        self.memory.state = Some(state);
        if let Some(exchange) = &mut self.memory.exchange {
            exchange.advance(time, inputs);
        }
        Ok(around)
    }

    /// True where something has ceased to hold, whether or not a margin has changed its sign.
    pub(super) fn wants_event(&self, around: &Surroundings) -> Result<bool> {
        let (actuator, state, exchange, _) = self.here()?;
        let margins = actuator.margins(state, &exchange.modes, around);
        Ok(margins.iter().any(|margin| *margin < 0.0) || actuator.has_turned(&exchange.modes, around))
    }

    fn inputs(&self) -> [f64; 2] {
        [self.memory.command.value(), self.memory.load.value()]
    }

    /// The host has set an input while time stood still: from here on it may go another way.
    pub(super) fn mark_corner(&mut self, slot: Slot) {
        match (slot, &mut self.memory.exchange) {
            (Slot::Command, Some(exchange)) => (exchange.is_corner, exchange.command.slope) = (true, 0.0),
            (Slot::Load, Some(exchange)) => exchange.load.slope = 0.0,
            _ => {}
        }
    }

    /// Chooses the modes; says whether states have jumped and when the next corner comes out of the delay.
    pub(super) fn settle(&mut self) -> Result<Discrete> {
        self.catch_up()?;
        let (_, state, exchange, _) = self.here()?;
        let (mut exchange, mut state) = (exchange.clone(), state.clone());
        let before = state.clone();
        let actuator = self.moving()?.0;
        let inputs = self.inputs();
        let (now, delay) = (state.time, actuator.delay());
        (exchange.command.value, exchange.load.value) = (inputs[0], inputs[1]);
        if delay == 0.0 {
            exchange.corners.clear();
        } else if exchange.is_corner {
            exchange.corners.push(now);
        }
        exchange.is_corner = false;
        while let Some(corner) = exchange.corners.first().copied() {
            if corner + delay > now + SAME_TIME * (1.0 + now.abs()) {
                break;
            }
            // Where the host stopped a rounding short of it, it comes now.
            state
                .history
                .iter_mut()
                .filter(|knot| knot.time == corner)
                .for_each(|knot| knot.time = corner.min(now - delay));
            exchange.corners.remove(0);
        }
        let around = exchange.surroundings(actuator, &state, inputs);
        let failure = failure(self.memory.failure);
        exchange.modes = actuator.settle(&mut state, Some(&exchange.modes), failure, &around);
        let next_event = exchange.corners.first().map(|corner| self.memory.start_time + corner + delay);
        let states_changed = (before.pole, before.position, before.rate) != (state.pole, state.position, state.rate)
            || before.memory != state.memory;
        (self.memory.state, self.memory.exchange) = (Some(state), Some(exchange));
        Ok(Discrete { needs_another: false, states_changed, next_event })
    }
}

/// Sizes of usual states.
pub(super) fn nominals(into: &mut [f64]) {
    into[..3].copy_from_slice(&[1.0, 1.0, 100.0]);
    let remembered = CHAIN.iter().flat_map(|effect| effect.remembered());
    into[3..].iter_mut().zip(remembered).for_each(|(nominal, (_, remembered))| *nominal = remembered.nominal);
}
