//! The BACT wing on its pitch-and-plunge mount, with the published control law, as the FMU `BactWing`: the other half of the
//! loop around `BactActuator`.
//!
//! In reading order: [`equations`] (the wing and its control law as a linear system), [`transition`] (that system over a
//! finite time, exactly), [`unit`] (the FMU).

#![cfg_attr(test, allow(clippy::unwrap_used))] // tests may

pub mod equations;
pub mod transition;
pub mod unit;

pub use unit::BactWing;

fmi_export::export!(BactWing);
