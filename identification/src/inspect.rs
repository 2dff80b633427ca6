//! What a record is, before anything is estimated from it: how it is sampled, whether its position follows its command, in which
//! units, with which lag and sign, how noisy, and what in it is suspect.
//!
//! [`inspect`] looks at one record, [`compare_records`] at several together; [`admit`] refuses what nothing can be estimated from and
//! passes the warnings on.

mod correlation;
pub mod finding;
pub(crate) mod laguerre;
pub mod noise;
mod sampling;
pub(crate) mod spectrum;
pub mod values;
mod window;

use actuator_fmu::error::{Error, Result};
use serde::Serialize;

use crate::{
    diagnose::quantiser::step_of,
    digits::significant,
    signal::record::{Record, rms},
    spikes,
};
use correlation::Correlation;
use finding::{Finding, Severity};
use noise::Noise;
use sampling::Clock;
use spectrum::Band;
use window::Window;

/// Everything that is said of a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// Its file.
    pub name: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Number of samples.
    pub samples: usize,
    /// Length [s].
    pub duration_s: f64,
    /// Unit of command and position.
    pub unit: String,
    /// How it is sampled.
    pub sampling: Clock,
    /// Share of the position's variance that a flexible linear model of the command explains [1].
    pub following_share: f64,
    /// Ratio of the explained position to the command, both rms; negative where they move against each other.
    pub gain: f64,
    /// Position behind command by cross-correlation [s].
    pub lag_s: f64,
    /// Cross-correlation there, from -1 to 1.
    pub correlation: f64,
    /// Band of 99 % of the command's power [Hz].
    pub excited_band: Band,
    /// Period of the command [s], where it repeats itself at least three times.
    pub period_s: Option<f64>,
    /// Share of the samples at which the command rests [1].
    pub quiet_share: f64,
    /// Step of which all positions are multiples; 0 where there is none.
    pub position_step: f64,
    /// The same of the command.
    pub command_step: f64,
    /// Noise of the measurement, and how it is known.
    pub noise: Noise,
    /// What is to be said of it, the gravest first.
    pub findings: Vec<Finding>,
}

impl Inspection {
    /// The gravest of the findings.
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

/// Below this share of the variance, explained by a flexible linear model in the sample, a position does not follow its command:
/// limits, play and friction leave a linear share well above.
const LEAST_SHARE: f64 = 0.3;

/// A share below this, or of a position that does not clearly correlate with its command, is compared with what the same model explains of the position shifted against the command.
const DOUBTFUL_SHARE: f64 = 0.7;

/// Where it explains this part of it as well, what it explains is the smoothness of both signals, and no response.
const BY_CHANCE: f64 = 0.6;

/// Shifts of the position, as shares of the record.
const SHIFTS: [f64; 6] = [0.23, 0.34, 0.45, 0.56, 0.67, 0.78];

/// A position that correlates this well with its command is the response to it, at whatever lag.
const CLEAR_CORRELATION: f64 = 0.6;

/// Greatest lead that two columns of one logger can have [samples].
const GREATEST_LEAD: f64 = 1.0;

/// Greatest lag in periods of the fastest motion. A servo of second order answers up to about its natural frequency, with a lag
/// of 2 ζ/ω or about a fifth of a period; three whole periods are a clock that is off.
const GREATEST_LAG_PERIODS: f64 = 3.0;

/// Gains that are a factor of units rather than of an actuator, with what they are, and how close they must be.
const UNIT_FACTORS: [(f64, &str); 4] = [
    (57.295_779_513, "a command in rad against a position in deg"),
    (0.017_453_292_5, "a command in deg against a position in rad"),
    (1000.0, "a command in m against a position in mm"),
    (0.001, "a command in mm against a position in m"),
];
const UNIT_TOLERANCE: f64 = 0.25;

/// Steps below this share of the range are digits of the file.
const DIGITS_OF_FILE: f64 = 1e-5;

/// Looks at one record.
#[must_use]
pub fn inspect(record: &Record) -> Inspection {
    let (time, command, position) = (record.time(), record.command(), record.position());
    let clock = sampling::clock(time);
    let mut findings = sampling::findings(&clock, time, record.time_unit_declared());
    if !record.understood().is_empty() {
        findings.push(Finding::note("format", format!("read as: {}", record.understood().join("; "))));
    }
    let barred = [("the command", command), ("the position", position)];
    findings.extend(barred.into_iter().find_map(|(name, values)| values::overflow(name, values, time)));
    if findings.iter().all(|finding| finding.kind != "overflow") {
        findings.extend(values::standstill(command, position));
    }
    let unusable = ["overflow", "command_rests", "position_rests"];
    if findings.iter().any(|finding| unusable.contains(&finding.kind)) {
        return unresponsive(record, clock, findings);
    }
    let window = window::window(record, &clock);
    let linear = laguerre::fit(&window.command, &window.position);
    let correlation = correlation::correlate(&window.command, &window.position);
    let band = spectrum::band(&window.command, window.interval_s);
    let explained: Vec<f64> =
        window.position.iter().zip(&linear.residual).map(|(position, residual)| position - residual).collect();
    // Parts without response may correlate with the opposite sign; the response to a constant then decides.
    let sign = if correlation.coefficient < 0.0 && linear.gain < 0.0 { -1.0 } else { 1.0 };
    let gain = sign * deviation(&explained) / deviation(&window.command);
    findings.extend(response_findings(&window, linear.share, gain, correlation));
    let spikes = spikes::spikes(&linear.residual, &explained);
    findings.extend(value_findings(record, &window, &linear.residual, &spikes));
    let period = spectrum::period(&window.command);
    let rests = spectrum::rests(&window.command);
    let judged = window.start..(window.start + window.position.len()).min(record.len());
    let position_step = step_of(&position[judged.clone()]);
    let (low, high) = values::extremes(position);
    if position_step > DIGITS_OF_FILE * (high - low) {
        findings.push(Finding::note("quantisation", format!("positions are multiples of {position_step:.5e}")));
    }
    // Spikes are no part of the noise.
    let (mut position, mut residual) = (window.position.clone(), linear.residual.clone());
    spikes::bridge(&mut position, &spikes);
    spikes::bridge(&mut residual, &spikes);
    let smooth = Window { position, ..window.clone() };
    let noise = own_noise(&smooth, &residual, correlation, &band, period, &rests);
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    Inspection {
        following_share: linear.share,
        gain,
        lag_s: correlation.lag_samples * window.interval_s,
        correlation: correlation.coefficient,
        excited_band: band,
        period_s: period.map(|samples| samples as f64 * window.interval_s),
        quiet_share: rests.iter().map(ExactSizeIterator::len).sum::<usize>() as f64 / window.command.len() as f64,
        position_step,
        command_step: step_of(&command[judged]),
        noise,
        findings,
        ..unresponsive(record, clock, Vec::new())
    }
}

/// Of a record in which nothing follows anything.
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
fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    rms(&values.iter().map(|value| value - mean).collect::<Vec<f64>>())
}

