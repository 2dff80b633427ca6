//! Known parameters of a generated campaign, and errors of the estimates.

use std::{collections::BTreeMap, fs, path::Path};

use serde::{Deserialize, Serialize};

use super::outcome::ConditionOutcome;
use actuator_fmu::{
    error::{Error, Result},
    parameters::{Base, read_toml},
};

/// `truth.toml`: how records were generated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// Seed of everything random.
    pub seed: u64,
    /// Sensor noise as a fraction of the position's rms.
    pub noise_share: f64,
    /// By name of the condition.
    pub condition: BTreeMap<String, TrueCondition>,
}

/// Parameters of one condition.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrueCondition {
    /// 2 or 3.
    pub order: u8,
    /// [deg/deg]
    pub k: f64,
    /// [1/s]
    pub p: f64,
    /// [rad/s]
    pub omega: f64,
    /// \[1\]
    pub zeta: f64,
    /// Turbulence as a static deflection \[deg\], rms.
    pub turbulence_rms_deg: f64,
}

/// One estimate against the truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Deviation {
    /// Name of the condition.
    pub condition: String,
    /// `k`, `omega` or `zeta`.
    pub parameter: &'static str,
    /// True value.
    pub truth: f64,
    /// Estimate.
    pub estimate: f64,
    /// Estimate over truth minus 1.
    pub relative: f64,
    /// Estimate minus truth in standard errors, if any.
    pub in_std_errors: Option<f64>,
}

/// For all conditions that have both.
pub(super) fn deviations(path: &Path, conditions: &[ConditionOutcome]) -> Result<Vec<Deviation>> {
    const THING: &str = "truth of a generated campaign";
    const ALLOWED: &str = "the truth.toml that was made with it";
    let text =
        fs::read_to_string(path).map_err(|error| Error::new(THING, error.to_string(), ALLOWED).at(path, None))?;
    let truth: Truth = read_toml(&text, THING, ALLOWED).map_err(|error| error.at(path, None))?;
    let mut deviations = Vec::new();
    for outcome in conditions {
        let name = outcome.condition.to_string();
        let (Some(result), Some(known)) = (&outcome.result, truth.condition.get(&name)) else { continue };
        for (index, truth) in [(0, known.k), (2, known.omega), (3, known.zeta)] {
            let estimate = result.estimate.values[index];
            deviations.push(Deviation {
                condition: name.clone(),
                parameter: Base::PARAMETERS[index].name,
                truth,
                estimate,
                relative: estimate / truth - 1.0,
                in_std_errors: result.estimate.std_errors[index].map(|error| (estimate - truth) / error),
            });
        }
    }
    Ok(deviations)
}
