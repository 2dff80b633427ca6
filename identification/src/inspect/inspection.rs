//! All findings on one record.

use std::ops::Range;

use serde::Serialize;

use super::{
    bandwidth, clocks,
    correlation::{self, Correlation},
    finding::{Finding, Severity},
    laguerre::{self, LinearModel},
    level,
    noise::{self, Noise},
    response,
    sampling::{self, Clock},
    sensor_faults,
    spectrum::{self, Band},
    spoiled, standing, values,
    window::{self, Window},
};
use crate::{
    diagnose::quantiser::step_of,
    digits::{significant, with_unit},
    signal::record::{Record, rms},
    spikes,
};

/// Result of the inspection of one record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// Its file.
    pub name: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Number of samples.
    pub samples: usize,
    /// Length \[s\].
    pub duration_s: f64,
    /// Unit of command and position.
    pub unit: String,
    /// How it is sampled.
    pub sampling: Clock,
    /// Fraction of the position's variance, without the contribution of a recorded load, that is explained by a flexible linear model of
    /// the command \[1\].
    pub following_share: f64,
    /// Ratio of the explained position to the command, both rms; negative for opposite motion.
    pub gain: f64,
    /// Lag of the position behind the command by cross-correlation \[s\].
    pub lag_s: f64,
    /// Cross-correlation there, from -1 to 1.
    pub correlation: f64,
    /// Band of 99 % of the command's power \[Hz\].
    pub excited_band: Band,
    /// Period of the command \[s\], if it repeats at least three times.
    pub period_s: Option<f64>,
    /// Fraction of the samples at which the command rests \[1\].
    pub quiet_share: f64,
    /// Step of which all positions are multiples; 0 if there is none, or only that of the digits in the file.
    pub position_step: f64,
    /// As above for the command.
    pub command_step: f64,
    /// Noise of the measurement, and how it was estimated.
    pub noise: Noise,
    /// Findings, the most severe first.
    pub findings: Vec<Finding>,
}

impl Inspection {
    /// The highest severity of the findings.
    #[must_use]
    pub fn severity(&self) -> Severity {
        self.findings.iter().map(|finding| finding.severity).max().unwrap_or(Severity::Note)
    }

    /// Sentences of the warnings.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        let graver = self.findings.iter().filter(|finding| finding.severity == Severity::Warning);
        graver.map(|finding| format!("{}: {}", self.name, finding.text()))
    }
}

/// Steps below this fraction of the range are digits of the file.
const DIGITS_OF_FILE: f64 = 1e-5;

/// A record with its linear model.
struct Examined {
    /// As measured, and the linear model of that.
    measured: Window,
    with_load: LinearModel,
    /// The same without the contribution of a recorded load.
    window: Window,
    linear: LinearModel,
    correlation: Correlation,
    /// Position minus residual.
    explained: Vec<f64>,
    /// Ratio of the explained position to the command, both rms; negative for opposite motion.
    gain: f64,
    spikes: Vec<usize>,
}

/// Findings that show whether there is a response at all, and the linear model if the record allows one.
fn examine(record: &Record, clock: &Clock) -> (Vec<Finding>, Option<Examined>) {
    let (time, command, position) = (record.time(), record.command(), record.position());
    let mut findings = sampling::findings(clock, time, record.time_unit_declared());
    if !record.understood().is_empty() {
        findings.push(Finding::note("format", format!("read as: {}", record.understood().join("; "))));
    }
    let barred = [("the command", command), ("the position", position)];
    findings.extend(barred.into_iter().find_map(|(name, values)| values::overflow(name, values, time)));
    if findings.iter().all(|finding| finding.kind != "overflow") {
        findings.extend(values::standstill(command, position));
        findings.extend(values::copy_of_command(command, position));
    }
    let unusable = ["overflow", "command_rests", "position_rests", "position_is_command"];
    if findings.iter().any(|finding| unusable.contains(&finding.kind)) {
        return (findings, None);
    }
    let measured = window::window(record, clock);
    let with_load = laguerre::fit(&measured.command, &measured.position);
    let (window, linear) = beside_load(&measured, &with_load);
    let correlation = correlation::correlate(&window.command, &window.position);
    let explained: Vec<f64> =
        window.position.iter().zip(&linear.residual).map(|(position, residual)| position - residual).collect();
    // Parts without response may correlate with the opposite sign; the response to a constant then decides.
    let sign = if correlation.coefficient < 0.0 && linear.gain < 0.0 { -1.0 } else { 1.0 };
    let gain = sign * deviation(&explained) / deviation(&window.command);
    findings.extend(spoiled::wraps(&measured, linear.share, record.unit().name(), time));
    findings.extend(spoiled::dropouts(&measured, time));
    findings.extend(response::findings(&window, linear.share, gain, correlation));
    let spikes = spikes::spikes(&linear.residual, &explained, &window.position);
    (findings, Some(Examined { measured, with_load, window, linear, correlation, explained, gain, spikes }))
}

