//! The type that [`fmi_export`] makes an FMU of. Its methods are in `access`, `model_exchange` and `interface`.

use std::cell::Cell;

use fmi_export::{Error, Kind, Result};

use super::memory::Memory;
use crate::{
    actuator::{Actuator, Outputs, State, Workspace},
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
    /// Of the present state; none where it has changed since they were asked for.
    pub(super) outputs: Cell<Option<Outputs>>,
    /// What the host should know of the last step.
    pub(super) warning: Option<&'static str>,
}

impl ActuatorModel {
    /// As after instantiation.
    pub(super) fn with_memory(kind: Kind, unit: PositionUnit, memory: Memory) -> Self {
        Self {
            kind,
            unit,
            memory,
            actuator: None,
            workspace: Workspace::default(),
            outputs: Cell::new(None),
            warning: None,
        }
    }

    /// The actuator and its state, once initialized.
    pub(super) fn initialized(&self) -> Result<(&Actuator, &State)> {
        self.actuator
            .as_ref()
            .zip(self.memory.state.as_ref())
            .ok_or_else(|| Error::new("instance", "no parameters in use", "an initialized instance"))
    }
}
