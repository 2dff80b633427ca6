//! Records that do not allow an estimate are refused before every estimate.

use actuator_fmu::error::{Error, Result};

use super::{
    finding::{Finding, Severity},
    inspection::{Inspection, deviation, inspect},
    laguerre,
    repeats::compare_records,
    response::follows_behind_play_or_dead_zone,
    window::window,
};
use crate::{
    linear_least_squares::{solve, subtract},
    signal::record::Record,
};

/// Gains that differ by more than this, as a logarithm, are in other units; wear and limits change a gain by much less.
const SAME_GAIN: f64 = 1.6;

/// Requirement on the gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ExpectedGain {
    /// None, for a frequency response.
    Any,
    /// Positive, for a fit with k > 0.
    Positive,
    /// That of a model: same sign, and same units.
    Like(f64),
}

impl ExpectedGain {
    /// Whether a finding on the gain makes a record unusable.
    fn excludes(self, finding: &Finding, gain: f64) -> bool {
        match (self, finding.kind) {
            // A gain is defined for slow motion.
            (Self::Positive | Self::Like(_), "no_static_response") => true,
            (Self::Positive, "sign") => gain < 0.0,
            (Self::Like(model), "sign") => gain / model < 0.0,
            (Self::Like(model), "unit") => (gain / model).abs().ln().abs() > SAME_GAIN,
            _ => false,
        }
    }
}

/// Inspects records and refuses those that do not allow an estimate; returns the warnings.
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

/// A position that follows well, but with a gain far from the model's: unit or channel differ, or a stop limits most of the motion.
fn say_other_gain(inspections: &mut [Inspection], model: f64) {
    /// Minimum explained fraction for a gain to be that of the response.
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

/// Reduces the refusal to a warning if a position does not follow, but that of another record of the actuator does and moves more: play,
/// friction and dead zones suppress small motion.
fn tolerate_small_motion(records: &[&Record], inspections: &mut [Inspection]) {
    /// Minimum explained fraction of a record that follows without doubt.
    const FOLLOWS: f64 = 0.9;
    /// Maximum motion, relative to the command times the gain of that record.
    const SMALL: f64 = 0.75;
    if inspections.iter().all(|inspection| inspection.findings.iter().all(|finding| finding.kind != "no_response")) {
        return;
    }
    // A flexible linear model may explain as much of a random walk, which is not a response.
    let follows = |(record, other): &(&&Record, &Inspection)| {
        other.severity() != Severity::Refusal
            && (other.following_share >= FOLLOWS || follows_behind_play_or_dead_zone(&window(record, &other.sampling)))
    };
    let gains = records.iter().zip(&*inspections).filter(follows).map(|(_, other)| other.gain.abs());
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

/// A position without the contributions of load and drift.
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
    let line = finding.sample.map(|sample| sample + 2); // after the header
    Error::new("record", finding.sentence.clone(), "a command and the response to it, in one unit and with one clock")
        .remedy(&finding.remedy)
        .at(record.source(), line)
}
