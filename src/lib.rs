//! Measured actuators as FMI 2.0 units, for co-simulation and model exchange.
//!
//! In reading order: [`parameters`] (the 17 identified sets and model files), [`transition`] (the exact linear part; by a matrix
//! `exponential` next to a double pole), [`effects`] (the signal chain), [`command`] and [`motion`] (how effects act on the command and on
//! the drive), [`series`], [`actuator`] (constants, memory, step), [`fmu`] (the actuator as an FMU; the C boundary is the crate
//! `fmi_export`).
//!
//! Equations (1) and (6) and all numbers are those of NASA/TM-1998-208452.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod actuator;
pub mod command;
pub mod effects;
pub mod error;
mod exponential;
pub mod fmu;
pub mod motion;
pub mod operator;
pub mod parameters;
pub mod series;
pub mod transition;

pub use error::{Error, Result};
