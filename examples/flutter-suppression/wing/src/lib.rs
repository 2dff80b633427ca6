//! The BACT wing on its pitch-and-plunge mount, with the published control law, as the FMU `BactWing`: the plant of the loop
//! around `BactActuator`.
//!
//! In reading order: [`equations`] (the wing and its control law as a linear system), [`transition`] (that system over a
//! finite time, exactly), [`interface`] (the FMU).

#![cfg_attr(test, allow(clippy::unwrap_used))] // tests may

mod description;
pub mod equations;
pub mod interface;
pub mod transition;

pub use description::description;
pub use interface::BactWing;

fmi_export::export!(BactWing);
