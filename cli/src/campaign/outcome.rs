//! Results of a campaign: of each record, of each condition, and effects missing in its model.

use identification::{
    compare::{Condition, Difference},
    diagnose::{ParameterEstimate, Verdict},
};
use serde::{Deserialize, Serialize};

use super::summary::FitSummary;

/// Callback after each record, and each diagnosed condition, with the number done and the total.
pub type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// Result of one record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordResult {
    /// Warnings, as sentences.
    pub warnings: Vec<String>,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Number of samples.
    pub samples: usize,
    /// Length \[s\].
    pub duration_s: f64,
    /// Unit of command and position in the results.
    pub unit: String,
    /// Band in which the command has power \[Hz\].
    pub excited_band_hz: Option<[f64; 2]>,
    /// Measured response in the excited part of 0.5 to 12 Hz, thinned to the resolution of a chart.
    pub response: Vec<ResponsePoint>,
    /// Fit of this record alone.
    pub fit: FitSummary,
    /// Maximum distance of measured response and fit from 2 to 10 Hz, the band in which the report judged its fits: |Δ magnitude| [deg/deg]
    /// and |Δ phase| \[deg\], for points with standard errors below 0.1 and 3 deg.
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
    /// Standard error \[deg\].
    pub phase_std_error_deg: f64,
    /// 0 to 1.
    pub coherence: f64,
}

/// Outcome of one record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RecordOutcome {
    /// Its name.
    pub name: String,
    /// Its file.
    pub file: String,
    /// Line of the manifest.
    pub line: usize,
    /// Test condition.
    pub condition: Condition,
    /// Mach number \[1\].
    pub mach: Option<f64>,
    /// Dynamic pressure \[psf\].
    pub dynamic_pressure_psf: Option<f64>,
    /// Reused from an earlier run.
    pub reused: bool,
    /// The result; `None` if it failed.
    pub result: Option<RecordResult>,
    /// Why it failed.
    pub failure: Option<String>,
}

/// How the parameters of a condition were estimated.
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

/// Result of the records of one condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConditionResult {
    /// Names of the records used.
    pub records: Vec<String>,
    /// Their samples.
    pub samples: usize,
    /// Minimum and maximum Mach number.
    pub mach: Option<[f64; 2]>,
    /// Minimum and maximum dynamic pressure \[psf\].
    pub dynamic_pressure_psf: Option<[f64; 2]>,
    /// How the parameters were estimated.
    pub how: How,
    /// The parameters.
    pub estimate: FitSummary,
    /// Birge's ratio of the records' own fits; `None` for one record, or fits without standard errors.
    pub scatter: Option<f64>,
    /// Against the set of the tables for this condition, if it is one of the report's.
    pub against_table: Option<Difference>,
}

/// A named effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MissingEffect {
    /// Name.
    pub name: String,
    /// Its parameters.
    pub parameters: Vec<MissingParameter>,
    /// Names that explain the records as well.
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
    /// For a diagnosis.
    pub fn of(estimate: &ParameterEstimate) -> Self {
        Self { name: estimate.name.to_owned(), value: estimate.value, unit: estimate.unit.to_owned() }
    }
}

/// The verdict for one condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Missing {
    /// The verdict.
    pub verdict: Verdict,
    /// The named effects.
    pub effects: Vec<MissingEffect>,
    /// Noise of the hold-out records [their unit].
    pub noise_rms: f64,
    /// Number of the condition's records used; the last of them is held out.
    pub records: usize,
}

/// Outcome of one condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConditionOutcome {
    /// The condition.
    pub condition: Condition,
    /// The result; `None` if it failed.
    pub result: Option<ConditionResult>,
    /// Why it failed.
    pub failure: Option<String>,
    /// The diagnosis of its model; `None` if not requested, or failed.
    pub missing: Option<Missing>,
    /// Why the diagnosis failed.
    pub missing_failure: Option<String>,
}
