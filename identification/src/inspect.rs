//! What a record is, before anything is estimated from it: how it is sampled, whether its position follows its command, in which
//! units, with which lag and sign, how noisy, and what in it is suspect.
//!
//! [`inspect`] looks at one record, [`compare_records`] at several together; [`admit`] refuses what nothing can be estimated from and
//! passes the warnings on, [`segments`] cuts a record at its gaps.

mod admission;
mod bandwidth;
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
pub use inspection::{Inspection, inspect};
pub use repeats::compare_records;
pub use segments::{segments, whole_record};
pub use sensor_faults::without_sensor_faults;
