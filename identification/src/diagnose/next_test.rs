//! The command that discriminates best between rival hypotheses, found by simulating them.

use crate::{
    digits::with_unit,
    signal::{
        Command, Interpolation,
        excitation::{Excitation, Kind},
        record::{Record, rms},
    },
    simulate::simulate,
};
use actuator_fmu::{
    effects::{Act, CHAIN},
    error::Result,
    parameters::Model,
};

/// What to record next.
pub struct NextTest {
    /// In words.
    pub sentence: String,
    /// The command.
    pub command: Command,
}

/// Length of the test [s].
const DURATION_S: f64 = 20.0;

/// Slowest and fastest excitation that is tried [Hz]: the report's band, slower for friction and play, twice it for lags.
const BANDS_HZ: [[f64; 2]; 3] = [[0.5, 12.0], [0.1, 1.0], [6.0, 24.0]];

/// Amplitudes as shares of the greatest command that was recorded: no more than the actuator has already followed.
const AMPLITUDES: [f64; 3] = [1.0, 0.25, 0.06];

/// Searches among sweeps, random sequences, multisines, steps and triangles; none where no two models ever differ.
///
/// # Errors
/// None of the commands can be made.
pub fn next_test(models: &[Model], records: &[Record], noise_rms: f64) -> Result<Option<NextTest>> {
    let peak = records.iter().flat_map(|record| record.command()).fold(0.0, |peak: f64, value| peak.max(value.abs()));
    let rate_hz = (1.0 / records[0].sampling().interval_s()).round().max(1.0);
    let models: Vec<Model> = models.iter().map(without_sensor_effects).collect();
    let unit = records[0].unit().name();
    let mut best: Option<(f64, NextTest)> = None;
    for kind in Kind::ALL {
        for band_hz in BANDS_HZ {
            for share in AMPLITUDES {
                let band_hz = [band_hz[0], band_hz[1].min(0.4 * rate_hz)];
                let excitation = Excitation {
                    duration_s: DURATION_S,
                    rate_hz,
                    band_hz,
                    amplitude: share * peak,
                    quiet_s: 1.0,
                    ..Excitation::new(kind)
                };
                let Ok(command) = excitation.command() else { continue };
                let Some(difference) = difference(&models, &command) else { continue };
                if best.as_ref().is_none_or(|(most, _)| difference > *most) {
                    let sentence = format!(
                        "record {} of {} between {} and {} Hz: there the explanations differ by {} rms, {:.1} times the noise",
                        words(kind),
                        with_unit(share * peak, 3, unit),
                        band_hz[0],
                        band_hz[1],
                        with_unit(difference, 3, unit),
                        difference / noise_rms.max(f64::MIN_POSITIVE)
                    );
                    best = Some((difference, NextTest { sentence, command }));
                }
            }
        }
    }
    Ok(best.map(|(_, test)| test))
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

/// Without what only the sensor adds, which no command changes.
fn without_sensor_effects(model: &Model) -> Model {
    let readings = CHAIN.iter().filter(|effect| matches!(effect.act, Act::Reading { .. }));
    let effects = readings.fold(model.effects.clone(), |effects, effect| effects.without(effect));
    Model { effects, ..model.clone() }
}

/// The least difference between any two models [deg], root mean square: the pair that is hardest to discriminate counts.
fn difference(models: &[Model], command: &Command) -> Option<f64> {
    let positions: Option<Vec<Vec<f64>>> = models
        .iter()
        .map(|model| simulate(model, command, Interpolation::Held).ok().map(|response| response.position))
        .collect();
    let positions = positions?;
    let pairs = (0..positions.len()).flat_map(|one| (0..one).map(move |other| (one, other)));
    pairs
        .map(|(one, other)| {
            let difference: Vec<f64> = positions[one].iter().zip(&positions[other]).map(|(a, b)| a - b).collect();
            rms(&difference)
        })
        .reduce(f64::min)
}
