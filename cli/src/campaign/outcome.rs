//! What a campaign finds: of each record, of each condition, and what its model misses.

use identification::{
    compare::{Condition, Difference},
    diagnose::{ParameterEstimate, Verdict},
};
use serde::{Deserialize, Serialize};

use super::summary::FitSummary;

/// What is called after each record, and each condition that is diagnosed: how many are done, and of how many.
pub type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// What one record gives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordResult {
    /// What is suspect in it, as sentences.
    pub warnings: Vec<String>,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Number of samples.
    pub samples: usize,
    /// Length [s].
    pub duration_s: f64,
    /// Unit of command and position as kept.
    pub unit: String,
    /// Where the command had power [Hz].
    pub excited_band_hz: Option<[f64; 2]>,
    /// Measured response in the excited part of 0.5 to 12 Hz, thinned to what a picture shows.
    pub response: Vec<ResponsePoint>,
    /// Fit of this record alone.
    pub fit: FitSummary,
    /// Greatest distance of measured response and fit from 2 to 10 Hz, where the report judged its fits: |Δ magnitude| [deg/deg] and
    /// |Δ phase| [deg], of points whose standard errors are below 0.1 and 3 deg.
    pub gap: Option<[f64; 2]>,
}

/// One point of a measured response.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResponsePoint {
    /// \[Hz\]
    pub frequency_hz: f64,
    /// \[deg/deg\]
    pub magnitude: f64,
    /// \[deg\]
    pub phase_deg: f64,
    /// Standard error [deg/deg].
    pub magnitude_std_error: f64,
    /// Standard error [deg].
    pub phase_std_error_deg: f64,
    /// 0 to 1.
    pub coherence: f64,
}

/// What became of one record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RecordOutcome {
    /// Its name.
    pub name: String,
    /// Its file.
    pub file: String,
    /// Line of the manifest.
    pub line: usize,
    /// Under what it was taken.
    pub condition: Condition,
    /// Mach number [1].
    pub mach: Option<f64>,
    /// Dynamic pressure [psf].
    pub dynamic_pressure_psf: Option<f64>,
    /// Taken over from an earlier run.
    pub reused: bool,
    /// The result; none where it failed.
    pub result: Option<RecordResult>,
    /// Why it failed.
    pub failure: Option<String>,
}

/// How the parameters of a condition were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum How {
    /// One record.
    Alone,
    /// All records fitted as one.
    Joint,
    /// Fits of the records combined.
    Combined,
}

impl How {
    /// In a word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Alone => "alone",
            Self::Joint => "joint",
            Self::Combined => "combined",
        }
    }
}

/// What the records of one condition give.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConditionResult {
    /// Names of the records behind it.
    pub records: Vec<String>,
    /// Their samples.
    pub samples: usize,
    /// Least and greatest Mach number.
    pub mach: Option<[f64; 2]>,
    /// Least and greatest dynamic pressure [psf].
    pub dynamic_pressure_psf: Option<[f64; 2]>,
    /// How the parameters were found.
    pub how: How,
    /// The parameters.
    pub estimate: FitSummary,
    /// Birge's ratio of the records' own fits; none for one record, or where fits state no errors.
    pub scatter: Option<f64>,
    /// Against the set of the tables for this condition, if it is one of the report's.
    pub against_table: Option<Difference>,
}

/// An effect that is named.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MissingEffect {
    /// Name.
    pub name: String,
    /// Its parameters.
    pub parameters: Vec<MissingParameter>,
    /// What would explain the records as well.
    pub alternatives: Vec<String>,
}

/// An estimate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MissingParameter {
    /// Name.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

impl MissingParameter {
    /// Of a diagnosis.
    pub fn of(estimate: &ParameterEstimate) -> Self {
        Self { name: estimate.name.to_owned(), value: estimate.value, unit: estimate.unit.to_owned() }
    }
}

/// The answer for one condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Missing {
    /// The answer.
    pub verdict: Verdict,
    /// What is named.
    pub effects: Vec<MissingEffect>,
    /// Noise of the records held out [their unit].
    pub noise_rms: f64,
    /// How many of the condition's records were looked at; the last of them is held out.
    pub records: usize,
}

/// What became of one condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConditionOutcome {
    /// The condition.
    pub condition: Condition,
    /// The result; none where it failed.
    pub result: Option<ConditionResult>,
    /// Why it failed.
    pub failure: Option<String>,
    /// What its model misses; none where that was not asked, or failed.
    pub missing: Option<Missing>,
    /// Why it could not be said what its model misses.
    pub missing_failure: Option<String>,
}
