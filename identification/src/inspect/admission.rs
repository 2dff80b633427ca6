//! What nothing can be estimated from is refused, ahead of every estimate.

use actuator_fmu::error::{Error, Result};

use super::{
    finding::{Finding, Severity},
    inspection::{Inspection, inspect},
    repeats::compare_records,
};
use crate::signal::record::Record;

/// Gains this far apart, as a logarithm, are of other units; wear and limits change a gain by much less.
const SAME_GAIN: f64 = 1.6;

/// What a gain must be for what is done with the records.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ExpectedGain {
    /// Anything, as for a frequency response.
    Any,
    /// Positive, as for a fit of k > 0.
    Positive,
    /// That of a model: of its sign, and in its units.
    Like(f64),
}

impl ExpectedGain {
    /// Whether a finding on the gain makes a record unusable.
    fn excludes(self, finding: &Finding, gain: f64) -> bool {
        match (self, finding.kind) {
            (Self::Positive, "sign") => gain < 0.0,
            (Self::Like(model), "sign") => gain / model < 0.0,
            (Self::Like(model), "unit") => (gain / model).abs().ln().abs() > SAME_GAIN,
            _ => false,
        }
    }
}

/// Inspects records and refuses those that nothing can be estimated from; returns the warnings.
///
/// # Errors
/// The first refusal, with its record, cause and remedy.
pub fn admit(records: &[&Record], expected: ExpectedGain) -> Result<Vec<String>> {
    let mut inspections: Vec<Inspection> = records.iter().map(|record| inspect(record)).collect();
    for (record, inspection) in records.iter().zip(&inspections) {
        let refusal = inspection
            .findings
            .iter()
            .find(|finding| finding.severity == Severity::Refusal || expected.excludes(finding, inspection.gain));
        if let Some(finding) = refusal {
            return Err(refused(record, finding));
        }
    }
    compare_records(records, &mut inspections);
    Ok(inspections.iter().flat_map(Inspection::warnings).collect())
}

fn refused(record: &Record, finding: &Finding) -> Error {
    let line = finding.sample.map(|sample| sample + 2); // behind the header
    Error::new("record", finding.sentence.clone(), "a command and the response to it, in one unit and with one clock")
        .remedy(&finding.remedy)
        .at(record.source(), line)
}
