//! Names shared by importer, packager and binary.

/// Name of the model, of its binary and of the archive.
pub const MODEL_IDENTIFIER: &str = "BactActuator";

/// Number of the equations: raised with every change of what an instance computes, so that no tool takes the binary of other equations
/// for this one. `tests/behaviour.rs` notices such a change.
pub const BEHAVIOUR: u32 = 1;

/// Path below `resources/` of the model file of an FMU that is not the default one.
pub const MODEL_RESOURCE: &str = "model.toml";
