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
/// Pole state, position and rate are not adjacent: reading two at once that were written one by one in the previous step would stall the
/// processor (store forwarding).
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct State {
    /// Pole state x \[deg\]; k c for order 2.
    pub pole: f64,
    /// Time since the start \[s\].
    pub time: f64,
    /// Position δ of the drive \[deg\].
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

    /// Without allocation if the capacity of the history suffices.
    #[inline]
    fn clone_from(&mut self, source: &Self) {
        self.history.clone_from(&source.history);
        self.set_all_but_history(source);
    }
}

impl State {
    /// A copy with an empty history.
    #[must_use]
    pub fn without_history(&self) -> Self {
        let Self { time, pole, position, rate, saturated, memory, history: _ } = *self;
        Self { time, pole, position, rate, saturated, memory, history: History::default() }
    }

    /// Copies everything but the history from another state.
    #[inline]
    pub fn set_all_but_history(&mut self, source: &Self) {
        let Self { time, pole, position, rate, saturated, memory, history: _ } = *source;
        (self.time, self.pole, self.position, self.rate) = (time, pole, position, rate);
        (self.saturated, self.memory) = (saturated, memory);
    }

    /// Advances x, δ and δ̇ by a linear transition; false, with nothing changed, if the result is not finite.
    #[inline]
    pub(super) fn linear_step(&mut self, transition: &Transition, command: Ramp) -> bool {
        let after = transition.apply(Vector3::new(self.pole, self.position, self.rate), command);
        // One comparison, except for numbers whose sum overflows.
        if !(after.sum().abs() < f64::INFINITY || is_finite(after)) {
            return false;
        }
        (self.pole, self.position, self.rate) = (after.x, after.y, after.z);
        true
    }

    /// As above under a constant load, which shifts the equilibrium by its value [deg].
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
