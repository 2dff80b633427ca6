//! What nothing can be estimated from is refused, ahead of every estimate.

use actuator_fmu::error::{Error, Result};

use super::{
    finding::{Finding, Severity},
    inspection::{Inspection, deviation, inspect},
    laguerre,
    repeats::compare_records,
};
use crate::{
    linear_least_squares::{solve, subtract},
    signal::record::Record,
};

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
            // A gain is that of slow motion.
            (Self::Positive | Self::Like(_), "no_static_response") => true,
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
    tolerate_small_motion(records, &mut inspections);
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
    if let ExpectedGain::Like(model) = expected {
        say_other_gain(&mut inspections, model);
    }
    Ok(inspections.iter().flat_map(Inspection::warnings).collect())
}

/// A position that follows well, and so much more or less than the model: the unit or the channel is another one, or a stop holds most of the motion.
fn say_other_gain(inspections: &mut [Inspection], model: f64) {
    /// From this share on the gain is that of the response.
    const FOLLOWS: f64 = 0.9;
    for inspection in inspections {
        let ratio = (inspection.gain / model).abs();
        if inspection.following_share >= FOLLOWS && ratio.ln().abs() > SAME_GAIN {
            let sentence = format!(
                "the position moves {} times as far as the model predicts",
                crate::digits::significant(ratio, 3)
            );
            let remedy = "check unit and channel of both columns (inch, revolution, percent, counts), or fit a model to the records first";
            inspection.findings.push(Finding::warning("gain", sentence, remedy));
        }
    }
}

/// A position that does not follow, of an actuator that does in another record, and moves less than it did there: play, friction and dead
/// zones swallow small motion. That is a warning.
fn tolerate_small_motion(records: &[&Record], inspections: &mut [Inspection]) {
    /// From this share on a record follows without doubt.
    const FOLLOWS: f64 = 0.9;
    /// Motion below this share of what the gain of that record would make of the command.
    const SMALL: f64 = 0.75;
    // A flexible linear model may explain as much of a random walk, which is no response.
    let follows = |other: &&Inspection| other.following_share >= FOLLOWS && other.severity() != Severity::Refusal;
    let gains = inspections.iter().filter(follows).map(|other| other.gain.abs());
    let gain = gains.fold(0.0, f64::max);
    for (record, inspection) in records.iter().zip(inspections) {
        let refusal = inspection.findings.iter_mut().find(|finding| finding.kind == "no_response");
        let moved = || deviation(&without_load_and_drift(record)) / deviation(record.command());
        if let Some(finding) = refusal.filter(|_| moved() < SMALL * gain) {
            finding.severity = Severity::Warning;
            finding.sentence += "; another record of the actuator does, and this motion is smaller";
            finding.remedy = "record larger motion, or keep this one for play, friction or a dead zone".to_owned();
        }
    }
}

/// A position without what a load and a drift move.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn without_load_and_drift(record: &Record) -> Vec<f64> {
    let mut left = record.position().to_vec();
    if let Some(load) = record.load() {
        left = laguerre::fit(load, &left).residual;
    }
    let columns = [vec![1.0; left.len()], (0..left.len()).map(|n| n as f64 / left.len() as f64).collect()];
    let factors = solve(&columns, &left);
    subtract(&mut left, &columns, &factors);
    left
}

fn refused(record: &Record, finding: &Finding) -> Error {
    let line = finding.sample.map(|sample| sample + 2); // behind the header
    Error::new("record", finding.sentence.clone(), "a command and the response to it, in one unit and with one clock")
        .remedy(&finding.remedy)
        .at(record.source(), line)
}
