//! Makes a Rust model an FMI 2.0 unit, for co-simulation and model exchange.
//!
//! A model implements [`Model`], which is safe code and needs few lines where a model can do little. [`export!`] in the model's
//! crate defines all C functions of FMI 2.0 as symbols of its shared library:
//!
//! ```text
//! pub struct Lag { .. }
//! impl fmi_export::Model for Lag { .. }
//! fmi_export::export!(Lag);
//! ```
//!
//! In reading order: [`Variable`] (what an importer sees), [`Model`], [`Instance`] (its life: which call is legal when, checked
//! values, saved states), and `abi`, the C boundary. Everything unsafe stands there and in what `export!` expands to.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod abi;
mod calls;
mod error;
mod exchange;
mod export;
mod instance;
mod log;
mod model;
mod request;
mod snapshot;
mod variable;

#[doc(hidden)] // for the macro
pub use libc;

pub use calls::{Kind, Phase};
pub use error::{Error, Result};
pub use instance::Instance;
pub use log::{CATEGORIES, Message, Status};
pub use model::{Discrete, Model};
pub use request::Request;
pub use variable::{Causality, Enumeration, Type, Value, Variability, Variable, index_of};
