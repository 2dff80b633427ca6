//! The functions of FMI 2.0, one for one, for any model, in safe code: unsafe code is in `arrays` and `host`.
#![allow(non_snake_case, missing_docs)] // names and meaning as in the standard

mod co_simulation;
mod common;
mod model_exchange;
mod saved_states;

pub use co_simulation::*;
pub use common::*;
pub use model_exchange::*;
pub use saved_states::*;
