//! The account of a diagnosis: what was found, and what was measured on the packaged FMUs.

use identification::{
    diagnose::{Diagnosis, location::Location, next_test::NextTest},
    frequency::FrequencyResponse,
    signal::record::Record,
};

use crate::{
    gap::{Measured, closed},
    invocation::Invocation,
};

/// Where a diagnosis came from, for its page.
#[derive(Debug, Clone, Default)]
pub struct Origin {
    /// The given model, in words.
    pub model: String,
    /// How the program was called.
    pub invocation: Invocation,
}

/// A diagnosis with what was measured on the packaged FMUs.
pub struct Account {
    /// What was found.
    pub diagnosis: Diagnosis,
    /// Records that were fitted.
    pub fit: Vec<Record>,
    /// Records that were not.
    pub check: Vec<Record>,
    /// The FMU of the given model.
    pub before: Measured,
    /// The FMU of the model with what was found.
    pub after: Measured,
    /// Response of the measured records.
    pub measured: Option<FrequencyResponse>,
    /// Where the gap lay.
    pub locations: Vec<Location>,
    /// What to record next, where names are ambiguous.
    pub next_test: Option<NextTest>,
    /// What was held out, and the like.
    pub notes: Vec<String>,
    /// What is suspect in the records, as sentences.
    pub warnings: Vec<String>,
    /// The command line that repeats the run.
    pub command: Vec<String>,
    /// What the page says of the given model, and how the program was called.
    pub origin: Origin,
    /// The archive of the FMU with what was found.
    pub fmu: Vec<u8>,
}

impl Account {
    /// Share of the gap's variance above the noise that was closed on the check records.
    #[must_use]
    pub fn closed(&self) -> f64 {
        closed(&self.before.gap, &self.after.gap, self.diagnosis.noise.rms)
    }
}
