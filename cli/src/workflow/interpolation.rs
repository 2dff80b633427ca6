//! Commands that were declared to be held between samples and move linearly there, or the reverse.
//!
//! A held command is half an interval later than a linear one with the same samples. What was declared wrongly shows as a delay or a lag,
//! alone or beside a pole that was moved to make up for it, or as a base that is off; what was declared rightly does not fit better otherwise.

use actuator_fmu::parameters::Model;
use identification::{
    diagnose::{self, Diagnosis, Finding, Lead, Verdict},
    signal::{Interpolation, record::Record},
};

/// What the given model may leave more than a refitted one, as a share of the rms.
const TOLERANCE: f64 = 1e-3;

/// The same of an explanation that needs no delay: one that is free takes a little of the noise, and of an error of the given model.
const TOLERANCE_OF_SIMPLER: f64 = 1e-2;

/// Share of a difference that a delay takes where it may be one of the command between samples.
const MOST: f64 = 0.5;

/// The other interpolation, where the records sound as if it were theirs: a position later than that of a linear command, or a model that
/// would leave as little as the refitted one does.
pub fn suspected(diagnosis: &Diagnosis, given: &Model, records: &[Record]) -> Option<Interpolation> {
    let declared = records.first()?.interpolation();
    if records.iter().any(|record| record.interpolation() != declared) {
        return None;
    }
    let other = match declared {
        Interpolation::Held => Interpolation::Linear,
        Interpolation::Linear => Interpolation::Held,
    };
    let is_refitted = !diagnosis.findings.is_empty() && diagnosis.findings.iter().all(is_shift);
    let sounds = is_late(diagnosis) && other == Interpolation::Held
        || is_refitted && leaves_as_little((given, &read(records, other)), (&diagnosis.after, records), TOLERANCE);
    sounds.then_some(other)
}

/// Whether an explanation of the records with the other interpolation is simpler, and leaves as little.
pub fn is_simpler(other: (&Diagnosis, &[Record]), declared: (&Diagnosis, &[Record])) -> bool {
    let (is_simpler, tolerance) = if is_late(declared.0) {
        let is_explained = !declared.0.findings.is_empty() || closes(other.0);
        (is_explained && !is_late(other.0), TOLERANCE_OF_SIMPLER)
    } else {
        (other.0.findings.is_empty(), TOLERANCE)
    };
    is_simpler && leaves_as_little((&other.0.after, other.1), (&declared.0.after, declared.1), tolerance)
}

/// What the page says where the other interpolation was taken.
pub fn warning(taken: Interpolation) -> String {
    let (taken, declared, remedy) = match taken {
        Interpolation::Held => ("held", "moves linearly", "leave --linear out (in a manifest: hold = true)"),
        Interpolation::Linear => ("linear", "is held", "give --linear (in a manifest: hold = false)"),
    };
    format!(
        "the positions do not match a command that {declared} between samples, as declared: the command is taken as {taken}; {remedy}"
    )
}

/// The same samples with another interpolation.
pub fn read(records: &[Record], interpolation: Interpolation) -> Vec<Record> {
    records.iter().map(|record| record.clone().with_interpolation(interpolation)).collect()
}

fn leaves_as_little(one: (&Model, &[Record]), other: (&Model, &[Record]), tolerance: f64) -> bool {
    let left = |(model, records)| diagnose::rms_left(model, records);
    left(one).zip(left(other)).is_some_and(|(one, other)| one < (1.0 + tolerance) * other)
}

/// A delay, a lag, or a mode: far below a period of the motion they are much alike. Or nothing that explains the records, and a delay that takes most of
/// the difference, as a base does.
fn is_late(diagnosis: &Diagnosis) -> bool {
    let takes_most = |lead: &Lead| lead.name == "delay" && lead.only_in.is_none() && lead.share > Some(MOST);
    diagnosis.findings.iter().any(|finding| ["delay", "sensor_lag", "structural_mode"].contains(&finding.name))
        || diagnosis.verdict == Verdict::Unexplained && diagnosis.leads.iter().any(takes_most)
}

/// Whether nothing but noise stays.
fn closes(diagnosis: &Diagnosis) -> bool {
    !matches!(diagnosis.verdict, Verdict::Unexplained | Verdict::Leading)
}

fn is_shift(finding: &Finding) -> bool {
    finding.name == "parameter_shift"
}
