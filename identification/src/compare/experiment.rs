//! Replacement for the experimental curves in the report's figures: responses estimated from generated records of the same sets.

use super::{comparison::Comparison, condition::Condition, set::Set, tunnel::tunnel};
use crate::{
    frequency::{FrequencyResponse, Method, estimate},
    generated::{TestPoint, Turbulence},
    parallel,
    signal::{
        Interpolation,
        excitation::{Excitation, Kind},
    },
};
use actuator_fmu::error::Result;

/// A set and the response estimated from a generated record of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// Label of the set.
    pub label: String,
    /// By local polynomials.
    pub response: FrequencyResponse,
}

/// Sensor noise as a fraction of the position's rms.
pub const NOISE_SHARE: f64 = 0.02;

/// Text beside every curve of this kind.
pub const NOTE: &str = "Experiment: generated record (75 s sweep of 1 deg, 2 % sensor noise, turbulence under load), not the report's measurement; points with standard errors above 0.1 or 3 deg are left out.";

/// One for each set with a known condition, in order.
///
/// # Errors
/// None for the sets of the tables; models for which no response can be estimated.
pub fn experiments(comparison: &Comparison, seed: u64) -> Result<Vec<Experiment>> {
    let known: Vec<(&Set, u64)> =
        comparison.sets.iter().zip(seed..).filter(|(set, _)| set.condition.is_some()).collect();
    parallel::map(&known, |(set, seed)| experiment(set, *seed)).into_iter().collect()
}

fn experiment(set: &Set, seed: u64) -> Result<Experiment> {
    let pressure = set
        .condition
        .as_ref()
        .and_then(Condition::set_name)
        .and_then(tunnel)
        .map_or(0.0, |tunnel| tunnel.dynamic_pressure_psf);
    let point = TestPoint {
        model: set.model.clone(),
        excitation: Excitation::new(Kind::Sweep),
        interpolation: Interpolation::Held,
        noise_share: NOISE_SHARE,
        turbulence: Turbulence::at(pressure),
        seed,
    };
    let record = point.record(&format!("generated: {}", set.label))?;
    Ok(Experiment { label: set.label.clone(), response: estimate(&[record], Method::Polynomial)? })
}
