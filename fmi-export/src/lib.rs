//! Makes a Rust model an FMI 2.0 unit, for co-simulation and model exchange.
//!
//! A model implements [`Model`] in safe code, limited to the capabilities it offers. [`export!`] in the model's crate defines all C
//! functions of FMI 2.0 as symbols of its shared library:
//!
//! ```text
//! pub struct Lag { .. }
//! impl fmi_export::Model for Lag { .. }
//! fmi_export::export!(Lag);
//! ```
//!
//! The README shows a whole model.
//!
//! In reading order: [`Variable`] and [`Variables`] (what an importer sees), [`description`] (`modelDescription.xml` from that list), [`Model`],
//! [`Instance`] (phases and legal calls, checked values, saved states), and [`abi`], the boundary to C and the system. All unsafe code is there
//! and in the expansion of `export!`.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod abi;
mod calls;
pub mod description;
mod error;
mod export;
mod instance;
mod lifecycle;
mod log;
mod model;
mod request;
mod saved_states;
mod serialization;
mod variable;
mod variables;

#[doc(hidden)] // for the macro
pub use libc;

pub use calls::{Kind, Phase};
pub use error::{Error, Result};
pub use instance::Instance;
pub use log::{CATEGORIES, Message, Status};
pub use model::{EventUpdate, Model};
pub use request::Request;
pub use variable::{Causality, Enumeration, Type, Value, Variability, Variable, index_of};
pub use variables::Variables;

#[cfg(test)]
mod tests {
    #[test]
    fn the_readme_shows_the_example_that_is_compiled() {
        let (_, model) = include_str!("../examples/lag.rs").split_once("#![allow(missing_docs)]\n\n").unwrap();
        assert!(include_str!("../README.md").contains(model));
    }
}
