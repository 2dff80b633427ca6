//! The command that discriminates best between rival hypotheses, found by simulation, within the amplitudes and rates of the records.

use std::f64::consts::TAU;

use crate::{
    digits::{significant, with_unit},
    signal::{
        Command, Interpolation,
        excitation::{Excitation, Kind},
        record::{Record, rms, without_mean},
    },
    simulate::simulate,
};
use actuator_fmu::{
    effects::{Act, CHAIN},
    parameters::Model,
};

/// The test to record next.
pub struct NextTest {
    /// In words.
    pub sentence: String,
    /// The command.
    pub command: Command,
}

/// Duration of the test, and of the rest at its start [s].
const DURATION_S: f64 = 20.0;
const QUIET_S: f64 = 1.0;

/// Lowest and highest frequency of the excitations that are tried, as multiples of ω/2π: the report's band of 0.5 to 12 Hz at the 26 Hz of its
/// actuators, lower for friction and play, twice it for lags.
const BANDS: [[f64; 2]; 3] = [[0.02, 0.46], [0.004, 0.04], [0.23, 0.92]];

/// Amplitudes as shares of the largest recorded command: no more than the actuator has already followed.
const AMPLITUDES: [f64; 3] = [1.0, 0.25, 0.06];

/// Largest rate of a test over that of the records.
const RATE_MARGIN: f64 = 1.02;

/// Difference between two explanations over the noise, both rms, at least, for a command to discriminate between them.
const LEAST_DIFFERENCE: f64 = 0.3;

/// Searches among sweeps, random sequences, multisines, steps and triangles; none where no such command discriminates between all models. The first
/// model is the best explanation: its largest rate on the records bounds that of the test.
#[must_use]
pub fn next_test(models: &[Model], records: &[Record], noise_rms: f64) -> Option<NextTest> {
    let peak = records.iter().flat_map(|record| record.command()).fold(0.0, |peak: f64, value| peak.max(value.abs()));
    let rate_hz = (1.0 / records[0].sampling().interval_s()).round().max(1.0);
    let models: Vec<Model> = models.iter().map(without_sensor_effects).collect();
    let unit = records[0].unit().name();
    // None where the motion diverges.
    let peak_rate = |command: &Command, interpolation: Interpolation| -> Option<f64> {
        let rates = simulate(&models[0], command, interpolation).ok()?.rate;
        Some(rates.into_iter().fold(0.0, |peak: f64, rate| peak.max(rate.abs())))
    };
    let of_records = records.iter().filter_map(|record| peak_rate(&record.to_command(), record.interpolation()));
    let borne = of_records.fold(0.0, f64::max);
    let base_hz = models[0].base.omega() / TAU;
    let mut best: Option<(f64, NextTest)> = None;
    for kind in Kind::ALL {
        for band in BANDS {
            for share in AMPLITUDES {
                let band_hz = [band[0] * base_hz, (band[1] * base_hz).min(0.4 * rate_hz)];
                let excitation = Excitation {
                    duration_s: DURATION_S,
                    rate_hz,
                    band_hz,
                    amplitude: share * peak,
                    quiet_s: QUIET_S,
                    ..Excitation::new(kind)
                };
                let Ok(command) = excitation.command() else { continue };
                if peak_rate(&command, Interpolation::Held).is_none_or(|rate| rate > RATE_MARGIN * borne) {
                    continue;
                }
                let Some(difference) = difference(&models, &command) else { continue };
                let tells_apart = difference > LEAST_DIFFERENCE * noise_rms;
                if tells_apart && best.as_ref().is_none_or(|(most, _)| difference > *most) {
                    let sentence = format!(
                        "record {} of {} between {} and {} Hz: on it the explanations differ by {} rms, {:.1} times the noise",
                        words(kind),
                        with_unit(share * peak, 3, unit),
                        significant(band_hz[0], 2),
                        significant(band_hz[1], 2),
                        with_unit(difference, 3, unit),
                        difference / noise_rms.max(f64::MIN_POSITIVE)
                    );
                    best = Some((difference, NextTest { sentence, command }));
                }
            }
        }
    }
    best.map(|(_, test)| test)
}

