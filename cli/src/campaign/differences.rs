//! Size of the differences of the conditions before and after their diagnosis, from their folders in the results.

use std::path::Path;

use serde::Deserialize;

use super::outcome::ConditionOutcome;

/// Folder of the diagnosis of a condition, relative to that of the results.
#[must_use]
pub fn folder_of(outcome: &ConditionOutcome) -> String {
    format!("diagnoses/{}", outcome.condition)
}

/// The part of a diagnosis summary about its differences.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Differences {
    /// The verdict in one sentence.
    pub sentence: String,
    gap: Gap,
    /// Unit of the positions.
    pub unit: String,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Gap {
    before: Side,
    after: Side,
    noise_rms: f64,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Side {
    check_rms: f64,
}

impl Differences {
    /// For the diagnosis of a condition; `None` if it has no folder.
    #[must_use]
    pub fn of(outcome: &ConditionOutcome, results: &Path) -> Option<Self> {
        outcome.missing.as_ref()?;
        let path = results.join(folder_of(outcome)).join("diagnosis.json");
        serde_json::from_slice(&std::fs::read(path).ok()?).ok()
    }

    /// Rms on the check records before and after [unit of the positions].
    #[must_use]
    pub fn rms(&self) -> [f64; 2] {
        [self.gap.before.check_rms, self.gap.after.check_rms]
    }

    /// Rms of the noise [unit of the positions].
    #[must_use]
    pub fn noise_rms(&self) -> f64 {
        self.gap.noise_rms
    }
}
