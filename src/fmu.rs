//! The actuator as an FMI 2.0 co-simulation slave.
//!
//! [`variables`] lists what an importer sees, once for the slave and for its XML; [`Settings`] are the parameters;
//! [`Slave`] is the slave itself, in safe code, `access` its variables, `memory` and `snapshot` its saved state; `calls` is
//! the table of legal calls.
//! `abi` is the C boundary and the only unsafe code of this crate; `description` renders the XML.

mod abi;
mod access;
mod calls;
#[cfg(feature = "cli")]
pub mod description;
mod guid;
mod log;
mod memory;
mod settings;
mod slave;
mod snapshot;
pub mod variables;

pub use guid::guid;
pub use log::CATEGORIES;
pub use memory::Value;
pub use settings::{Settings, Source};
pub use slave::Slave;

/// Name of the model, of its binary and of the archive.
pub const MODEL_IDENTIFIER: &str = "BactActuator";

/// Where the packager puts the model file of an FMU that is not the default one, below `resources/`.
pub const MODEL_RESOURCE: &str = "model.toml";
