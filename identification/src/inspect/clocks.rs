//! Whether command and position have a common clock, from one record:
//!
//! - A position ahead of its command by less than a sample: no actuator responds before the command.
//! - A position that moves before a command at rest steps: as above, if the actuator's own lag hides the lead from a correlation.
//! - A lag that grows steadily through the record, as from two clocks with different rates: with ŷ the response of a time-invariant linear
//!   model and r = y - ŷ, the lag d of a part of the record is that of r ≈ -d ŷ'.
//!
//! A position measured late, but before the next sample of a held command, shows no lead. A constant delay of the position is not
//! distinguishable from one of the actuator, nor, in a sweep, a lag that grows with time from one that grows with frequency.

use super::{
    correlation::Correlation,
    finding::Finding,
    laguerre::LinearModel,
    response::{CLEAR_CORRELATION, GREATEST_LEAD},
    spectrum::rests,
    window::Window,
};
use crate::{digits::significant, linear_least_squares::dot, signal::record::rms};

/// Findings on the clocks of both columns.
pub fn findings(window: &Window, linear: &LinearModel, correlation: Correlation, time: &[f64]) -> Vec<Finding> {
    let clear = correlation.coefficient.abs() >= CLEAR_CORRELATION;
    if !clear || correlation.lag_samples < -GREATEST_LEAD {
        return Vec::new();
    }
    let remedy = "log both columns with one clock: each position with the command in force when it was measured";
    let mut findings = Vec::new();
    if let Some(lead) = lead(window, linear, correlation) {
        let lead_s = significant(lead * window.interval_s, 3);
        let sentence = format!("the position leads its command by {lead:.2} of a sample, {lead_s} s");
        findings.push(Finding::warning("clock_lead", sentence, remedy).at(window.start, time));
    } else if let Some(early) = early_motion(window) {
        let sentence = format!(
            "the position moves before its command, by {} of the step on average in {} steps: the columns have different clocks",
            significant(early.share, 2),
            early.steps
        );
        findings.push(Finding::warning("clock_lead", sentence, remedy).at(window.start + early.first, time));
    }
    if let Some(drift) = lag_drift(window, linear) {
        let seconds = drift * window.interval_s;
        let rate = 1e6 * drift / window.position.len() as f64;
        let sentence = format!(
            "the lag of the position grows by {} s over the record, {rate:.0} parts per million, as with two clocks of different rates",
            significant(seconds, 3)
        );
        findings.push(Finding::warning("clock_rates", sentence, remedy).at(window.start, time));
    }
    findings
}

/// Minimum significant lead [samples], and in standard errors.
const LEAST_LEAD: f64 = 0.25;
const LEAD_SIGMAS: f64 = 6.0;

/// Mean lead of the position [samples].
fn lead(window: &Window, linear: &LinearModel, correlation: Correlation) -> Option<f64> {
    let steps: Vec<f64> = window.position.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let error = rms(&linear.residual) / (rms(&steps) * (window.position.len() as f64).sqrt());
    let lead = -correlation.lag_samples;
    (lead > LEAST_LEAD && lead > LEAD_SIGMAS * error).then_some(lead)
}

/// Motion ahead of steps.
struct EarlyMotion {
    /// Last sample before the first step.
    first: usize,
    steps: usize,
    /// Mean motion in the direction of the step, relative to it.
    share: f64,
}

/// Final samples of a rest, in which an actuator is at rest [samples], and minimum number of steps.
const STILL: usize = 8;
const FEWEST_STEPS: usize = 3;

/// Minimum significant motion ahead of a step, in the direction of nearly all steps: fraction of the step, and standard errors.
const EARLY_SHARE: f64 = 0.002;
const EARLY_SIGMAS: f64 = 8.0;

