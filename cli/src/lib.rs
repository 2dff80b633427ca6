//! The parts of the program `actuator`: files, packaging and stepping FMUs, campaigns, pages, commands.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod campaign;
pub mod commands;
pub mod description;
mod export;
pub mod files;
pub mod gap;
pub mod importer;
mod interruption;
pub mod invocation;
pub mod output;
pub mod package;
pub mod progress;
pub mod references;
pub mod report;
mod schemas;
pub mod ssp;
pub mod template;
pub mod workflow;
mod xml;
