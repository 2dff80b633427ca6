//! The actuator as an FMI 2.0 model, for co-simulation and model exchange.
//!
//! [`variables`] is the one list of what an importer sees; value references, checks, XML and GUID are derived from it. [`Settings`] are the
//! parameters. [`ActuatorModel`] is the model that the crate [`fmi_export`] exports (`interface`): `access` gets and sets its variables,
//! `model_exchange` is its part in model exchange, `memory` the content of a saved state. [`Slave`] is an instance with its phases and
//! checks; the C functions are in [`fmi2`].

mod access;
mod actuator_model;
mod guid;
mod identifier;
mod interface;
mod last_step;
mod memory;
mod model_exchange;
mod model_exchange_state;
mod partial_derivatives;
mod settings;
mod start;
mod start_values;
mod step;
pub mod units;
pub mod variables;

pub use actuator_model::ActuatorModel;
pub use fmi_export::{CATEGORIES, Value};
pub use guid::guid;
pub use identifier::{MODEL_IDENTIFIER, MODEL_RESOURCE};
pub use settings::{Settings, Source};
pub use start::Start;
pub use start_values::start_value;

/// An instance.
pub type Slave = fmi_export::Instance<ActuatorModel>;

fmi_export::export!(ActuatorModel);

impl From<crate::error::Error> for fmi_export::Error {
    fn from(error: crate::error::Error) -> Self {
        Self::from_message(error.to_string())
    }
}