/// Whether the position moves at the last sample before commands step from a rest.
fn early_motion(window: &Window) -> Option<EarlyMotion> {
    let mut motions = Vec::new();
    let mut first = None;
    for rest in rests(&window.command) {
        let settled = rest.len() > 2 * STILL && rest.end < window.command.len();
        if !settled {
            continue;
        }
        let step = window.command[rest.end] - window.command[rest.end - 1];
        let before = &window.position[rest.end - 1 - STILL..rest.end - 1];
        // A motion that has not settled is extrapolated by a line to the last sample.
        let (mean, middle) = (before.iter().sum::<f64>() / STILL as f64, (STILL as f64 - 1.0) / 2.0);
        let place: Vec<f64> = (0..STILL).map(|n| n as f64 - middle).collect();
        let slope = dot(&place, before) / dot(&place, &place);
        let expected = mean + slope * (STILL as f64 - middle);
        motions.push((window.position[rest.end - 1] - expected) / step);
        first.get_or_insert(rest.end - 1);
    }
    let steps = motions.len();
    let share = motions.iter().sum::<f64>() / steps as f64;
    let scatter = rms(&motions.iter().map(|motion| motion - share).collect::<Vec<f64>>());
    let error = scatter / (steps as f64).sqrt();
    let alike = motions.iter().filter(|motion| (**motion > 0.0) == (share > 0.0)).count();
    let found = steps >= FEWEST_STEPS && share.abs() > EARLY_SHARE && share.abs() > EARLY_SIGMAS * error;
    (found && 10 * alike >= 9 * steps).then(|| EarlyMotion { first: first.unwrap_or(0), steps, share: share.abs() })
}

/// Number of parts in which the lag is measured.
const PARTS: usize = 8;

/// Significant growth of the lag: samples, fraction of its variance over the parts (weighted by their accuracy) explained by a line, and
/// fraction of the residual. A limit or friction that acts in a part of the record does not give a line.
const LEAST_GROWTH: f64 = 0.2;
const LINE_SHARE: f64 = 0.95;
const RESIDUAL_SHARE: f64 = 0.3;

