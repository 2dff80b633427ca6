//! Names shared by importer, packager and binary.

/// Name of the model, of its binary and of the archive.
pub const MODEL_IDENTIFIER: &str = "BactActuator";

/// Version number of the equations: incremented with every change of what an instance computes, so that no tool mistakes the binary of
/// other equations for this one. `tests/behaviour.rs` detects such a change.
pub const BEHAVIOUR: u32 = 1;

/// Path of the model file below `resources/`, for FMUs other than the default one.
pub const MODEL_RESOURCE: &str = "model.toml";
