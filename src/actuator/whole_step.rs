//! A step with a linear command (behind its effects) and no change of mode: most of the steps of a search. The result is that of a map over
//! the step, without the overhead of the general step.

use super::{
    constants::Actuator,
    integration::FIRST_INTEGRATED,
    linear_map::LinearMap,
    linear_system::{DEMAND, FORCE, Kind, POLE, POSITION, RATE, REMEMBERED, SIZE, STATES},
    segment::time_resolution,
    signals::{Failure, Inputs},
    state::State,
    workspace::Workspace,
};
use crate::{
    effects::OUTPUT_EFFECTS,
    motion::{DriveMode, DriveState, Ends},
    operator::{EventCondition, Signal},
    parameters::Order,
    transition::Ramp,
};

/// Outcome of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WholeStep {
    /// The step is done.
    Done,
    /// A mode may end within the step; nothing has changed.
    MeetsEvent,
    /// The step is not of this kind, or has no map of its length; nothing has changed.
    Unknown,
}

/// The drive at the start of a step, and its inputs.
struct Course {
    mode: DriveMode,
    from: DriveState,
    pole: f64,
    /// Demand of the servo [deg].
    demand: Ramp,
    /// Load [deg].
    load: Ramp,
}

impl Actuator {
    /// Advances the state by a step [s], if it is of this kind.
    #[inline]
    pub(super) fn whole_step(
        &self,
        state: &mut State,
        workspace: &mut Workspace,
        inputs: &Inputs,
        duration: f64,
    ) -> WholeStep {
        if !self.has_whole_steps || inputs.failure != Failure::None {
            return WholeStep::Unknown;
        }
        let Ramp { value, slope } = inputs.command;
        self.whole_step_of(state, workspace, Signal { value, slope }, inputs.load, duration)
    }

    /// As above, with inputs passed in registers.
    #[inline(never)]
    fn whole_step_of(
        &self,
        state: &mut State,
        workspace: &mut Workspace,
        command: Signal,
        load: Ramp,
        duration: f64,
    ) -> WholeStep {
        let resolution = time_resolution(duration, state.time);
        let Some(shaped) = self.command.whole_step(&state.memory, command, duration, resolution) else {
            return WholeStep::Unknown;
        };
        if self.is_linear_behind_command {
            let transition = workspace.transition(self, duration);
            let shaped = Ramp { value: shaped.value, slope: shaped.slope };
            if load.slope != 0.0 || !state.loaded_step(transition, shaped, self.terms.bias + load.value) {
                return WholeStep::Unknown;
            }
            state.saturated = false;
        } else if !self.step_by_turns(state, workspace, (shaped, load), duration) {
            if !workspace.maps.are_worth_it() {
                return WholeStep::Unknown;
            }
            let [demand, slope, bend] = self.command.demand_of(shaped, state.time, 1.0);
            if bend != 0.0 {
                return WholeStep::Unknown;
            }
            let pole = if self.order == Order::Second { demand } else { state.pole };
            let mut from = self.terms.clamped_to_limits(DriveState { position: state.position, rate: state.rate });
            let mode = self.terms.active_mode(&from, pole, load.value);
            from.rate = mode.rate_or_held(from.rate);
            let course = Course { mode, from, pole, demand: Ramp { value: demand, slope }, load };
            let step = if self.output_effects.is_empty() && self.terms.cubic == 0.0 {
                self.step_of_drive(state, workspace, &course, duration)
            } else {
                self.step_of_all(state, workspace, &course, duration)
            };
            if step != WholeStep::Done {
                return step;
            }
            workspace.maps.has_found();
        }
        self.command.advance_whole_step(&mut state.memory, command, duration, resolution);
        state.time += duration;
        WholeStep::Done
    }

    /// Without effects behind the drive and a cubic spring.
    #[inline]
    fn step_of_drive(&self, state: &mut State, workspace: &Workspace, course: &Course, duration: f64) -> WholeStep {
        let Course { mode, from, pole, demand, load } = course;
        let force = mode.linear_force(&self.terms);
        let kind = Kind::new(force, &[EventCondition::None; OUTPUT_EFFECTS]);
        let Some(map) = workspace.maps.known(&kind, duration) else { return WholeStep::Unknown };
        let force = force.map_or(Ramp::default(), |(_, constant)| Ramp { value: constant + load.value, ..*load });
        let [after, position, rate] = map.drive([*pole, from.position, from.rate], *demand, force);
        if !(after + position + rate).is_finite() {
            return WholeStep::Unknown;
        }
        if self.has_events_of_motion && !self.lasts(course, [after, position, rate], EventCondition::None, map) {
            return WholeStep::MeetsEvent;
        }
        (state.pole, state.position, state.rate) = (after, position, rate);
        state.saturated = mode.is_saturated();
        WholeStep::Done
    }

    /// With effects behind the drive or a cubic spring.
    fn step_of_all(&self, state: &mut State, workspace: &Workspace, course: &Course, duration: f64) -> WholeStep {
        if self.terms.cubic != 0.0 && self.length_of_map(state.position, duration) != Some(duration) {
            return WholeStep::Unknown;
        }
        let Course { mode, from, pole, demand, load } = course;
        let mut z = [0.0; SIZE];
        (z[POLE], z[POSITION], z[RATE]) = (*pole, from.position, from.rate);
        (z[DEMAND], z[DEMAND + 1]) = (demand.value, demand.slope);
        let force = mode.linear_force(&self.terms);
        if let Some((_, constant)) = force {
            (z[FORCE], z[FORCE + 1]) = (constant + load.value, load.slope);
        }
        let Some(conditions) = self.behind_drive(state, from, &mut z) else { return WholeStep::Unknown };
        let kind = Kind::new(force, &conditions);
        let Some(map) = workspace.maps.known(&kind, duration) else { return WholeStep::Unknown };
        let after = map.after(&z, self.terms.cubic, self.output_effects.is_empty());
        let Some(after) = after.filter(|after| after.iter().fold(true, |all, state| all & state.is_finite())) else {
            return WholeStep::Unknown;
        };
        let drive = [after[POLE], after[POSITION], after[RATE]];
        if self.has_events_of_motion && !self.lasts(course, drive, conditions[0], map) {
            return WholeStep::MeetsEvent;
        }
        [state.pole, state.position, state.rate] = drive;
        state.saturated = mode.is_saturated();
        if !self.output_effects.is_empty() {
            state.memory[FIRST_INTEGRATED..].copy_from_slice(&after[REMEMBERED..STATES]);
        }
        WholeStep::Done
    }

    /// True if the mode of the drive and the condition of the first effect behind it hold up to x, δ and v at the end.
    #[inline]
    fn lasts(
        &self,
        course: &Course,
        [after, position, rate]: [f64; 3],
        condition: EventCondition,
        map: &LinearMap,
    ) -> bool {
        let Course { mode, from, pole, demand, load } = course;
        let ends = Ends {
            target: [*pole, after],
            target_bend: self.bend_of_target(*pole, [demand.value, demand.slope, 0.0], map.length),
            load: [load.value, load.at(map.length)],
            drive: [DriveState { position: from.position, rate: from.rate }, DriveState { position, rate }],
        };
        self.holds(mode, condition, &ends, map)
    }
}
