//! The identified actuators: tables 1 and 2 of NASA/TM-1998-208452 as data, and models in files.
//!
//! The report gives 17 sets of (k, p, ω, ζ): three surfaces, three stages of wear, two load cases, less the
//! lower spoiler late in the test under load, for which it has no data.

mod base;
mod model;
mod model_file;
mod model_reader;
mod position_unit;
mod selection;
mod table;
mod toml_text;

pub use base::{Base, BaseParameter};
pub use model::{Identity, Model, Provenance};
pub use model_file::Quantity;
pub use position_unit::{PositionKind, PositionUnit};
pub use selection::{LoadCase, Order, Stage, Surface};
pub use table::{BAND_HZ, NO_DATA, ParameterSet, SOURCE, SetName, by_number, find, table};
pub use toml_text::read_toml;
