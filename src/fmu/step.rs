//! A step of co-simulation. Without effects it changes the state in place; with effects the state before it is kept, for directional
//! derivatives and for failed steps. Nothing is allocated.

use fmi_export::{Error, Result};

use super::{
    actuator_model::ActuatorModel,
    last_step::{LastStep, StepRecord},
    memory::NO_FAILURE,
};

/// Maximum number of segments in a step: some 0.1 to 1 s of computation, 4 s at worst, after which the host gets the state reached.
const SEGMENTS_PER_STEP: u32 = 500_000;

/// See [`Workspace::has_stalled`](crate::actuator::Workspace::has_stalled).
const STALLED: &str = "many events at one instant: limits and friction were ignored over a part of the step";

impl ActuatorModel {
    /// Advances from `time` by `duration` [s].
    #[inline]
    pub(super) fn advance(&mut self, time: f64, duration: f64) -> Result<()> {
        let memory = &mut self.memory;
        match (&self.actuator, &mut memory.state) {
            (Some(actuator), Some(state))
                if actuator.is_linear() && memory.load.is_none() && memory.failure == NO_FAILURE =>
            {
                let command = memory.command.ramp();
                if !actuator.linear_step(state, &mut self.workspace, command, duration) {
                    return Err(self.not_finite(duration));
                }
                state.time = time - memory.start_time + duration;
                memory.command.advance(duration);
                memory.last_step.set_linear(duration, command);
                Ok(())
            }
            _ => self.advance_with_effects(time, duration),
        }
    }

    #[cold]
    fn not_finite(&self, duration: f64) -> Error {
        let inputs = self.memory.inputs();
        let (name, found) = if inputs.command.at(duration).is_finite() && inputs.load.at(duration).is_finite() {
            ("motion in this step", "numbers that are not finite".to_owned())
        } else {
            ("inputs at the end of this step", format!("{inputs:?}"))
        };
        Error::new(name, found, "finite numbers")
    }

    #[inline(never)]
    fn advance_with_effects(&mut self, time: f64, duration: f64) -> Result<()> {
        let inputs = self.memory.inputs();
        if !(inputs.command.at(duration).is_finite() && inputs.load.at(duration).is_finite()) {
            return Err(self.not_finite(duration));
        }
        let memory = &mut self.memory;
        let (Some(actuator), Some(state)) = (&self.actuator, &mut memory.state) else {
            return self.initialized().map(|_| ());
        };
        let before = state.without_history();
        state.time = time - memory.start_time;
        let workspace = &mut self.workspace;
        let advanced = actuator.advance_within(state, workspace, inputs, duration, SEGMENTS_PER_STEP);
        let change = workspace.change();
        let elapsed = match advanced {
            Ok(elapsed) => elapsed,
            Err(error) => {
                state.history.undo(change);
                state.set_all_but_history(&before);
                return Err(error.into());
            }
        };
        self.warning = workspace.has_stalled().then_some(STALLED);
        self.outputs.set(None);
        memory.command.advance(elapsed);
        memory.load.advance(elapsed);
        memory.last_step = LastStep::WithEffects(StepRecord { duration: elapsed, inputs, before, change });
        if elapsed == duration {
            return Ok(());
        }
        let found = format!("{SEGMENTS_PER_STEP} events and segments in {elapsed} s of {duration} s");
        let error = Error::new("step", found, "as many").remedy("go on from the time reached, with shorter steps");
        Err(error.discarded_at(time + elapsed))
    }
}

#[cfg(test)]
mod tests {
    use fmi_export::{Kind, Model};

    use super::*;
    use crate::{
        fmu::Start,
        operator::{OutputOperator, Segment, SegmentResponse},
        series::Series,
    };

    /// An effect with an event at every start of a segment.
    struct Endless;

    impl OutputOperator for Endless {
        fn start(&self, _: &[f64], _: &mut [f64], rest: f64) -> f64 {
            rest
        }

        fn value(&self, _: &[f64], _: &[f64], input: f64) -> f64 {
            input
        }

        fn segment_response(&self, _: &[f64], _: &[f64], input: &Series, _: Segment) -> SegmentResponse {
            SegmentResponse { output: *input, valid_until: Some(0.0) }
        }

        fn advance(&self, _: &[f64], _: &mut [f64], _: &Series, _: &Series, _: Segment, _: f64) {}
    }

    #[test]
    fn a_step_over_events_without_progress_warns_and_the_next_one_does_not() {
        let mut model = ActuatorModel::new(&Start::default(), Kind::CoSimulation);
        model.initialize(0.0).unwrap();
        let plain = model.actuator.take();
        let endless = model.memory.settings.actuator().unwrap().with_output_effect(&Endless);
        model.actuator = Some(endless);
        model.step(0.0, 0.01).unwrap();
        assert_eq!(model.take_warning().as_deref(), Some(STALLED));
        assert_eq!(model.take_warning(), None);
        model.actuator = plain;
        model.memory.load.set_value(0.1);
        model.step(0.01, 0.01).unwrap();
        assert_eq!(model.take_warning(), None);
    }
}
