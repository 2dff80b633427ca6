//! The state of an actuator.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{
    command::History,
    effects::MEMORY,
    transition::{Ramp, Transition},
};

/// Everything that changes during a simulation: plain data that can be cloned, saved and compared.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Time since the start [s].
    pub time: f64,
    /// Pole state x [deg]; k c for order 2.
    pub pole: f64,
    /// Position δ of the drive [deg].
    pub position: f64,
    /// Rate δ̇ of the drive [deg/s].
    pub rate: f64,
    /// A limit was active at some time during the last step.
    pub saturated: bool,
    /// Memory of the effects, in the order of the chain.
    pub memory: [f64; MEMORY],
    /// Past command, over the length of the delay.
    pub history: History,
}

impl Clone for State {
    fn clone(&self) -> Self {
        Self { history: self.history.clone(), ..self.without_history() }
    }

    /// Without allocation, where the history has the room.
    #[inline]
    fn clone_from(&mut self, source: &Self) {
        self.history.clone_from(&source.history);
        self.set_all_but_history(source);
    }
}

impl State {
    /// The same with an empty history.
    #[must_use]
    pub fn without_history(&self) -> Self {
        let Self { time, pole, position, rate, saturated, memory, history: _ } = *self;
        Self { time, pole, position, rate, saturated, memory, history: History::default() }
    }

    /// Everything as in another state, but for the history.
    #[inline]
    pub fn set_all_but_history(&mut self, source: &Self) {
        let Self { time, pole, position, rate, saturated, memory, history: _ } = *source;
        (self.time, self.pole, self.position, self.rate) = (time, pole, position, rate);
        (self.saturated, self.memory) = (saturated, memory);
    }

    /// Advances x, δ and δ̇ by a linear transition, under a constant load, which shifts the equilibrium by its value [deg]. Where the
    /// result is not finite, nothing changes and it is false.
    #[inline]
    pub(super) fn linear_step(&mut self, transition: &Transition, command: Ramp, load: f64) -> bool {
        let before = Vector3::new(self.pole, self.position - load, self.rate);
        let after = transition.apply(before, command);
        let is_finite = after.x.is_finite() && after.y.is_finite() && after.z.is_finite();
        if is_finite {
            (self.pole, self.position, self.rate) = (after.x, after.y + load, after.z);
        }
        is_finite
    }
}
