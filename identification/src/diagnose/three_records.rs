//! Generated records that tests of the diagnosis share.

use std::f64::consts::TAU;

use super::{Verdict, diagnose};
use crate::{
    generated::TestPoint,
    signal::{
        Interpolation,
        excitation::{Excitation, Kind},
        record::Record,
    },
};
use actuator_fmu::parameters::Model;

/// A sweep, random motion and a multisine of 10 s each, of an actuator that moves with this amplitude, with a hundredth of noise.
pub fn three_records(truth: &Model, amplitude: f64) -> Vec<Record> {
    three_records_of(truth, amplitude, 10.0)
}

/// The same with another duration [s]: where 6 s suffice, a test takes little more than half the time.
pub fn three_records_of(truth: &Model, amplitude: f64, duration_s: f64) -> Vec<Record> {
    let kinds = [(Kind::Sweep, 1), (Kind::Random, 2), (Kind::Multisine, 3)];
    let record = |(kind, seed): (Kind, u64)| {
        let excitation = Excitation { amplitude, seed, duration_s, ..Excitation::new(kind) };
        let (interpolation, noise_share) = (Interpolation::Held, 0.01);
        let point = TestPoint { model: truth.clone(), excitation, interpolation, noise_share, turbulence: None, seed };
        point.record(kind.name()).unwrap()
    };
    kinds.into_iter().map(record).collect()
}

/// The record of a sensor that measures this function of time and position.
pub fn measured_as(record: &Record, sensor: impl Fn(f64, f64) -> f64) -> Record {
    let position = record.time().iter().zip(record.position()).map(|(t, position)| sensor(*t, *position)).collect();
    Record::new(record.to_command(), position, record.unit(), record.interpolation(), "of a sensor").unwrap()
}

/// A record of a sensor behind a gear that does not run true, and with a level: an error of a twentieth of a degree, periodic in each degree, that no
/// effect of the library reproduces.
pub fn behind_gear(record: &Record, level: f64) -> Record {
    measured_as(record, |_, position| position + 0.05 * (TAU * position).sin() + level)
}

/// An effect that was found, the values of its parameters, and its alternatives.
pub type Found = (&'static str, Vec<f64>, Vec<String>);

/// Verdict and first finding of a diagnosis with the last record as check record.
pub fn said(given: &Model, records: &[Record]) -> (Verdict, Option<Found>) {
    let (check, fit) = records.split_last().unwrap();
    let diagnosis = diagnose(given, fit, std::slice::from_ref(check), &[], None).unwrap();
    let first = diagnosis.findings.into_iter().next().map(|finding| {
        let values = finding.parameters.iter().map(|parameter| parameter.value).collect();
        (finding.name, values, finding.alternatives)
    });
    (diagnosis.verdict, first)
}
