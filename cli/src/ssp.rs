//! The 17 sets for tools with SSP 1.0 (System Structure and Parameterization): one parameter set file each (`.ssv`). [`system`] makes
//! systems (`.ssp`) of FMUs.
//!
//! The content is limited to what importers can read. libcosim and Ecos stop at the first parameter or connector that is an enumeration,
//! and fmpy takes the item's name for a number; all three set integers. So a set is its `set_number`, not its `surface`, `stage` and
//! `load_case`, and the input `failure` has no connector.

mod structure;
pub mod system;
mod values;

use actuator_fmu::{
    error::Result,
    parameters::{SetName, table},
};
pub use values::{parameter_set, summary};

/// The 17 files of [`parameter_set`] with their names.
///
/// # Errors
/// None in practice; the XML writer's own.
pub fn parameter_set_files(prefix: Option<&str>) -> Result<Vec<(String, Vec<u8>)>> {
    table().iter().map(|set| Ok((file_name(set.name), parameter_set(set, prefix)?.into_bytes()))).collect()
}

/// Name of the file of a set.
#[must_use]
pub fn file_name(set: SetName) -> String {
    format!("{set}.ssv")
}