/// Whether and how the position follows.
fn response_findings(window: &Window, share: f64, gain: f64, correlation: Correlation) -> Vec<Finding> {
    let lag_s = correlation.lag_samples * window.interval_s;
    let mut findings = vec![Finding::note(
        "response",
        format!(
            "a flexible linear model of the command explains {:.1} % of the position; ratio {gain:.4}, lag {:.4} s",
            100.0 * share,
            lag_s
        ),
    )];
    let clear = correlation.coefficient.abs() >= CLEAR_CORRELATION;
    let fastest = spectrum::band(&window.position, window.interval_s).highest_hz;
    if clear && correlation.lag_samples < -GREATEST_LEAD {
        findings.push(Finding::refusal(
            "lead",
            format!("the position leads its command by {:.4} s", -lag_s),
            "check whether the columns are exchanged (--columns command=...,position=...) or have different clocks",
        ));
    } else if clear && lag_s * fastest > GREATEST_LAG_PERIODS {
        findings.push(Finding::refusal(
            "late",
            format!(
                "the position follows its command {lag_s:.3} s late, {:.0} periods of its fastest motion: the columns have different clocks",
                lag_s * fastest
            ),
            "shift one of the columns, or record both with one clock",
        ));
    } else if share < LEAST_SHARE || ((share < DOUBTFUL_SHARE || !clear) && is_by_chance(window, share)) {
        findings.push(Finding::refusal(
            "no_response",
            format!(
                "the position does not follow the command: a flexible linear model of it explains {:.1} % of the position",
                100.0 * share
            ),
            "check that both columns are of one record and in one order of time, and that the actuator was on",
        ));
    }
    if gain < 0.0 && clear {
        findings.push(Finding::warning(
            "sign",
            "the position moves against its command: opposite sign",
            "change the sign of one of the columns",
        ));
    }
    let factor = UNIT_FACTORS.iter().find(|(factor, _)| (gain.abs() / factor).ln().abs() < UNIT_TOLERANCE);
    if let Some((_, words)) = factor.filter(|_| share >= LEAST_SHARE) {
        findings.push(Finding::warning(
            "unit",
            format!("the position is {:.4} times the command, as of {words}", gain.abs()),
            "give both columns in one unit",
        ));
    }
    findings
}

/// Whether the model explains a position that is shifted against its command about as well.
fn is_by_chance(window: &Window, share: f64) -> bool {
    let count = window.position.len();
    let shifted = SHIFTS.iter().map(|part| {
        let mut position = window.position.clone();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of samples
        position.rotate_left((part * count as f64) as usize);
        laguerre::fit(&window.command, &position).share
    });
    shifted.fold(0.0, f64::max) > BY_CHANCE * share
}

