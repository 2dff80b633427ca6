//! A step of co-simulation. Without effects it changes the state in place; with effects the state before is kept, for the directional
//! derivatives and for a step that fails. Nothing is allocated.

use fmi_export::{Error, Result};

use super::{actuator_model::ActuatorModel, memory::LastStep};

/// Maximum number of segments in a step: some 0.1 to 1 s of computation, after which the host gets the state reached.
const SEGMENTS_PER_STEP: u32 = 500_000;

/// See [`Workspace::has_stalled`](crate::actuator::Workspace::has_stalled).
const STALLED: &str = "many events at one instant: limits and friction were ignored over a part of the step";

impl ActuatorModel {
    /// Advances from `time` by `duration` [s].
    pub(super) fn advance(&mut self, time: f64, duration: f64) -> Result<()> {
        let inputs = self.memory.inputs();
        let memory = &mut self.memory;
        let (Some(actuator), Some(state)) = (&self.actuator, memory.state.as_mut()) else {
            return self.initialized().map(|_| ());
        };
        if ![inputs.command.at(duration), inputs.load.at(duration)].iter().all(|value| value.is_finite()) {
            return Err(Error::new("inputs at the end of this step", format!("{inputs:?}"), "finite numbers"));
        }
        let is_linear = actuator.is_linear() && inputs.is_unloaded();
        let before = (!is_linear).then(|| state.without_history());
        let time_before = std::mem::replace(&mut state.time, time - memory.start_time);
        let workspace = &mut self.workspace;
        let advanced = actuator.advance_within(state, workspace, inputs, duration, SEGMENTS_PER_STEP);
        let elapsed = match advanced {
            Ok(elapsed) => elapsed,
            Err(error) => {
                match &before {
                    Some(before) => {
                        state.history.undo(workspace.change());
                        state.set_all_but_history(before);
                    }
                    None => state.time = time_before,
                }
                return Err(error.into());
            }
        };
        let has_stalled = before.is_some() && workspace.has_stalled();
        self.warning = has_stalled.then_some(STALLED);
        self.outputs.set(None);
        memory.command.advance(elapsed);
        memory.load.advance(elapsed);
        match (&mut memory.last_step, before) {
            // Most of it stays as it was.
            (Some(last), None) if last.before.is_none() => (last.duration, last.inputs) = (elapsed, inputs),
            (last, before) => *last = Some(LastStep { duration: elapsed, inputs, before, change: workspace.change() }),
        }
        if elapsed == duration {
            return Ok(());
        }
        let found = format!("{SEGMENTS_PER_STEP} events and segments in {elapsed} s of {duration} s");
        let error = Error::new("step", found, "as many").remedy("go on from the time reached, with shorter steps");
        Err(error.discarded_at(time + elapsed))
    }
}
