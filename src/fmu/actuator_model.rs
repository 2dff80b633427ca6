//! The model type exported by [`fmi_export`]. Its methods are in `access`, `model_exchange` and `interface`.

use std::cell::Cell;

use fmi_export::{Error, Kind, Result};

use super::memory::Memory;
use crate::{
    actuator::{Actuator, Outputs, State, Workspace},
    parameters::PositionUnit,
};

/// One actuator: its memory and derived data.
pub struct ActuatorModel {
    pub(super) kind: Kind,
    /// Unit of positions.
    pub(super) unit: PositionUnit,
    pub(super) memory: Memory,
    /// From the end of initialization on.
    pub(super) actuator: Option<Actuator>,
    pub(super) workspace: Workspace,
    /// For the present state; `None` if it has changed since they were requested.
    pub(super) outputs: Cell<Option<Outputs>>,
    /// Messages for the host about the last step.
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

    /// The actuator and its state after initialization.
    pub(super) fn initialized(&self) -> Result<(&Actuator, &State)> {
        self.actuator
            .as_ref()
            .zip(self.memory.state.as_ref())
            .ok_or_else(|| Error::new("instance", "no parameters in use", "an initialized instance"))
    }
}
