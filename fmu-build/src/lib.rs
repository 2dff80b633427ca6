//! Packages any Rust library that exports the FMI 2.0 functions as an FMU: a zip archive of a description, one shared
//! library per platform, documentation, licences and resources.
//!
//! It is independent of the model. The content is declared in the `Cargo.toml` of the model:
//!
//! ```toml
//! [package.metadata.fmu]
//! model-identifier = "Pendulum"
//! description = "modelDescription.xml"
//! ```
//!
//! and packaged by one call, or by `fmu-build` on the command line:
//!
//! ```no_run
//! let fmu = fmu_build::build(".", &fmu_build::Options::default())?;
//! println!("{}", fmu.display()); // target/fmu/Pendulum.fmu
//! # Ok::<(), fmu_build::Error>(())
//! ```
//!
//! An FMU with other content and the same binary is a new archive, not a new compilation:
//!
//! ```no_run
//! # use fmu_build::{Archive, Overwrite};
//! let mut archive = Archive::read("target/fmu/Pendulum.fmu")?;
//! archive.insert("resources/model.toml", "length = 2.0")?;
//! archive.write("long-pendulum.fmu", Overwrite::Refuse)?;
//! # Ok::<(), fmu_build::Error>(())
//! ```
//!
//! In reading order:
//!
//! - [`build`](mod@build): the whole process, in one screen;
//! - [`manifest`]: what the package declares about its FMU;
//! - [`compile`]: the shared library, built by cargo;
//! - [`linker`]: this computer's linker or zig;
//! - [`Package`]: the content, and all checks on it;
//! - [`Archive`]: the entries and their bytes, the same on every machine;
//! - [`Platform`]: folder, extension and compiler target of a binary;
//! - [`Error`]: every failure, with its remedy.

#![forbid(unsafe_code)]
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod archive;
mod atomic;
pub mod build;
mod cargo;
pub mod compile;
mod description;
mod error;
mod folder;
pub mod linker;
pub mod manifest;
pub mod package;
pub mod platform;

pub use archive::Archive;
pub use atomic::{Overwrite, TEMPORARY_PREFIX, write, write_all};
pub use build::{Options, assemble, build};
pub use error::{Error, Result};
pub use linker::Linker;
pub use manifest::Manifest;
pub use package::{Binary, Package};
pub use platform::Platform;

/// The example of the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
