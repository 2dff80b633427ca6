//! A step from one communication point to the next: one transition, or from breakpoint to breakpoint of the command, from segment
//! to segment, from event to event.

use nalgebra::Vector3;

use super::{
    constants::Actuator,
    segment::{SegmentInputs, time_resolution},
    signals::{Failure, Inputs},
    state::State,
    whole_step::WholeStep,
    workspace::Workspace,
};
use crate::{
    command::{Change, EffectInputs},
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

/// Maximum number of linear command pieces in a step that are not counted as segments.
const MOST_PIECES: u32 = 100;

/// Maximum number of command corners in a step that are handled together.
const MOST_CORNERS: u32 = 8;

/// A limit active for less than this fraction of a step is an effect of rounding of two event times.
const SHORTEST_SATURATION: f64 = 1e-9;

/// No limit on the segments of a step other than the one set by its length.
const NO_BUDGET: u32 = u32::MAX;

impl Actuator {
    /// Advances the state by `duration` \[s\] > 0.
    ///
    /// # Errors
    /// A state that is not finite, a motion that diverges, a step that is too long, events without end.
    #[inline]
    pub fn step(&self, state: &mut State, workspace: &mut Workspace, inputs: Inputs, duration: f64) -> Result<()> {
        let elapsed = self.advance_within(state, workspace, inputs, duration, NO_BUDGET)?;
        if elapsed == duration { Ok(()) } else { Err(endless(state)) }
    }

    /// Advances the state by `duration` \[s\] > 0, or by less if that requires more than `budget` segments; returns the time advanced.
    ///
    /// # Errors
    /// As [`Actuator::step`]; the state is then undefined where effects act, and unchanged where none do.
    #[inline]
    pub fn advance_within(
        &self,
        state: &mut State,
        workspace: &mut Workspace,
        inputs: Inputs,
        duration: f64,
        budget: u32,
    ) -> Result<f64> {
        if self.is_linear && inputs.is_unloaded() {
            if !self.linear_step(state, workspace, inputs.command, duration) {
                return Err(not_finite(state));
            }
            state.time += duration;
            return Ok(duration);
        }
        let whole = self.whole_step(state, workspace, &inputs, duration);
        if whole == WholeStep::Done {
            return Ok(duration);
        }
        self.divided_step(state, workspace, inputs, duration, budget, whole)
    }

    /// As above, for a step that is not done as a whole.
    #[inline(never)]
    fn divided_step(
        &self,
        state: &mut State,
        workspace: &mut Workspace,
        inputs: Inputs,
        duration: f64,
        budget: u32,
        whole: WholeStep,
    ) -> Result<f64> {
        let start = state.time;
        let (mut elapsed, mut saturated) = (0.0, false);
        let may_have_maps = self.has_maps && self.command.delay == 0.0 && inputs.failure == Failure::None;
        let mut has_maps = may_have_maps && (whole == WholeStep::Unknown || self.shortest_part.is_some());
        while elapsed < duration {
            has_maps &= self.tries_maps(&workspace.maps);
            if has_maps {
                let (inputs, rest) = (inputs.after(elapsed), duration - elapsed);
                let done = self.step_by_maps(state, workspace, inputs, (rest, elapsed > 0.0))?;
                saturated |= done > 0.0 && state.saturated;
                elapsed = if done == rest { duration } else { elapsed + done };
            }
            if elapsed < duration {
                // After the part in which a mode ends, maps may apply again.
                let rest = duration - elapsed;
                let part = if has_maps { self.part_without_map(state.position, rest) } else { rest };
                let done = self.step_by_segments(state, workspace, inputs.after(elapsed), part, budget)?;
                saturated |= state.saturated;
                // Ends exactly at the end of the step, regardless of rounding in the sum of its parts.
                elapsed = if done == rest { duration } else { elapsed + done };
                if done < part {
                    break;
                }
            }
        }
        state.saturated = saturated;
        let is_finite = |numbers: &[f64]| numbers.iter().all(|number| number.is_finite());
        if is_finite(&[state.pole, state.position, state.rate]) && is_finite(&state.memory) {
            self.command.forget(&mut state.history, start);
            return Ok(elapsed);
        }
        Err(not_finite(state))
    }

    /// Advances the state, but not its time, by `duration` \[s\] > 0 where no effect acts (see [`Actuator::is_linear`]). False, with nothing
    /// changed, if the motion is not finite.
    #[inline]
    pub fn linear_step(&self, state: &mut State, workspace: &mut Workspace, command: Ramp, duration: f64) -> bool {
        let is_finite = state.linear_step(workspace.transition(self, duration), command);
        state.saturated &= !is_finite;
        is_finite
    }

    /// Advances the state by maps through as much of the step as possible, for a linear command; returns the time advanced [s].
    #[inline(never)]
    fn step_by_maps(
        &self,
        state: &mut State,
        workspace: &mut Workspace,
        inputs: Inputs,
        (duration, is_rest): (f64, bool),
    ) -> Result<f64> {
        let Inputs { command: Ramp { value, slope }, load, .. } = inputs;
        let start = state.time;
        let time_resolution = time_resolution(duration, start);
        let now = Piece { value, slope, length: duration, time_resolution };
        workspace.has_stalled = false;
        if self.is_linear_behind_command && load.slope == 0.0 {
            let constant_load = self.terms.bias + load.value;
            if self.step_by_corners(state, workspace, &now, constant_load)? {
                return Ok(duration);
            }
            let command = self.piece_from(state, &now, 0.0, &mut workspace.inputs);
            let (mut done, mut piece) = (0.0, command);
            for _ in 0..MOST_PIECES {
                self.linear_piece(state, workspace, piece, constant_load, duration)?;
                done = if piece.length == duration - done { duration } else { done + piece.length };
                if done >= duration {
                    break;
                }
                piece = self.piece_from(state, &now, done, &mut workspace.inputs);
            }
            (state.time, state.saturated) = (start + done, false);
            return Ok(done);
        }
        let command = self.piece_from(state, &now, 0.0, &mut workspace.inputs);
        if command.length < duration {
            return Ok(0.0);
        }
        let (mut done, mut saturated) = (0.0, false);
        while done < duration {
            let rest = Piece { value: command.at(done), length: duration - done, ..command };
            let load = Ramp { value: load.at(done), ..load };
            let piece = (&rest, is_rest || done > 0.0);
            let Some(elapsed) = self.advance_by_map(state, &mut workspace.maps, piece, load, state.time + done) else {
                break;
            };
            saturated |= state.saturated;
            done = if elapsed == rest.length { duration } else { done + elapsed };
        }
        if done > 0.0 {
            self.command.advance(&mut state.memory, &workspace.inputs, done);
            (state.time, state.saturated) = (state.time + done, saturated);
        }
        Ok(done)
    }

    /// Advances the state by a step with command `now` under this load [deg], where no effect acts on the motion; false, with nothing
    /// changed, if the step is too long or the output of the command side jumps within it or has too many corners.
    fn step_by_corners(&self, state: &mut State, workspace: &mut Workspace, now: &Piece, load: f64) -> Result<bool> {
        if !self.has_corners_in(now.length) {
            return Ok(false);
        }
        let memory = state.memory;
        let first = self.piece_from(state, now, 0.0, &mut workspace.inputs);
        let (mut done, mut piece, mut change) = (0.0, first, Vector3::zeros());
        for _ in 0..MOST_CORNERS {
            self.command.advance(&mut state.memory, &workspace.inputs, piece.length);
            if piece.length == now.length - done {
                let line = Ramp { value: first.value, slope: first.slope };
                if !state.loaded_step(workspace.transition(self, now.length), line, load) {
                    return Err(not_finite(state));
                }
                (state.pole, state.position) = (state.pole + change.x, state.position + change.y);
                state.rate += change.z;
                (state.time, state.saturated) = (state.time + now.length, false);
                return Ok(true);
            }
            done += piece.length;
            let next = self.piece_from(state, now, done, &mut workspace.inputs);
            if !next.is_at(piece.at(piece.length)) {
                break;
            }
            change += workspace.corners(self, now.length).after(now.length - done) * (next.slope - piece.slope);
            piece = next;
        }
        state.memory = memory;
        Ok(false)
    }

    /// The piece of the command side's output, without a delay, from a time [s] after the start of a step with command `now`.
    fn piece_from(&self, state: &State, now: &Piece, done: f64, into: &mut EffectInputs) -> Piece {
        let rest = Piece { value: now.at(done), length: now.length - done, ..*now };
        let past = state.history.with(Change::None);
        let piece = self.command.pieces(past, &state.memory, state.time + done, rest, into);
        Piece { length: piece.length.clamp(now.time_resolution.min(rest.length), rest.length), ..piece }
    }

    /// Advances the state piece by piece and segment by segment.
    fn step_by_segments(
        &self,
        state: &mut State,
        workspace: &mut Workspace,
        inputs: Inputs,
        duration: f64,
        budget: u32,
    ) -> Result<f64> {
        let start = state.time;
        let time_resolution = time_resolution(duration, start);
        let Inputs { command, load, failure } = inputs;
        let now = |done: f64| Piece {
            value: command.at(done),
            slope: command.slope,
            length: duration - done,
            time_resolution,
        };
        workspace.change = self.command.record(&mut state.history, start, now(0.0));
        workspace.has_stalled = false;
        let (mut done, mut without_progress, mut saturated) = (0.0, 0, false);
        // Segments up to here, after a piece without a map: the length of its remainder does not recur.
        let mut without_map = 0.0;
        // The end of the piece for which maps over a part were tried.
        let mut end_of_piece = f64::NEG_INFINITY;
        if duration * self.largest_pole > MAX_STEP_TIME_CONSTANTS {
            let allowed = format!("at most {:.3e} s where effects act", MAX_STEP_TIME_CONSTANTS / self.largest_pole);
            return Err(Error::new("communicationStepSize", format!("{duration:e} s"), allowed));
        }
        let mut segments_left = MAX_SEGMENTS_RATIO * (1.0 + duration * self.largest_pole);
        let mut budget_left = budget;
        while done < duration {
            segments_left -= 1.0;
            if segments_left < 0.0 {
                return Err(endless(state));
            }
            if budget_left == 0 {
                break;
            }
            budget_left -= u32::from(budget != NO_BUDGET);
            let (time, rest) = (start + done, duration - done);
            let Workspace { inputs: of_effects, .. } = &mut *workspace;
            let past = state.history.with(Change::None);
            let mut command = self.command.pieces(past, &state.memory, time, now(done), of_effects);
            command.length = command.length.clamp(time_resolution.min(rest), rest);
            let load = Ramp { value: load.at(done), slope: load.slope };
            let has_transition = self.is_linear_behind_command && load.slope == 0.0 && failure == Failure::None;
            let is_step = has_transition && command.length == duration;
            // Steps without a delay have already been tried.
            let has_maps = self.has_maps && self.tries_maps(&workspace.maps);
            if has_maps && self.command.delay > 0.0 && failure == Failure::None && !is_step && done >= without_map {
                let Workspace { inputs: of_effects, maps, .. } = &mut *workspace;
                let is_rest = (done + command.length - end_of_piece).abs() <= time_resolution;
                end_of_piece = done + command.length;
                if let Some(elapsed) = self.advance_by_map(state, maps, (&command, is_rest), load, time) {
                    saturated |= state.saturated;
                    self.command.advance(&mut state.memory, of_effects, elapsed);
                    done = if elapsed == rest { duration } else { done + elapsed };
                    without_progress = 0;
                    continue;
                }
                without_map = done + self.shortest_part.unwrap_or(f64::INFINITY).min(command.length) - time_resolution;
            }
            if has_transition {
                self.linear_piece(state, workspace, command, self.terms.bias + load.value, duration)?;
                done = if command.length == rest { duration } else { done + command.length };
                continue;
            }
            let Workspace { inputs: of_effects, solution, .. } = &mut *workspace;
            let solved = self.solve_segment(state, &SegmentInputs { command, load, failure, time }, solution)?;
            if budget != NO_BUDGET {
                budget_left = budget_left.saturating_sub(solved - 1);
            }
            let is_stalled = without_progress >= MAX_EVENTS_WITHOUT_PROGRESS;
            let (tau, event) = if is_stalled { (1.0, None) } else { solution.end() };
            self.advance(state, solution, tau, event);
            let elapsed = tau * solution.segment.length;
            saturated |= state.saturated && elapsed > SHORTEST_SATURATION * duration;
            self.command.advance(&mut state.memory, of_effects, elapsed);
            without_progress = if elapsed > time_resolution { 0 } else { without_progress + 1 };
            // The last segment ends exactly at the end of the step, regardless of rounding in the sum of its parts.
            done = if tau == 1.0 && solution.segment.length == rest { duration } else { done + elapsed };
            workspace.has_stalled |= is_stalled;
        }
        state.time = start + done;
        state.saturated = saturated;
        Ok(done)
    }

    /// Advances the state through a linear piece of the command under a constant load, without effects on the motion.
    fn linear_piece(
        &self,
        state: &mut State,
        workspace: &mut Workspace,
        piece: Piece,
        load: f64,
        step: f64,
    ) -> Result<()> {
        let command = Ramp { value: piece.value, slope: piece.slope };
        let is_finite = if piece.length == step {
            state.loaded_step(workspace.transition(self, step), command, load)
        } else {
            // Piece lengths do not repeat to the last bit, so the transition is not cached.
            state.loaded_step(&Transition::new(self.base, self.order, piece.length), command, load)
        };
        self.command.advance(&mut state.memory, &workspace.inputs, piece.length);
        if is_finite { Ok(()) } else { Err(not_finite(state)) }
    }
}

#[cold]
fn not_finite(state: &State) -> Error {
    let found =
        format!("numbers that are not finite, from a position of {} at a rate of {}", state.position, state.rate);
    Error::new("motion in this step", found, "finite numbers")
}

#[cold]
fn endless(state: &State) -> Error {
    let found = format!("events without end at {} s, position {}", state.time, state.position);
    Error::new("motion in this step", found, "a finite number of events")
}
