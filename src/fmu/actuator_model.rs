//! The type that [`fmi_export`] makes an FMU of. Its methods are in `access`, `model_exchange` and `interface`.

use fmi_export::{Error, Kind, Result};

use super::memory::Memory;
use crate::{
    actuator::{Actuator, State, Workspace},
    parameters::PositionUnit,
};

/// One actuator: its memory, and what follows from it.
pub struct ActuatorModel {
    pub(super) kind: Kind,
    /// Of positions.
    pub(super) unit: PositionUnit,
    pub(super) memory: Memory,
    /// From the end of initialization on.
    pub(super) actuator: Option<Actuator>,
    pub(super) workspace: Workspace,
}

impl ActuatorModel {
    /// As after instantiation.
    pub(super) fn with_memory(kind: Kind, unit: PositionUnit, memory: Memory) -> Self {
        Self { kind, unit, memory, actuator: None, workspace: Workspace::default() }
    }

    /// The actuator and its state, once initialized.
    pub(super) fn initialized(&self) -> Result<(&Actuator, &State)> {
        self.actuator
            .as_ref()
            .zip(self.memory.state.as_ref())
            .ok_or_else(|| Error::new("instance", "no parameters in use", "an initialized instance"))
    }
}
