//! A model through a command, without an FMU.

use crate::{
    actuator::{Actuator, State, Transitions},
    parameters::Model,
    signal::{Command, Interpolation, Response},
};

/// Response of the model, from rest at 0 deg, at the times of the command.
#[must_use]
pub fn simulate(model: &Model, command: &Command, interpolation: Interpolation) -> Response {
    let actuator = Actuator::new(model.base, model.order);
    let mut state = State::at_rest(0.0);
    let mut transitions = Transitions::default();
    let mut states = vec![state];
    for step in command.steps(interpolation) {
        actuator.step(&mut state, &mut transitions, step.command, step.duration);
        states.push(state);
    }
    let position: Vec<f64> = states.iter().map(|state| state.position).collect();
    Response { deflection: position.clone(), rate: states.iter().map(|state| state.rate).collect(), position }
}
