//! Sensor faults, removed before a model is judged: spikes, which are excluded, and a slip, whose height is subtracted.

use super::{laguerre, level, sampling, window};
use crate::{signal::record::Record, spikes};

/// The record without sensor faults, and the removed faults in words.
#[must_use]
pub fn without_sensor_faults(record: Record) -> (Record, Vec<String>) {
    let clock = sampling::clock(record.time());
    let window = window::window(&record, &clock);
    // At other times samples of the window are not those of the record.
    let same = window.position.len() == record.len() && window.position == record.position();
    if !same {
        return (record, Vec::new());
    }
    let linear = laguerre::fit(&window.command, &window.position);
    let explained: Vec<f64> =
        window.position.iter().zip(&linear.residual).map(|(position, left)| position - left).collect();
    let spikes = spikes::spikes(&linear.residual, &explained, &window.position);
    let slip = slip(&linear, &window);
    let mut words = Vec::new();
    if !spikes.is_empty() {
        words.push(format!("{} spikes are left out", spikes.len()));
    }
    if let Some((sample, height)) = slip {
        let height = crate::digits::significant(height, 3);
        words.push(format!(
            "the level changes by {height} at {:.4} s: a sensor slip, subtracted",
            record.time()[sample]
        ));
    }
    let words = words.into_iter().map(|word| format!("{}: {word}", record.source().display())).collect();
    (record.without(&spikes, slip), words)
}

/// Sample and height of a slip.
pub fn slip(linear: &laguerre::LinearModel, window: &window::Window) -> Option<(usize, f64)> {
    // A slip is detected between parts of a record; near its ends a start or an end of the motion is similar.
    let end = window.position.len() / 12;
    let places = end..window.position.len() - end;
    let (residual, place, height) = linear.residual_with_step(&window.command, &window.position, places)?;
    level::step(&residual)?;
    linear.is_step_of_sensor(&window.command, &window.position, place).then_some((place, height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        signal::{Command, Interpolation},
        uniform_noise::uniform_noise,
    };
    use actuator_fmu::parameters::PositionUnit;

    fn record(spoil: impl Fn(usize) -> f64) -> Record {
        let mut noise = uniform_noise(5);
        let time: Vec<f64> = (0..4000).map(|n| 0.005 * f64::from(n)).collect();
        // A sweep from 0.5 to 8 Hz.
        let command: Vec<f64> = time.iter().map(|t| (std::f64::consts::TAU * (0.5 + 0.1875 * t) * t).sin()).collect();
        let position = command.iter().enumerate().map(|(n, value)| 0.8 * value + 0.01 * noise() + spoil(n)).collect();
        Record::new(Command { time, command }, position, PositionUnit::default(), Interpolation::Held, "made").unwrap()
    }

    #[test]
    fn spikes_are_left_out_and_a_slip_is_subtracted_and_both_are_said() {
        let healthy = record(|_| 0.0);
        let spoilt = record(|n| f64::from(u8::from(n >= 2345)) * 0.05 + if n % 1000 == 700 { 0.3 } else { 0.0 });
        let (mended, words) = without_sensor_faults(spoilt);
        assert_eq!(words.len(), 2, "{words:?}");
        let left_out: Vec<usize> = (0..4000).filter(|n| !mended.is_measured(*n)).collect();
        assert_eq!(left_out, [700, 1700, 2700, 3700]);
        let levels = |record: &Record, from: usize, to: usize| {
            record.position()[from..to].iter().sum::<f64>() - healthy.position()[from..to].iter().sum::<f64>()
        };
        assert!((levels(&mended, 2400, 2600) / 200.0).abs() < 1e-3);
        assert!(levels(&mended, 0, 600).abs() < 1e-9);
    }

    #[test]
    fn a_healthy_record_stays_as_it_is() {
        let healthy = record(|_| 0.0);
        let (same, words) = without_sensor_faults(healthy.clone());
        assert!(words.is_empty() && same == healthy);
    }
}
