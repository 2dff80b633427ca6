//! The state of an actuator.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{
    command::Knot,
    effects::MEMORY,
    transition::{Ramp, Transition},
};

/// Everything that changes during a simulation: plain data that can be cloned, saved and compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Time since the start [s].
    pub time: f64,
    /// Pole state x [deg]; k c for order 2.
    pub pole: f64,
    /// Position δ of the drive [deg].
    pub position: f64,
    /// Rate δ̇ of the drive [deg/s].
    pub rate: f64,
    /// A limit was active at the end of the last step.
    pub saturated: bool,
    /// Memory of the effects, in the order of the chain.
    pub memory: [f64; MEMORY],
    /// Past command, over the length of the delay.
    pub history: Vec<Knot>,
}

impl State {
    /// Advances x, δ and δ̇ by a linear transition, under a constant load, which shifts the equilibrium by its value [deg].
    pub(super) fn linear_step(&mut self, transition: &Transition, command: Ramp, load: f64) {
        let before = Vector3::new(self.pole, self.position - load, self.rate);
        let after = transition.apply(before, command);
        (self.pole, self.position, self.rate) = (after.x, after.y + load, after.z);
        self.saturated = false;
    }
}
