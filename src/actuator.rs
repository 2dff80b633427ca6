//! The actuator: constants in [`Actuator`], memory in [`State`], and the step from one communication point to the next.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::{
    parameters::{Base, Order},
    transition::{Ramp, Transition},
};

/// What does not change while it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Actuator {
    base: Base,
    order: Order,
}

/// What does: plain data, to be cloned, saved and compared.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Pole state x [deg]; k c for order 2.
    pub pole: f64,
    /// Position δ [deg].
    pub position: f64,
    /// Rate δ̇ [deg/s].
    pub rate: f64,
}

impl State {
    /// At rest at a position [deg].
    #[must_use]
    pub fn at_rest(position: f64) -> Self {
        Self { pole: position, position, rate: 0.0 }
    }
}

/// Transitions of the step sizes met lately. Masters repeat one step size, or a few that differ in the last bits.
#[derive(Debug, Clone, Default)]
pub struct Transitions {
    recent: Vec<Transition>,
    oldest: usize,
}

impl Transitions {
    const KEPT: usize = 4;

    fn get(&mut self, actuator: &Actuator, duration: f64) -> &Transition {
        let known = self.recent.iter().position(|transition| transition.duration() == duration);
        let index = known.unwrap_or_else(|| {
            let made = Transition::new(actuator.base, actuator.order, duration);
            if self.recent.len() < Self::KEPT {
                self.recent.push(made);
                return self.recent.len() - 1;
            }
            let index = self.oldest;
            self.oldest = (index + 1) % Self::KEPT;
            self.recent[index] = made;
            index
        });
        &self.recent[index]
    }

    /// To be called when the parameters change.
    pub fn forget(&mut self) {
        self.recent.clear();
        self.oldest = 0;
    }
}

impl Actuator {
    /// Eq. (1) or eq. (6) with these parameters.
    #[must_use]
    pub fn new(base: Base, order: Order) -> Self {
        Self { base, order }
    }

    /// Its parameters.
    #[must_use]
    pub fn base(&self) -> &Base {
        &self.base
    }

    /// Second or third order.
    #[must_use]
    pub fn order(&self) -> Order {
        self.order
    }

    /// Moves the state through `duration` [s] > 0 under a held or linear command, exactly.
    pub fn step(&self, state: &mut State, transitions: &mut Transitions, command: Ramp, duration: f64) {
        let before = Vector3::new(state.pole, state.position, state.rate);
        let after = transitions.get(self, duration).apply(before, command);
        *state = State { pole: after.x, position: after.y, rate: after.z };
    }

    /// Acceleration δ̈ [deg/s²] in this state under this command.
    #[must_use]
    pub fn acceleration(&self, state: &State, command: f64) -> f64 {
        let omega = self.base.omega();
        let servo = match self.order {
            Order::Second => self.base.k() * command,
            Order::Third => state.pole,
        };
        omega * omega * (servo - state.position) - 2.0 * self.base.zeta() * omega * state.rate
    }

    /// ∂(position, rate) at the end of a step of this duration by the command held through it.
    #[must_use]
    pub fn by_command(&self, duration: f64) -> (f64, f64) {
        let change = Transition::new(self.base, self.order, duration).by_command();
        (change.y, change.z)
    }
}