/// Growth of the lag through the record [samples].
fn lag_drift(window: &Window, linear: &LinearModel) -> Option<f64> {
    let count = window.position.len();
    let explained: Vec<f64> =
        window.position.iter().zip(&linear.residual).map(|(position, residual)| position - residual).collect();
    let rate: Vec<f64> = explained.windows(3).map(|three| 0.5 * (three[2] - three[0])).collect();
    let residual = &linear.residual[1..count - 1];
    let length = rate.len() / PARTS;
    let parts: Vec<(f64, f64, f64)> = (0..PARTS)
        .map(|part| {
            let samples = part * length..(part + 1) * length;
            let weight = dot(&rate[samples.clone()], &rate[samples.clone()]);
            let lag = -dot(&residual[samples.clone()], &rate[samples]) / weight.max(f64::MIN_POSITIVE);
            (part as f64 - 0.5 * (PARTS as f64 - 1.0), lag, weight)
        })
        .collect();
    let sum = |of: &dyn Fn(&(f64, f64, f64)) -> f64| parts.iter().map(|part| part.2 * of(part)).sum::<f64>();
    let total = sum(&|_| 1.0);
    let (place, lag) = (sum(&|part| part.0) / total, sum(&|part| part.1) / total);
    let across = sum(&|part| (part.0 - place).powi(2));
    let together = sum(&|part| (part.0 - place) * (part.1 - lag));
    let scatter = sum(&|part| (part.1 - lag).powi(2));
    // No single part determines the line.
    let even = parts.iter().all(|part| part.2 < 0.5 * total && part.2 > 0.01 * total);
    let growth = together / across * PARTS as f64;
    let is_line = together * together > LINE_SHARE * across * scatter;
    let taken = together * together / across > RESIDUAL_SHARE * dot(residual, residual);
    (even && is_line && taken && growth.abs() > LEAST_GROWTH).then_some(growth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        inspect::{correlation::correlate, laguerre, window::NoiseLeft},
        uniform_noise::uniform_noise,
    };

    const INTERVAL_S: f64 = 0.005;

    /// The response of x' = ω (c - x), applied twice, to a command held for this many samples, measured at the times n + shift + n growth /
    /// count [samples], with noise.
    fn record(hold: usize, omega: f64, shift: f64, growth: f64) -> (Window, LinearModel, Correlation) {
        const COUNT: usize = 6000;
        const FINE: usize = 40; // substeps per sample
        let (mut next, mut noise) = (uniform_noise(3), uniform_noise(4));
        let levels: Vec<f64> = (0..=COUNT / hold + 1).map(|_| next()).collect();
        let at = |sample: f64| levels[(sample.max(0.0) as usize / hold).min(levels.len() - 1)];
        let command: Vec<f64> = (0..COUNT).map(|n| at(n as f64)).collect();
        let (mut one, mut two) = (command[0], command[0]);
        let mut fine = Vec::with_capacity((COUNT + 10) * FINE);
        for step in 0..(COUNT + 10) * FINE {
            fine.push(two);
            let input = at(step as f64 / FINE as f64);
            let change = omega * INTERVAL_S / FINE as f64;
            two += change * (one - two);
            one += change * (input - one);
        }
        let position = (0..COUNT).map(|n| {
            let measured = n as f64 + shift + growth * n as f64 / COUNT as f64;
            fine[(measured.max(0.0) * FINE as f64) as usize] + 0.002 * noise()
        });
        let window = Window {
            start: 0,
            interval_s: INTERVAL_S,
            position: position.collect(),
            command,
            load: None,
            noise_left: NoiseLeft::ALL,
        };
        let linear = laguerre::fit(&window.command, &window.position);
        let correlation = correlate(&window.command, &window.position);
        (window, linear, correlation)
    }

    fn kinds(record: &(Window, LinearModel, Correlation)) -> Vec<&'static str> {
        let time: Vec<f64> = (0..record.0.position.len()).map(|n| n as f64 * INTERVAL_S).collect();
        findings(&record.0, &record.1, record.2, &time).iter().map(|finding| finding.kind).collect()
    }

    #[test]
    fn one_clock_is_no_finding_and_neither_is_a_delay() {
        for (hold, omega) in [(4, 800.0), (40, 100.0), (10, 300.0)] {
            assert!(kinds(&record(hold, omega, 0.0, 0.0)).is_empty(), "{hold}");
            assert!(kinds(&record(hold, omega, -2.6, 0.0)).is_empty(), "{hold}");
        }
    }

    #[test]
    fn a_position_measured_after_the_next_command_is_found() {
        let early = record(4, 1500.0, 1.3, 0.0);
        assert_eq!(kinds(&early), ["clock_lead"], "{:?}", early.2);
        // Slow enough to hide it from the correlation, but not from the steps.
        let hidden = record(40, 300.0, 1.6, 0.0);
        assert!(hidden.2.lag_samples > 0.0, "{:?}", hidden.2);
        assert_eq!(kinds(&hidden), ["clock_lead"]);
    }

    #[test]
    fn clocks_of_different_rates_are_found_with_their_difference() {
        for growth in [1.0, -2.0] {
            let found = record(10, 100.0, -3.0, growth);
            assert_eq!(kinds(&found), ["clock_rates"]);
            let lag = lag_drift(&found.0, &found.1).unwrap();
            assert!((lag + growth).abs() < 0.1 * growth.abs(), "{lag}");
        }
    }

    #[test]
    fn a_gain_that_drifts_is_no_clock() {
        let (mut window, ..) = record(10, 100.0, -3.0, 0.0);
        let count = window.position.len() as f64;
        window.position.iter_mut().enumerate().for_each(|(n, value)| *value *= 1.0 + 0.2 * n as f64 / count);
        let linear = laguerre::fit(&window.command, &window.position);
        assert_eq!(lag_drift(&window, &linear), None);
    }
}
