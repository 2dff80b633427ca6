//! A step from one communication point to the next: one transition, or from breakpoint to breakpoint of the command, from segment
//! to segment, from event to event.

use super::{
    constants::Actuator,
    segment::{SegmentInputs, TIME_RESOLUTION},
    signals::{Failure, Inputs},
    state::State,
    workspace::Workspace,
};
use crate::{
    error::{Error, Result},
    operator::Piece,
    transition::{Ramp, Transition},
};

/// After this number of consecutive events without progress in time one segment is taken to its end regardless of events.
const MAX_EVENTS_WITHOUT_PROGRESS: u32 = 20;

/// Maximum number of segments in a step, relative to those that its length requires: far above the number of events in any motion,
/// so that a call always returns.
const MAX_SEGMENTS_RATIO: f64 = 1e4;

/// Maximum length of a step in time constants of the fastest pole represented by Taylor series: a longer one would take hours.
const MAX_STEP_TIME_CONSTANTS: f64 = 1e9;

impl Actuator {
    /// Advances the state by `duration` [s] > 0.
    ///
    /// # Errors
    /// A state that is not finite, a motion that diverges, a step that is too long.
    pub fn step(&self, state: &mut State, workspace: &mut Workspace, inputs: Inputs, duration: f64) -> Result<()> {
        let unloaded = inputs.load == Ramp::default() && inputs.failure == Failure::None;
        if self.is_linear && unloaded {
            state.linear_step(workspace.transition(self, duration), inputs.command, 0.0);
            state.time += duration;
        } else {
            self.step_by_segments(state, workspace, inputs, duration)?;
        }
        if [state.pole, state.position, state.rate].iter().chain(&state.memory).all(|number| number.is_finite()) {
            return Ok(());
        }
        Err(Error::new(
            "motion in this step",
            format!("a position of {} and a rate of {}", state.position, state.rate),
            "finite numbers",
        ))
    }

    /// Advances the state piece by piece and segment by segment.
    fn step_by_segments(
        &self,
        state: &mut State,
        workspace: &mut Workspace,
        inputs: Inputs,
        duration: f64,
    ) -> Result<()> {
        let start = state.time;
        // Above the rounding of the time.
        let time_resolution = (TIME_RESOLUTION * duration).max(4.0 * f64::EPSILON * start.abs());
        let Inputs { command, load, failure } = inputs;
        let now = |done: f64| Piece {
            value: command.at(done),
            slope: command.slope,
            length: duration - done,
            time_resolution,
        };
        self.command.record(&mut state.history, start, now(0.0));
        let (mut done, mut without_progress) = (0.0, 0);
        if duration * self.largest_pole > MAX_STEP_TIME_CONSTANTS {
            let allowed = format!("at most {:.3e} s where effects act", MAX_STEP_TIME_CONSTANTS / self.largest_pole);
            return Err(Error::new("communicationStepSize", format!("{duration:e} s"), allowed));
        }
        let mut segments_left = MAX_SEGMENTS_RATIO * (1.0 + duration * self.largest_pole);
        while done < duration {
            segments_left -= 1.0;
            if segments_left < 0.0 {
                let found = format!("events without end at {} s, position {}", start + done, state.position);
                return Err(Error::new("motion in this step", found, "a finite number of events"));
            }
            let (time, rest) = (start + done, duration - done);
            let mut command =
                self.command.pieces(&state.history, &state.memory, time, now(done), &mut workspace.pieces);
            command.length = command.length.clamp(time_resolution.min(rest), rest);
            let load = Ramp { value: load.at(done), slope: load.slope };
            if self.is_linear_behind_command && load.slope == 0.0 && failure == Failure::None {
                self.linear_piece(state, workspace, command, self.terms.bias + load.value, duration);
                done = if command.length == rest { duration } else { done + command.length };
                continue;
            }
            let Workspace { pieces, solution, .. } = &mut *workspace;
            self.solve_segment(state, &SegmentInputs { command, load, failure, time }, solution)?;
            let (tau, event) =
                if without_progress < MAX_EVENTS_WITHOUT_PROGRESS { solution.end() } else { (1.0, None) };
            self.advance(state, solution, tau, event);
            let elapsed = tau * solution.segment.length;
            self.command.advance(&mut state.memory, pieces, elapsed);
            without_progress = if elapsed > time_resolution { 0 } else { without_progress + 1 };
            // The last segment ends exactly where the step does, whatever the sum of its parts rounds to.
            done = if tau == 1.0 && solution.segment.length == rest { duration } else { done + elapsed };
        }
        state.time = start + duration;
        Ok(())
    }

    /// Advances the state through a linear piece of the command under a constant load, without effects on the motion.
    fn linear_piece(&self, state: &mut State, workspace: &mut Workspace, piece: Piece, load: f64, step: f64) {
        let command = Ramp { value: piece.value, slope: piece.slope };
        if piece.length == step {
            state.linear_step(workspace.transition(self, step), command, load);
        } else {
            // Lengths of pieces do not repeat to the last bit: no use to cache the transition.
            state.linear_step(&Transition::new(self.base, self.order, piece.length), command, load);
        }
        self.command.advance(&mut state.memory, &workspace.pieces, piece.length);
    }
}
