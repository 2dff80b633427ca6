//! The drive: its equation of motion as a hybrid system, solved by series between two events.
//!
//! ```text
//! δ̈ = drive - 2ζω δ̇ - ω² cubic δ³ + ω² (load + bias - stiffness δ) - friction
//! drive = ω² (error), error = x - δ through the dead zone and the limit of acceleration
//! ```
//!
//! In a mode the drive is on one of at most five linear branches of the servo characteristic, friction has one sign or sticks, and the rate
//! is free or at a limit: the equation is linear except for the cubic spring, and is solved by series to rounding error. The event that
//! ends a mode is located in the series and cannot be missed.
//!
//! In reading order: [`LoopTerms`] (the terms of the equation), `forcing`, `mode` (definition of a mode), `switching` (which mode holds,
//! and under which conditions), `segment` (the motion over a segment and its first event), `linear` (a piece without a change of mode),
//! `integration` (modes, derivatives and event indicators for ODE solvers).

mod forcing;
mod integration;
mod linear;
mod loop_terms;
mod mode;
mod segment;
mod switching;

pub use forcing::{DriveOperation, Forcing, InstantaneousForcing};
pub use linear::{Ends, LONGEST_BETWEEN_ENDS};
pub use loop_terms::{DriveState, LoopTerms};
pub use mode::DriveMode;
pub use segment::{Event, Motion};
