//! Sampling rate compared with the motion: whether the response has decayed below half the sampling rate, and whether the rate is plausible
//! for an actuator.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use super::{
    finding::Finding,
    laguerre::{self, LinearModel},
    spectrum::{self, Band},
    window::Window,
};
use crate::{digits::significant, frequency::power_density, signal::record::Record};

/// Minimum fraction explained by a linear model for its response to be that of the actuator.
const TRUSTED_SHARE: f64 = 0.9;

/// Only lines of the command's spectrum with at least this fraction of its maximum power show a response.
const EXCITED_POWER: f64 = 0.01;

/// If the response has not fallen to 1/√2 at this fraction of half the sampling rate, the actuator is sampled less than four times per
/// period of its bandwidth.
const LATEST_SHARE: f64 = 0.5;

/// Samples per period of the fastest motion beyond which more add no information.
const ABUNDANT: f64 = 500.0;

/// Fastest motion accepted for an actuator without a warning [Hz]: servo valves reach some hundred hertz.
const FASTEST_HZ: f64 = 1000.0;

/// Samples per period of the highest frequency of a command for estimating its response.
const SAMPLES_IN_PERIOD: f64 = 25.0;

/// Minimum and maximum number of samples for this.
const FEWEST_SAMPLES: usize = 500;
const MOST_SAMPLES: usize = 60_000;

/// A record over its whole length, thinned, with the linear model of its response. The liveliest part of a long record, where a sweep is
/// fast, lacks its slow start, and a model at thousands of samples per period lacks slow motion. `None` if that part is the whole record,
/// or the data are insufficient.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of samples
fn from_end_to_end(whole: &Window, part: &Window, command: &Band) -> Option<(Window, LinearModel)> {
    let group = (1.0 / (SAMPLES_IN_PERIOD * command.highest_hz * whole.interval_s)).max(1.0) as usize;
    let count = whole.position.len() / group;
    if group == 1 && whole.position.len() == part.position.len() {
        return None;
    }
    let enough = (FEWEST_SAMPLES..=MOST_SAMPLES).contains(&count) && whole.load.is_none();
    enough.then(|| {
        let grouped = whole.grouped(group);
        let linear = laguerre::fit(&grouped.command, &grouped.position);
        (grouped, linear)
    })
}

/// Findings on the sampling rate.
pub fn findings(
    window: &Window,
    linear: &LinearModel,
    whole: &Window,
    command: &Band,
    record: &Record,
) -> Vec<Finding> {
    let time = record.time();
    let nyquist_hz = 0.5 / window.interval_s;
    let motion = spectrum::band(&window.position, window.interval_s);
    let mut findings = Vec::new();
    if motion.highest_hz > FASTEST_HZ && !record.time_unit_declared() && linear.share > TRUSTED_SHARE {
        let sentence = format!(
            "the position moves at up to {} Hz, faster than actuators do: the times are likely in another unit",
            significant(motion.highest_hz, 3)
        );
        let remedy = "check the unit of the time column, and give --time-unit s if it is seconds";
        findings.push(Finding::warning("fast_time", sentence, remedy).at(window.start, time));
    }
    let samples = 2.0 * nyquist_hz / motion.highest_hz;
    if samples > ABUNDANT {
        let sentence = format!(
            "{} samples per period of the fastest motion, {} Hz: more than the record needs",
            significant(samples, 3),
            significant(motion.highest_hz, 3)
        );
        findings.push(Finding::note("abundant_sampling", sentence));
    }
    if linear.share < TRUSTED_SHARE {
        return findings;
    }
    let end_to_end = from_end_to_end(whole, window, command);
    let (read, model) = end_to_end
        .as_ref()
        .filter(|(_, model)| model.share >= TRUSTED_SHARE)
        .map_or((window, linear), |(read, model)| (read, model));
    let lines = excited_lines(read, command);
    let Some(shown) = lines.last().copied() else { return findings };
    if rises_from_nothing(model, read.interval_s, &lines) {
        let sentence =
            "for slow commands the response vanishes in proportion to frequency, like that of a rate or a loop error";
        let remedy = "check that the column is the position, not its rate or the error of a controller";
        findings.push(Finding::warning("no_static_response", sentence, remedy));
        return findings;
    }
    match bandwidth(model, read.interval_s, &lines) {
        Some(hz) if hz <= LATEST_SHARE * nyquist_hz => {
            let sentence =
                format!("the response has fallen to 0.71 of its low-frequency value at {} Hz", significant(hz, 3));
            findings.push(Finding::note("bandwidth", sentence));
        }
        None if shown < LATEST_SHARE * nyquist_hz => {
            let sentence = format!("the command does not reach the bandwidth: up to {} Hz", significant(shown, 3));
            findings.push(Finding::note(
                "bandwidth",
                sentence + " the response stays above 0.71 of its low-frequency value",
            ));
        }
        _ => {
            let sentence = format!(
                "the bandwidth exceeds {} Hz, half the Nyquist frequency of {} samples/s",
                significant(LATEST_SHARE * nyquist_hz, 3),
                significant(2.0 * nyquist_hz, 4)
            );
            let remedy = "record at eight times the bandwidth or more, and declare how the command moves between samples (--hold or --linear)";
            findings.push(Finding::warning("slow_sampling", sentence, remedy).at(window.start, time));
        }
    }
    findings
}