/// Spikes, steps, drifts and ends of the range.
fn value_findings(record: &Record, window: &Window, residual: &[f64], spikes: &[usize]) -> Vec<Finding> {
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
    if let Some((place, height)) = values::level_step(residual) {
        findings.push(
            Finding::warning(
                "level_step",
                format!("the level of the position changes by {} from here on", significant(height, 4)),
                "divide the record there, or leave one part out",
            )
            .at(window.start + place, time),
        );
    }
    for (end, first, count) in values::saturation(&window.command, &window.position) {
        findings.push(
            Finding::note(
                "saturation",
                format!("the position stays at {} for {count} samples while the command moves on", significant(end, 5)),
            )
            .at(window.start + first, time),
        );
    }
    findings
}

/// The noise of a record by itself.
fn own_noise(
    window: &Window,
    residual: &[f64],
    correlation: Correlation,
    band: &Band,
    period: Option<usize>,
    rests: &[std::ops::Range<usize>],
) -> Noise {
    // Ten lags, within which a motion of second order has settled to a thousandth.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of samples
    let settling = (10.0 * correlation.lag_samples.abs()).max(20.0) as usize;
    period
        .and_then(|period| noise::of_periods(&window.position, period))
        .or_else(|| noise::of_quiet(&window.position, rests, settling))
        .or_else(|| noise::above_band(residual, window.interval_s, band))
        .unwrap_or(Noise { rms: rms(residual), source: noise::Source::Assumed })
}

/// Looks at several records together: the same data twice, and repeats of one motion, which tell the noise of both.
pub fn compare_records(records: &[&Record], inspections: &mut [Inspection]) {
    for second in 1..records.len() {
        for first in 0..second {
            let (one, other) = (records[first], records[second]);
            if one.sha256() == other.sha256() || (one.time() == other.time() && one.position() == other.position()) {
                let sentence = format!("it holds the same data as {}", one.source().display());
                let remedy = "give each record once: a copy adds no evidence, and checks nothing";
                inspections[second].findings.insert(0, Finding::warning("duplicate", sentence, remedy));
                continue;
            }
            let repeat = noise::of_repeat(one.command(), one.position(), other.command(), other.position());
            if let Some(noise) = repeat {
                for index in [first, second] {
                    let known = &mut inspections[index].noise;
                    let smaller = known.source == noise::Source::Repeats && known.rms <= noise.rms;
                    *known = if smaller { *known } else { noise };
                }
            }
        }
    }
}

/// Gains this far apart, as a logarithm, are of other units; wear and limits change a gain by much less.
const SAME_GAIN: f64 = 1.6;

/// The parts of a record between its gaps, as records with a start state of their own; parts that are too short to be records, or in
/// which the command rests, are left out. A record without gaps is its one part.
#[must_use]
pub fn segments(record: Record) -> Vec<Record> {
    let gaps = sampling::clock(record.time()).gaps;
    if gaps.is_empty() {
        return vec![record];
    }
    let ends: Vec<usize> = gaps.iter().map(|gap| gap + 1).chain([record.len()]).collect();
    let starts = std::iter::once(0).chain(ends.iter().copied());
    let parts: Vec<Record> = starts
        .zip(&ends)
        .enumerate()
        .filter_map(|(index, (start, end))| {
            let name = format!("{}, segment {} of {}", record.source().display(), index + 1, ends.len());
            record.part(start..*end).ok().map(|part| part.named(name))
        })
        .collect();
    if parts.is_empty() { vec![record] } else { parts }
}

/// What a gain must be for what is done with the records.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ExpectedGain {
    /// Anything, as for a frequency response.
    Any,
    /// Positive, as for a fit of k > 0.
    Positive,
    /// That of a model: of its sign, and in its units.
    Like(f64),
}

impl ExpectedGain {
    /// Whether a finding on the gain makes a record unusable.
    fn excludes(self, finding: &Finding, gain: f64) -> bool {
        match (self, finding.kind) {
            (Self::Positive, "sign") => gain < 0.0,
            (Self::Like(model), "sign") => gain / model < 0.0,
            (Self::Like(model), "unit") => (gain / model).abs().ln().abs() > SAME_GAIN,
            _ => false,
        }
    }
}

/// Inspects records and refuses those that nothing can be estimated from; returns the warnings.
///
/// # Errors
/// The first refusal, with its record, cause and remedy.
pub fn admit(records: &[&Record], expected: ExpectedGain) -> Result<Vec<String>> {
    let mut inspections: Vec<Inspection> = records.iter().map(|record| inspect(record)).collect();
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
    Ok(inspections.iter().flat_map(Inspection::warnings).collect())
}

fn refused(record: &Record, finding: &Finding) -> Error {
    let line = finding.sample.map(|sample| sample + 2); // behind the header
    Error::new("record", finding.sentence.clone(), "a command and the response to it, in one unit and with one clock")
        .remedy(&finding.remedy)
        .at(record.source(), line)
}
