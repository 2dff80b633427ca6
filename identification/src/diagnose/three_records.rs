//! Generated records that tests of the diagnosis share.

use std::f64::consts::TAU;

use crate::{
    generated::TestPoint,
    signal::{
        Interpolation,
        excitation::{Excitation, Kind},
        record::Record,
    },
};
use actuator_fmu::parameters::Model;

/// A sweep, random motion and a multisine of 10 s each, of an actuator that moves by some amplitude, with a hundredth of noise.
pub fn three_records(truth: &Model, amplitude: f64) -> Vec<Record> {
    let kinds = [(Kind::Sweep, 1), (Kind::Random, 2), (Kind::Multisine, 3)];
    let record = |(kind, seed): (Kind, u64)| {
        let excitation = Excitation { amplitude, seed, duration_s: 10.0, ..Excitation::new(kind) };
        let (interpolation, noise_share) = (Interpolation::Held, 0.01);
        let point = TestPoint { model: truth.clone(), excitation, interpolation, noise_share, turbulence: None, seed };
        point.record(kind.name()).unwrap()
    };
    kinds.into_iter().map(record).collect()
}

/// A record of a sensor behind a gear that does not run true, and off by a level: an error of a twentieth of a degree in each of its degrees that no effect
/// of the library has.
pub fn behind_gear(record: &Record, level: f64) -> Record {
    let error = |position: f64| 0.05 * (TAU * position).sin();
    let position = record.position().iter().map(|position| position + error(*position) + level).collect();
    Record::new(record.to_command(), position, record.unit(), record.interpolation(), "behind a gear").unwrap()
}