/// Frequencies at which the command has power [Hz].
fn excited_lines(window: &Window, band: &Band) -> Vec<f64> {
    let mean = window.command.iter().sum::<f64>() / window.command.len() as f64;
    let about: Vec<f64> = window.command.iter().map(|value| value - mean).collect();
    let mut density = power_density(&[about], window.interval_s);
    density.retain(|[hz, _]| *hz > 0.0 && (band.lowest_hz..=band.highest_hz).contains(hz));
    let greatest = density.iter().fold(0.0, |greatest: f64, [_, density]| greatest.max(*density));
    density.retain(|[_, density]| *density >= EXCITED_POWER * greatest);
    density.into_iter().map(|[hz, _]| hz).collect()
}

/// Whether the response rises from near zero with the frequency, within the excited band.
fn rises_from_nothing(linear: &LinearModel, interval_s: f64, lines: &[f64]) -> bool {
    /// Maximum response at the lowest line, relative to the largest.
    const NEXT_TO_NOTHING: f64 = 0.2;
    /// Minimum ratio of the largest response to the lowest.
    const RISES: [(f64, std::ops::Range<f64>); 2] = [(2.0, 1.6..2.4), (3.0, 2.2..3.8)];
    let Some(lowest) = lines.first() else { return false };
    let magnitude = |hz: f64| linear.magnitude(TAU * hz * interval_s);
    let greatest = lines.iter().map(|hz| magnitude(*hz)).fold(0.0, f64::max);
    let rise = |times: f64| magnitude(times * lowest) / magnitude(*lowest);
    magnitude(*lowest) < NEXT_TO_NOTHING * greatest && RISES.iter().all(|(times, rises)| rises.contains(&rise(*times)))
}

/// The first line at which the response has fallen to 1/√2 of that at the lowest [Hz].
fn bandwidth(linear: &LinearModel, interval_s: f64, lines: &[f64]) -> Option<f64> {
    let magnitude = |hz: f64| linear.magnitude(TAU * hz * interval_s);
    let start = magnitude(*lines.first()?);
    lines.iter().copied().find(|hz| magnitude(*hz) < FRAC_1_SQRT_2 * start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        inspect::inspect,
        signal::{
            Command, Interpolation,
            excitation::{Excitation, Kind},
            format::PositionUnit,
        },
    };

    /// The response of x' = ω (c - x), applied twice, to a random command up to a frequency.
    fn record(rate_hz: f64, band_hz: f64, omega: f64) -> Record {
        let excitation = Excitation {
            band_hz: [0.02 * band_hz, band_hz],
            rate_hz,
            duration_s: (4000.0 / rate_hz).max(30.0 / band_hz),
            ..Excitation::new(Kind::Random)
        };
        answered(excitation.command().unwrap(), rate_hz, omega)
    }

    fn answered(Command { time, command }: Command, rate_hz: f64, omega: f64) -> Record {
        const FINE: u32 = 20; // substeps per sample
        let (mut one, mut two) = (0.0, 0.0);
        let position = command.iter().map(|command| {
            let measured = two;
            for _ in 0..FINE {
                let change = (omega / rate_hz / f64::from(FINE)).min(1.0);
                one += change * (command - one);
                two += change * (one - two);
            }
            measured
        });
        let position = position.collect();
        Record::new(Command { time, command }, position, PositionUnit::Degree, Interpolation::Held, "made").unwrap()
    }

    fn has(record: &Record, kind: &str) -> bool {
        inspect(record).findings.iter().any(|finding| finding.kind == kind)
    }

    #[test]
    fn the_bandwidth_of_a_sweep_is_that_of_the_servo_at_any_rate() {
        // x' = ω (c - x), applied twice, is at 1/√2 at 0.6436 of ω.
        let omega = 70.0;
        let truth = omega / TAU * (2.0_f64.sqrt() - 1.0).sqrt();
        for (rate_hz, duration_s) in [(200.0, 60.0), (1000.0, 100.0), (5000.0, 40.0)] {
            let excitation = Excitation { band_hz: [0.1, 20.0], rate_hz, duration_s, ..Excitation::new(Kind::Sweep) };
            let found = inspect(&answered(excitation.command().unwrap(), rate_hz, omega));
            let finding = found.findings.iter().find(|finding| finding.kind == "bandwidth").unwrap();
            let hz: f64 = finding.sentence.split_whitespace().rev().nth(1).unwrap().parse().unwrap();
            assert!((hz / truth - 1.0).abs() < 0.1, "{rate_hz} samples/s: {hz} of {truth} Hz");
            let band = found.excited_band;
            assert!(band.lowest_hz < 0.35 && (band.highest_hz - 20.0).abs() < 0.3, "{rate_hz} samples/s: {band:?}");
        }
    }

    #[test]
    fn a_response_that_is_not_over_at_half_the_rate_is_said() {
        let slow = record(50.0, 22.0, 400.0);
        assert!(has(&slow, "slow_sampling"), "{:?}", inspect(&slow).findings);
        for (rate_hz, band_hz) in [(200.0, 12.0), (500.0, 12.0), (500.0, 200.0)] {
            let healthy = record(rate_hz, band_hz, 150.0);
            assert!(!has(&healthy, "slow_sampling") && has(&healthy, "bandwidth"), "{:?}", inspect(&healthy).findings);
        }
    }

    #[test]
    fn times_in_which_an_actuator_would_answer_within_a_microsecond_are_asked_about() {
        assert!(has(&record(2e5, 1.2e4, 1.5e5), "fast_time"));
        assert!(!has(&record(2000.0, 120.0, 1500.0), "fast_time"));
        assert!(has(&record(20_000.0, 12.0, 150.0), "abundant_sampling"));
        assert!(!has(&record(2000.0, 12.0, 150.0), "abundant_sampling"));
    }
}
