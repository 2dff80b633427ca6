//! From measured records to frequency responses, parameter sets and a diagnosis of effects missing in a model.
//!
//! In reading order: [`signal`] (commands and records), [`simulate`], [`frequency`] (exact and measured responses), [`least_squares`],
//! [`estimate`] (parameters with their uncertainty), [`diagnose`] (effects missing in a model), [`compare`] (wear and load), [`generated`]
//! (test points with known truth). [`progress`] reports the completed fraction of a search.
//!
//! Numbers in, numbers out: nothing here opens a file, prints, reads a clock or depends on FMI.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod compare;
pub mod diagnose;
pub mod digits;
pub mod estimate;
mod fourier;
pub mod frequency;
pub mod generated;
pub mod inspect;
pub mod least_squares;
mod linear_least_squares;
mod parallel;
pub mod progress;
pub mod signal;
pub mod simulate;
mod sorting;
mod spikes;
#[cfg(test)]
mod uniform_noise;
