//! Names shared by importer, packager and binary.

/// Name of the model, of its binary and of the archive.
pub const MODEL_IDENTIFIER: &str = "BactActuator";

/// Path below `resources/` of the model file of an FMU that is not the default one.
pub const MODEL_RESOURCE: &str = "model.toml";
