//! Measured actuators as FMI 2.0 units, for co-simulation and model exchange.
//!
//! In reading order: [`parameters`] (the 17 identified sets and model files), [`transition`] (the linear part, exactly),
//! [`effects`] (the signal chain), [`command`] and [`motion`] (what effects do to the command and to the drive), [`series`],
//! [`actuator`] (constants, memory, step), [`frequency`] (responses), [`fmu`] (the actuator as an FMU; the C
//! boundary is the crate `fmi_export`), and for the command line `signal`, `estimate`, `diagnose`, `importer` and `report`.
//!
//! Equations (1) and (6) and all numbers are those of NASA/TM-1998-208452.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod actuator;
pub mod command;
pub mod effects;
mod error;
pub mod fmu;
pub mod frequency;
pub mod motion;
pub mod operator;
pub mod parameters;
pub mod series;
pub mod transition;

#[cfg(feature = "cli")]
pub mod campaign;
#[cfg(feature = "cli")]
pub mod compare;
#[cfg(feature = "cli")]
pub mod diagnose;
#[cfg(feature = "cli")]
pub mod estimate;
#[cfg(feature = "cli")]
pub mod files;
#[cfg(feature = "cli")]
pub mod generated;
#[cfg(feature = "cli")]
pub mod importer;
#[cfg(feature = "cli")]
pub mod least_squares;
#[cfg(feature = "cli")]
pub mod package;
#[cfg(feature = "cli")]
pub mod references;
#[cfg(feature = "cli")]
pub mod report;
#[cfg(feature = "cli")]
pub mod signal;
#[cfg(feature = "cli")]
pub mod simulate;
#[cfg(feature = "cli")]
pub mod ssp;
#[cfg(feature = "cli")]
mod xml;

pub use error::{Error, Result};
