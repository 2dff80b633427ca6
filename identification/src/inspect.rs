//! Inspection of a record before any estimate: sampling, whether its position follows its command, units, lag and sign, noise, and
//! anomalies.
//!
//! [`inspect`] inspects one record, [`compare_records`] several together; [`admit`] refuses records that do not allow an estimate and
//! returns the warnings, [`segments`] cuts a record at its gaps.

mod admission;
mod bandwidth;
mod behind;
mod clocks;
mod copies;
mod correlation;
mod dropped_rows;
pub mod finding;
mod inspection;
pub(crate) mod laguerre;
mod level;
pub mod noise;
mod repeats;
mod response;
mod sampling;
mod segments;
mod sensor_faults;
pub(crate) mod spectrum;
mod spoiled;
mod standing;
mod sudden;
pub mod values;
mod window;

pub use admission::{ExpectedGain, admit};
pub use copies::without_copies;
pub(crate) use inspection::deviation;
pub(crate) use inspection::inspect_noise;
pub use inspection::{Inspection, inspect};
pub use repeats::compare_records;
pub use segments::{segments, whole_record};
pub use sensor_faults::without_sensor_faults;
