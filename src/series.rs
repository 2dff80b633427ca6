//! A signal over one segment of time, as a Taylor series and at most two fast decays.
//!
//! Over a segment of length h, with τ = t / h from 0 to 1,
//!
//! ```text
//! f(τ) = Σ c_n τ^n + Σ a_i e^{-k_i τ}
//! ```
//!
//! The decays are the free response of poles much faster than all others (p of eq. (1), or a sensor lag). Their Taylor series would need
//! too many terms over a segment, and none is needed, since every linear operator maps a decay onto a decay. For segments no longer than
//! [`Accuracy::longest`] divided by the largest of the other poles the truncation error is below rounding, so that the solution is exact
//! for practical purposes, and the first instant at which a signal leaves a range is found with certainty (`crossing`).

mod bounds;
mod crossing;
mod range;
mod root;
mod taylor;

pub use range::{Range, Side};
pub use taylor::{Accuracy, Decay, FACTORIAL, INVERSE_FACTORIAL, RECIPROCAL, Series, TERMS};