impl Examined {
    /// The noise of a single record.
    fn noise(&self, period: Option<usize>, rests: &[Range<usize>]) -> Noise {
        // Spikes are not part of the noise.
        let mut position = self.measured.position.clone();
        spikes::bridge(&mut position, &self.spikes);
        let smooth = Window { position, ..self.window.clone() };
        own_noise(&smooth, &self.measured.position, &self.with_load, &self.spikes, self.correlation, period, rests)
    }
}

/// Inspects one record for its noise, and for findings that show whether there is a response at all.
#[must_use]
pub fn inspect_noise(record: &Record) -> Inspection {
    let clock = sampling::clock(record.time());
    let (findings, examined) = examine(record, &clock);
    let unresponsive = unresponsive(record, clock, findings);
    let Some(examined) = examined else { return unresponsive };
    let command = &examined.window.command;
    Inspection { noise: examined.noise(spectrum::period(command), &spectrum::rests(command)), ..unresponsive }
}

/// Inspects one record.
#[must_use]
pub fn inspect(record: &Record) -> Inspection {
    let (time, command, position) = (record.time(), record.command(), record.position());
    let clock = sampling::clock(time);
    let (mut findings, examined) = examine(record, &clock);
    let Some(examined) = examined else { return unresponsive(record, clock, findings) };
    let Examined { measured, window, linear, correlation, explained, .. } = &examined;
    let entire = window::whole(record, &clock);
    let band = spectrum::band(&entire.command, entire.interval_s);
    findings.extend(clocks::findings(window, linear, *correlation, time));
    findings.extend(bandwidth::findings(window, linear, &entire, &band, record));
    findings.extend(value_findings(record, window, linear, &examined.spikes));
    let ends = values::saturation(&measured.command, &measured.position);
    findings.extend(saturation(record, measured, &ends));
    if measured.load.is_none() {
        let said: Vec<f64> = ends.iter().map(|(end, ..)| *end).collect();
        findings.extend(standing::findings(record, window, explained, &said));
    }
    let period = spectrum::period(&window.command);
    let rests = spectrum::rests(&window.command);
    let judged = window.start..(window.start + window.position.len()).min(record.len());
    let position_step = coarse_step(position, judged.clone());
    if position_step > 0.0 {
        findings.push(Finding::note("quantisation", format!("positions are multiples of {position_step:.5e}")));
    }
    let noise = examined.noise(period, &rests);
    leave_causes(&mut findings);
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    Inspection {
        following_share: linear.share,
        gain: examined.gain,
        lag_s: correlation.lag_samples * window.interval_s,
        correlation: correlation.coefficient,
        excited_band: band,
        period_s: period.map(|samples| samples as f64 * window.interval_s),
        quiet_share: rests.iter().map(ExactSizeIterator::len).sum::<usize>() as f64 / window.command.len() as f64,
        position_step,
        command_step: coarse_step(command, judged),
        noise,
        findings,
        ..unresponsive(record, clock, Vec::new())
    }
}

/// Step of these values, if larger than the digits of the file; otherwise 0.
fn coarse_step(values: &[f64], judged: Range<usize>) -> f64 {
    let (low, high) = values::extremes(values);
    let step = step_of(&values[judged]);
    if step > DIGITS_OF_FILE * (high - low) { step } else { 0.0 }
}

/// The position without the contribution of a recorded load, and the linear model of the remainder: a load may imitate a lead, or hide a
/// response. The contribution is the part explained by the load jointly with the command or, if the load is itself a result of the
/// position, in addition to it: whichever gives the clearer response.
fn beside_load(measured: &Window, linear: &LinearModel) -> (Window, LinearModel) {
    let Some(load) = &measured.load else { return (measured.clone(), linear.clone()) };
    let left = laguerre::fit(load, &linear.residual).residual;
    let explained = measured.position.iter().zip(&linear.residual).map(|(position, residual)| position - residual);
    let beyond: Vec<f64> = explained.zip(left).map(|(explained, left)| explained + left).collect();
    let beside = linear.residual_beside(load, &measured.command, &measured.position);
    let follows = |position: &[f64]| correlation::correlate(&measured.command, position).coefficient.abs();
    let position = if follows(&beside) > follows(&beyond) { beside } else { beyond };
    let linear = laguerre::fit(&measured.command, &position);
    (Window { position, ..measured.clone() }, linear)
}

/// For a record without any response.
fn unresponsive(record: &Record, clock: Clock, findings: Vec<Finding>) -> Inspection {
    Inspection {
        name: record.source().display().to_string(),
        sha256: record.sha256().to_owned(),
        samples: record.len(),
        duration_s: record.duration_s(),
        unit: record.unit().name().to_owned(),
        sampling: clock,
        following_share: 0.0,
        gain: 0.0,
        lag_s: 0.0,
        correlation: 0.0,
        excited_band: Band { lowest_hz: 0.0, highest_hz: 0.0 },
        period_s: None,
        quiet_share: 0.0,
        position_step: 0.0,
        command_step: 0.0,
        noise: Noise { rms: 0.0, source: noise::Source::Assumed },
        findings,
    }
}

