//! The state of an actuator.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{
    command::History,
    effects::MEMORY,
    transition::{Ramp, Transition},
};

/// Everything that changes during a simulation: plain data that can be cloned, saved and compared.
///
/// Pole state, position and rate do not lie side by side: two that one step writes one by one and the next one reads at once would make
/// the processor wait for the writes.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct State {
    /// Pole state x [deg]; k c for order 2.
    pub pole: f64,
    /// Time since the start [s].
    pub time: f64,
    /// Position δ of the drive [deg].
    pub position: f64,
    /// A limit was active at some time during the last step.
    pub saturated: bool,
    /// Rate δ̇ of the drive [deg/s].
    pub rate: f64,
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

    /// Advances x, δ and δ̇ by a linear transition. Where the result is not finite, nothing changes and it is false.
    #[inline]
    pub(super) fn linear_step(&mut self, transition: &Transition, command: Ramp) -> bool {
        let after = transition.apply(Vector3::new(self.pole, self.position, self.rate), command);
        // One comparison, but for numbers whose sum overflows.
        if !(after.sum().abs() < f64::INFINITY || is_finite(after)) {
            return false;
        }
        (self.pole, self.position, self.rate) = (after.x, after.y, after.z);
        true
    }

    /// The same under a constant load, which shifts the equilibrium by its value [deg].
    pub(super) fn loaded_step(&mut self, transition: &Transition, command: Ramp, load: f64) -> bool {
        let position = self.position;
        self.position -= load;
        let is_finite = self.linear_step(transition, command);
        self.position = if is_finite { self.position + load } else { position };
        is_finite
    }
}

#[cold]
fn is_finite(numbers: Vector3<f64>) -> bool {
    numbers.iter().all(|number| number.is_finite())
}
