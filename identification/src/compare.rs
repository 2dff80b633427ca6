//! Differences between actuators that matter to a control law: wear and load, for the tabulated sets or for fitted ones.
//!
//! Two responses H_a and H_b differ by |H_b| - |H_a| in magnitude and by the angle of H_b conj(H_a) in phase: an angle of the quotient,
//! never a difference of two unwrapped phases. The report (NASA/TM-1998-208452) calls more than 0.1 and more than 3 deg unacceptable, a
//! tenth of usual gain and phase margins, and considers 0.5 to 12 Hz, the band of its data, and 3 to 5 Hz, that of the wing's modes.
//!
//! [`Comparison::of_tables`] also checks the statements of the report against its tables (`statements`).

mod comparison;
mod condition;
mod difference;
pub mod experiment;
mod set;
mod statement;
mod statements;
mod tables;
pub mod tunnel;

pub use comparison::Comparison;
pub use condition::Condition;
pub use difference::{AEROELASTIC_BAND_HZ, Difference, Extreme, InBand, LIMITS, Limits, POINTS_PER_HZ};
pub use set::Set;
pub use statement::{Statement, Verdict};
