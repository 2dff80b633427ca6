//! Response of a model to a command, without an FMU.

use crate::signal::{Command, Interpolation, Response};
use actuator_fmu::{
    actuator::{Actuator, Inputs, Outputs, Workspace},
    error::Result,
    parameters::Model,
};

/// Response of the model, from rest at 0 deg, at the times of the command.
///
/// # Errors
/// A divergent motion.
pub fn simulate(model: &Model, command: &Command, interpolation: Interpolation) -> Result<Response> {
    let actuator = Actuator::new(model.base, model.order, &model.effects);
    let mut state = actuator.at_rest(0.0);
    let mut workspace = Workspace::default();
    let mut response = Response::default();
    let mut add = |Outputs { position, deflection, rate, .. }| {
        response.position.push(position);
        response.deflection.push(deflection);
        response.rate.push(rate);
    };
    add(actuator.outputs(&state));
    for step in command.steps(interpolation) {
        actuator.step(&mut state, &mut workspace, Inputs::command(step.command), step.duration)?;
        add(actuator.outputs(&state));
    }
    Ok(response)
}