/// Standard deviation.
pub fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    rms(&values.iter().map(|value| value - mean).collect::<Vec<f64>>())
}

/// Spikes, steps and drifts.
fn value_findings(record: &Record, window: &Window, linear: &LinearModel, spikes: &[usize]) -> Vec<Finding> {
    let time = record.time();
    let mut findings = Vec::new();
    if let Some(first) = spikes.first() {
        findings.push(
            Finding::warning(
                "spikes",
                format!("spikes in the position: {}", spikes.len()),
                "fit and frf leave them out; look at the first one",
            )
            .at(window.start + first, time),
        );
    }
    let shown = level::step(&linear.residual)
        .filter(|(place, _)| linear.is_step_of_sensor(&window.command, &window.position, *place));
    if let Some((place, height)) = shown.or_else(|| sensor_faults::slip(linear, window)) {
        findings.push(
            Finding::warning(
                "level_step",
                format!(
                    "the level of the position changes by {} from here on",
                    with_unit(height, 4, record.unit().name())
                ),
                "divide the record there, or leave one part out",
            )
            .at(window.start + place, time),
        );
    } else if let Some(drift) = linear
        .residual_with_drift(&window.command, &window.position)
        .and_then(|residual| level::drift(&residual))
        .filter(|drift| is_visible(*drift, &window.position))
    {
        findings.push(
            Finding::warning(
                "level_drift",
                format!(
                    "the level of the position drifts by {} over {} s",
                    with_unit(drift, 4, record.unit().name()),
                    significant(window.position.len() as f64 * window.interval_s, 4)
                ),
                "record with the sensor warm and its zero checked before and after; diagnose models a steady drift as sensor_bias.drift",
            )
            .at(window.start, time),
        );
    }
    findings
}

/// Removes findings that follow from others: a position that is frozen for a part of the record has a different level there, held values
/// jump, and a rate has no unit factor.
fn leave_causes(findings: &mut Vec<Finding>) {
    const FOLLOWS: [(&str, &[&str]); 3] =
        [("frozen", &["level_step", "level_drift"]), ("held_position", &["spikes"]), ("no_static_response", &["unit"])];
    for (cause, effects) in FOLLOWS {
        if findings.iter().any(|finding| finding.kind == cause) {
            findings.retain(|finding| !effects.contains(&finding.kind));
        }
    }
    let stands = findings.iter().find(|finding| finding.kind == "frozen").map(Finding::text);
    let refusal = findings.iter_mut().find(|finding| finding.kind == "no_response");
    if let (Some(finding), Some(stands)) = (refusal, stands) {
        finding.remedy = stands;
    }
}

/// Ends of the range at which a position stays.
fn saturation(record: &Record, window: &Window, ends: &[(f64, usize, usize)]) -> impl Iterator<Item = Finding> {
    ends.iter().map(|(end, first, count)| {
        let end = significant(*end, 5);
        let sentence = format!("the position stays at {end} for {count} samples while the command moves on");
        Finding::note("saturation", sentence).at(window.start + first, record.time())
    })
}

/// Whether a drift exceeds this fraction of the range: a sweep with a slightly asymmetric response can cause as much.
fn is_visible(drift: f64, position: &[f64]) -> bool {
    const VISIBLE_SHARE: f64 = 0.02;
    let (low, high) = values::extremes(position);
    drift.abs() > VISIBLE_SHARE * (high - low)
}

/// The noise of a single record; the position of the window is without spikes.
fn own_noise(
    window: &Window,
    with_spikes: &[f64],
    linear: &LinearModel,
    spikes: &[usize],
    correlation: Correlation,
    period: Option<usize>,
    rests: &[std::ops::Range<usize>],
) -> Noise {
    // Ten lags, within which a second-order motion has settled to a thousandth.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of samples
    let settling = (10.0 * correlation.lag_samples.abs()).max(20.0) as usize;
    let without_spikes = |mut left: Vec<f64>| {
        spikes::bridge(&mut left, spikes);
        left
    };
    let residual = without_spikes(linear.residual.clone());
    let above = || {
        let band = spectrum::band(&window.command, window.interval_s);
        let beside_plays = without_spikes(linear.residual_beside_plays(&window.command, with_spikes));
        let of = |values: &[f64]| noise::above_band(values, window.interval_s, &band, window.noise_left);
        // Both contain the noise; the smaller one contains less motion.
        of(&residual).into_iter().chain(of(&beside_plays)).min_by(|one, other| one.rms.total_cmp(&other.rms))
    };
    period
        .and_then(|period| noise::of_periods(&window.position, period))
        .or_else(|| noise::of_quiet(&window.position, rests, settling, window.start > 0))
        .map(|noise| noise.before_interpolation(window.noise_left))
        .or_else(above)
        .unwrap_or_else(|| Noise { rms: rms(&residual), source: noise::Source::Assumed })
}
