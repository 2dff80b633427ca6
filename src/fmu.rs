//! The actuator as an FMI 2.0 co-simulation slave.
//!
//! [`variables`] lists what an importer sees, once for the unit and for its XML; [`Settings`] are the parameters; [`Unit`] is
//! the model that the crate [`fmi_export`] makes an FMU of, `access` its variables, `memory` what a saved state holds;
//! `description` renders the XML. [`Slave`] is an instance, with its life and its checks; the C functions are in [`fmi2`].

mod access;
mod exchange;
mod guid;
mod memory;
mod settings;
mod unit;
pub mod variables;

pub use fmi_export::{CATEGORIES, Value};
pub use guid::guid;
pub use memory::start_value;
pub use settings::{Settings, Source};
pub use unit::Unit;

/// An instance.
pub type Slave = fmi_export::Instance<Unit>;

fmi_export::export!(Unit);

impl From<crate::Error> for fmi_export::Error {
    fn from(error: crate::Error) -> Self {
        Self::said(error.to_string())
    }
}

/// Name of the model, of its binary and of the archive.
pub const MODEL_IDENTIFIER: &str = "BactActuator";

/// Where the packager puts the model file of an FMU that is not the default one, below `resources/`.
pub const MODEL_RESOURCE: &str = "model.toml";
