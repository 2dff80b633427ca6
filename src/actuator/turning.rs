//! A step under a held command with a rate-independent effect behind a linear drive, for approximate simulations in a search: only the
//! positions at the ends of the step and at the reversal of the drive matter.

use nalgebra::Vector3;

use super::{constants::Actuator, state::State, workspace::Workspace};
use crate::{
    motion::LONGEST_BETWEEN_ENDS,
    operator::Signal,
    parameters::Order,
    transition::{Ramp, Transition},
};

/// Tolerance of the reversal time as a fraction of the step: the error of the position there scales with its third power.
const SHARE_OF_STEP: f64 = 0.005;
const MOST_ITERATIONS: usize = 8;

/// Maximum number of parts of a step, with one reversal of the drive in each.
const MOST_PARTS: f64 = 16.0;

/// Motion of the drive through a step.
enum Course {
    Straight,
    /// Via this position [deg].
    Turning(f64),
}

/// A drive under a held command and a constant load.
struct Drive<'a> {
    actuator: &'a Actuator,
    /// x, δ minus load, v at the start.
    before: Vector3<f64>,
    command: f64,
    /// Its target [deg].
    demand: f64,
}

impl Actuator {
    /// Advances the state by a step [s] for this output of the command side and this load [deg]. False, with nothing changed, if the
    /// actuator or the command is not of this kind or the drive may reverse more than once.
    pub(super) fn step_by_turns(
        &self,
        state: &mut State,
        workspace: &mut Workspace,
        (command, load): (Signal, Ramp),
        duration: f64,
    ) -> bool {
        let is_held = command.slope == 0.0 && load.slope == 0.0;
        if !self.is_led_by_turns || !is_held {
            return false;
        }
        let parts = (self.natural_frequency * duration / LONGEST_BETWEEN_ENDS).ceil().max(1.0);
        if parts > MOST_PARTS {
            return false;
        }
        let (command, load) = (command.value, self.terms.bias + load.value);
        let start = (state.pole, state.position, state.rate, state.memory);
        let mut left = parts;
        while left > 0.0 && self.part_by_turns(state, workspace, (command, load), duration / parts) {
            left -= 1.0;
        }
        if left > 0.0 {
            (state.pole, state.position, state.rate, state.memory) = start;
            return false;
        }
        state.saturated = false;
        true
    }

    /// As above, for a part with at most one reversal; if false, the state is inconsistent.
    fn part_by_turns(
        &self,
        state: &mut State,
        workspace: &mut Workspace,
        (command, load): (f64, f64),
        duration: f64,
    ) -> bool {
        let [effect] = self.output_effects.as_slice() else { return false };
        let before = Vector3::new(state.pole, state.position - load, state.rate);
        if !state.loaded_step(workspace.transition(self, duration), Ramp::held(command), load) {
            return false;
        }
        let after = Vector3::new(state.pole, state.position - load, state.rate);
        let memory = &mut state.memory[effect.memory..];
        match (Drive { actuator: self, before, command, demand: self.base.k() * command }).course(after, duration) {
            Some(Course::Straight) => {}
            Some(Course::Turning(position)) => effect.operator.follow(&effect.parameters, memory, position + load),
            None => return false,
        }
        effect.operator.follow(&effect.parameters, memory, state.position);
        true
    }
}

impl Drive<'_> {
    /// The motion up to this state after a time [s]; `None` if the drive may reverse more than once.
    fn course(&self, after: Vector3<f64>, duration: f64) -> Option<Course> {
        let (first, last) = (self.before.z, after.z);
        let end = self.acceleration(after);
        if first * last < 0.0 {
            return self.turn(last, end, duration).map(Course::Turning);
        }
        // A rate towards zero at first and away from it at the end; the target may reach its final value early.
        let direction = if first == 0.0 { last } else { first }.signum();
        let at_once = Vector3::new(self.demand, self.before.y, first);
        let early = [self.before, at_once].map(|state| direction * self.acceleration(state));
        let (early, late) = (early[0].min(early[1]), direction * end);
        let dips = early < 0.0 && late > 0.0;
        let least = first.abs().min(last.abs());
        (!dips || least > 0.5 * (late - early) * duration).then_some(Course::Straight)
    }

    /// [deg/s²]
    fn acceleration(&self, state: Vector3<f64>) -> f64 {
        let terms = &self.actuator.terms;
        let target = if self.actuator.order == Order::Second { self.demand } else { state.x };
        terms.omega2 * (target - state.y) - terms.damping * state.z
    }

    /// Position at the reversal, by Newton's method with a bracket between rates of opposite sign; starts from rate and acceleration at the
    /// end.
    fn turn(&self, last: f64, end: f64, duration: f64) -> Option<f64> {
        let Self { actuator, before, command, .. } = self;
        let first = before.z;
        // The rate as a parabola through both rates with the acceleration at the end; its root is this long before the end.
        let bend = (first - last + end * duration) / (duration * duration);
        let root = (end * end - 4.0 * bend * last).max(0.0).sqrt();
        let until_end = 2.0 * last / (end + root.copysign(last * end));
        let is_inside = until_end > 0.0 && until_end < duration;
        let mut time = if is_inside { duration - until_end } else { duration * first / (first - last) };
        let (mut low, mut high) = (0.0, duration);
        for _ in 0..MOST_ITERATIONS {
            let state = Transition::new(actuator.base, actuator.order, time).apply(*before, Ramp::held(*command));
            let change = -state.z / self.acceleration(state);
            if change.abs() < SHARE_OF_STEP * duration {
                return Some(state.y + 0.5 * state.z * change);
            }
            if state.z * first > 0.0 {
                low = time
            } else {
                high = time
            }
            time = if (low..high).contains(&(time + change)) { time + change } else { 0.5 * (low + high) };
        }
        None
    }
}