fn words(kind: Kind) -> &'static str {
    match kind {
        Kind::Sweep => "a sweep",
        Kind::Random => "a random sequence",
        Kind::Multisine => "a multisine",
        Kind::Steps => "large and small steps",
        Kind::Triangles => "large and small triangles",
    }
}

/// Without the effects of the sensor's reading, which no command changes.
fn without_sensor_effects(model: &Model) -> Model {
    let readings = CHAIN.iter().filter(|effect| matches!(effect.act, Act::Reading { .. }));
    let effects = readings.fold(model.effects.clone(), |effects, effect| effects.without(effect));
    Model { effects, ..model.clone() }
}

/// Smallest difference between any two models once the motion begins [deg], root mean square about its mean: the pair that is hardest to discriminate
/// counts. A level that no command changes may be a bias of the sensor or a steady load, and the motion in which a model reaches it is not part of
/// the test.
fn difference(models: &[Model], command: &Command) -> Option<f64> {
    let positions: Option<Vec<Vec<f64>>> = models
        .iter()
        .map(|model| simulate(model, command, Interpolation::Held).ok().map(|response| response.position))
        .collect();
    let positions = positions?;
    let quiet = command.time.iter().take_while(|time| **time < QUIET_S).count();
    let pairs = (0..positions.len()).flat_map(|one| (0..one).map(move |other| (one, other)));
    pairs
        .map(|(one, other)| {
            let pairs = positions[one].iter().zip(&positions[other]).skip(quiet);
            let difference: Vec<f64> = pairs.map(|(one, other)| one - other).collect();
            rms(&without_mean(&difference))
        })
        .reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{PositionUnit, table},
    };

    fn with(name: &str, values: &[f64]) -> Model {
        let effects = Effects::default().with(find(name).unwrap(), values).unwrap();
        Model { effects, ..Model::from_set(&table()[0]) }
    }

    /// A gentle sweep of 2 deg.
    fn record() -> Record {
        let sweep =
            Excitation { duration_s: 20.0, amplitude: 2.0, band_hz: [0.2, 3.0], ..Excitation::new(Kind::Sweep) };
        let command = sweep.command().unwrap();
        let position = simulate(&with("backlash", &[0.1]), &command, Interpolation::Held).unwrap().position;
        Record::new(command, position, PositionUnit::default(), Interpolation::Held, "sweep").unwrap()
    }

    fn peaks(model: &Model, command: &Command) -> [f64; 2] {
        let peak = |values: &[f64]| values.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()));
        [peak(&command.command), peak(&simulate(model, command, Interpolation::Held).unwrap().rate)]
    }

    #[test]
    fn a_test_tells_rivals_apart_within_what_the_actuator_has_borne() {
        let models = [with("backlash", &[0.1]), with("dead_zone", &[0.05]), with("coulomb_friction", &[0.05])];
        let record = record();
        let test = next_test(&models, std::slice::from_ref(&record), 0.01).unwrap();
        let ([amplitude, rate], [most, fastest]) =
            (peaks(&models[0], &test.command), peaks(&models[0], &record.to_command()));
        assert!(amplitude <= most && rate <= RATE_MARGIN * fastest, "{amplitude} {most} {rate} {fastest}");
        assert!(difference(&models, &test.command).unwrap() > LEAST_DIFFERENCE * 0.01, "{}", test.sentence);
    }

    #[test]
    fn no_test_is_offered_where_none_tells_rivals_apart() {
        let plays = [with("backlash", &[0.1]), with("backlash", &[0.1001])];
        let levels = [with("sensor_bias", &[0.35, 0.0]), with("hinge_load", &[0.0, 0.35])];
        for models in [plays, levels] {
            assert!(next_test(&models, &[record()], 0.01).is_none());
        }
    }
}
