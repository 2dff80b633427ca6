//! Partial derivatives at an instant: of derivatives and outputs with respect to continuous states and inputs, in the present modes.

use fmi_export::Result;

use super::{
    actuator_model::ActuatorModel,
    model_exchange::{INTEGRATED_STATES, STATES},
    variables::Slot,
};
use crate::actuator::{FIRST_INTEGRATED, Outputs, StateDerivatives};

/// Half the distance of a central difference, relative to the quantity (at least a typical one). Within a mode the equations are linear
/// except for the cubic spring, so that the truncation error is negligible.
const DIFFERENCE: f64 = 1e-4;

impl ActuatorModel {
    /// Central difference of an unknown with respect to a known.
    pub(super) fn at_instant(&self, unknown: Slot, known: Slot) -> Result<f64> {
        let present = match known {
            Slot::State(index) => self.continuous_states()[index],
            Slot::Load => self.memory.load.value(),
            _ => self.memory.command.value(),
        };
        let by = DIFFERENCE * present.abs().max(self.unit.typical());
        let (above, below) = (self.changed(unknown, known, by)?, self.changed(unknown, known, -by)?);
        Ok((above - below) / (2.0 * by))
    }

    /// The unknown with the known changed by this amount.
    fn changed(&self, unknown: Slot, known: Slot, by: f64) -> Result<f64> {
        let (actuator, state) = self.initialized()?;
        let mut state = state.clone();
        let mut inputs = [self.memory.command.value(), self.memory.load.value()];
        match known {
            Slot::State(0) => state.pole += by,
            Slot::State(1) => state.position += by,
            Slot::State(2) => state.rate += by,
            Slot::State(index) => state.memory[FIRST_INTEGRATED + index - INTEGRATED_STATES] += by,
            Slot::Load => inputs[1] += by,
            _ => inputs[0] += by,
        }
        let Outputs { position, deflection, rate, .. } = actuator.outputs(&state);
        match (unknown, &self.memory.exchange) {
            (Slot::Slope(index), Some(exchange)) => {
                let inputs = exchange.evaluate_inputs(actuator, &state, inputs);
                let StateDerivatives { pole, position, rate, memory } =
                    actuator.derivatives(&state, &exchange.modes, &inputs);
                let mut derivatives = [0.0; STATES];
                derivatives[..INTEGRATED_STATES].copy_from_slice(&[pole, position, rate]);
                derivatives[INTEGRATED_STATES..].copy_from_slice(&memory);
                Ok(derivatives[index])
            }
            (Slot::Rate, _) => Ok(rate),
            (Slot::Deflection, _) => Ok(deflection),
            _ => Ok(position),
        }
    }
}
