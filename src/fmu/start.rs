//! What an instance starts with: start values, and identity of the model.

use super::settings::Settings;
use crate::parameters::{Identity, Model};

/// Start values with the identity of their model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Start {
    /// Start values.
    pub settings: Settings,
    /// Name, description, unit of positions.
    pub identity: Identity,
}

impl Start {
    /// For an FMU generated for a model.
    #[must_use]
    pub fn from_model(model: &Model) -> Self {
        Self { settings: Settings::from_model(model), identity: model.identity.clone() }
    }
}
