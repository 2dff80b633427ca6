//! The memory that only model exchange needs: how far the command side has been evaluated, and the modes.

use serde::{Deserialize, Serialize};

use crate::{
    actuator::{Actuator, EvaluatedInputs, Modes, State},
    operator::Piece,
    transition::Ramp,
};

/// Memory of model exchange between two calls of the host.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ModelExchangeState {
    /// The command side has been evaluated up to this time [s since the start].
    pub reference: f64,
    /// Command there [deg], with its derivative up to there, 0 after a breakpoint [deg/s].
    pub command: Ramp,
    /// Load there, likewise.
    pub load: Ramp,
    /// The host has set the command in event mode in a way that may be a breakpoint here.
    pub is_breakpoint: bool,
    /// Breakpoints of the command that are still in the delay [s since the start].
    pub breakpoints: Vec<f64>,
    /// The last breakpoint with the slope before it [s since the start, deg/s], if the command is continuous there: the next step shows
    /// whether its slope changes.
    pub unconfirmed: Option<(f64, f64)>,
    /// This event was requested by a time event, an indicator or the end of a step.
    pub is_requested: bool,
    /// A change of parameters has changed the continuous states, which has not been reported to the host yet.
    pub has_jumped: bool,
    /// Modes between events.
    pub modes: Modes,
}

impl Clone for ModelExchangeState {
    fn clone(&self) -> Self {
        Self { breakpoints: self.breakpoints.clone(), modes: self.modes.clone(), ..*self }
    }

    fn clone_from(&mut self, source: &Self) {
        let mut breakpoints = std::mem::take(&mut self.breakpoints);
        breakpoints.clone_from(&source.breakpoints);
        *self = Self { breakpoints, modes: source.modes.clone(), ..*source };
    }
}

impl ModelExchangeState {
    /// True for finite numbers.
    pub fn is_finite(&self) -> bool {
        let ramps = [self.command, self.load].into_iter().flat_map(|ramp| [ramp.value, ramp.slope]);
        ramps.chain([self.reference]).chain(self.breakpoints.iter().copied()).all(f64::is_finite)
    }

    /// Evaluates command and load at the time of the state.
    pub fn evaluate_inputs(&self, actuator: &Actuator, state: &State, [command, load]: [f64; 2]) -> EvaluatedInputs {
        let length = (state.time - self.reference).max(0.0);
        let time_resolution = 4.0 * f64::EPSILON * state.time.abs();
        let since =
            |before: Ramp, now| if length > time_resolution { slope(before.value, now, length) } else { before.slope };
        let (command_slope, load_slope) = (since(self.command, command), since(self.load, load));
        // A difference that overflows is a step.
        let is_linear = length > time_resolution && (command - self.command.value).is_finite();
        let (value, length) = if is_linear { (self.command.value, length) } else { (command, 0.0) };
        let piece = Piece { value, slope: command_slope, length, time_resolution };
        let until = self.breakpoints.first().copied().unwrap_or(f64::INFINITY);
        actuator.evaluate_inputs(state, (self.reference, until), piece, Ramp { value: load, slope: load_slope })
    }

    /// The inputs at `time` [s since the start] have been taken into account.
    pub fn advance(&mut self, time: f64, [command, load]: [f64; 2]) {
        let length = time - self.reference;
        if length > 0.0 {
            let on = |before: Ramp, now| Ramp { value: now, slope: slope(before.value, now, length) };
            (self.command, self.load) = (on(self.command, command), on(self.load, load));
            self.reference = time;
            self.confirm();
        }
    }
}

impl ModelExchangeState {
    /// Keeps the unconfirmed breakpoint only if the slope has changed.
    fn confirm(&mut self) {
        /// Relative: the minimum accuracy of command differences over a step.
        const SAME_SLOPE: f64 = 1e-6;
        let Some((time, before)) = self.unconfirmed.take() else { return };
        let now = self.command.slope;
        if (now - before).abs() <= SAME_SLOPE * now.abs().max(before.abs()) {
            self.breakpoints.retain(|breakpoint| *breakpoint != time);
        }
    }

    /// The host has set the command at this time [s since the start], in event mode. A jump is a breakpoint. A continuous command may
    /// change its slope here: the host may have come for its own event, or for one of ours and write the old value again.
    pub fn set_command(&mut self, value: f64) {
        if value != self.command.value {
            (self.is_breakpoint, self.command.slope, self.unconfirmed) = (true, 0.0, None);
        } else if !self.is_requested && !self.is_breakpoint {
            (self.is_breakpoint, self.unconfirmed) = (true, Some((self.reference, self.command.slope)));
        }
    }

    /// The host has set the load in event mode.
    pub fn set_load(&mut self, value: f64) {
        if value != self.load.value {
            self.load.slope = 0.0;
        }
    }

    /// True if a breakpoint leaves the delay now.
    pub fn is_due(&self, now: f64, delay: f64) -> bool {
        let first = self.breakpoints.first();
        first.is_some_and(|breakpoint| breakpoint + delay <= now + EVENT_TIME_TOLERANCE * (1.0 + now.abs()))
    }
}

/// Relative tolerance of event times, as wide as that with which hosts compare them; the absolute one has the same value at 0 s.
const EVENT_TIME_TOLERANCE: f64 = 2e-9;

/// Slope of a straight line, 0 where it is not finite [deg/s].
fn slope(before: f64, now: f64, length_s: f64) -> f64 {
    let slope = (now - before) / length_s;
    if slope.is_finite() { slope } else { 0.0 }
}
