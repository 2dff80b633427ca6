//! Sampling of a record: rate, jitter, gaps, and whether its time can be in seconds.

use serde::Serialize;

use super::finding::Finding;
use crate::digits::significant;

/// Sampling of a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Clock {
    /// Median rate [1/s].
    pub rate_hz: f64,
    /// Median interval [s].
    pub interval_s: f64,
    /// Root mean square of the intervals' deviations from their median, without gaps and dropped rows, relative to it [1].
    pub jitter: f64,
    /// Samples before gaps.
    pub gaps: Vec<usize>,
    /// Number of samples missing in gaps.
    pub missing_samples: usize,
    /// Number of single samples missing elsewhere.
    pub dropped_samples: usize,
}

/// An interval of more than this many medians is a gap, with five or more missing samples; fewer are dropped rows, whose command is
/// interpolated.
pub const GAP_INTERVALS: f64 = 5.5;

/// Minimum interval in medians for dropped rows; a late sample is not a dropped one.
const DROPPED_INTERVALS: f64 = 1.75;

/// Deviations below this fraction of an interval are digits of the file, not jitter: 0.04 deg of phase at 12 Hz and 200 samples/s.
const DIGITS_SHARE: f64 = 2e-3;

/// The slowest plausible sampling of an actuator record [s]: two samples a second resolve 1 Hz at best, below the excitation of the
/// report's actuators, and of all others known to us. Slower ones are in another unit of time.
const SLOWEST_S: f64 = 0.5;

/// Sampling of increasing times.
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // counts of samples
pub fn clock(time: &[f64]) -> Clock {
    let intervals: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut ordered = intervals.clone();
    let middle = ordered.len() / 2;
    let median = *ordered.select_nth_unstable_by(middle, f64::total_cmp).1;
    let is_gap = |interval: f64| interval > GAP_INTERVALS * median;
    let gaps: Vec<usize> = (0..intervals.len()).filter(|index| is_gap(intervals[*index])).collect();
    let absent = |interval: f64| (interval / median).round() as usize - 1;
    let missing = gaps.iter().map(|gap| absent(intervals[*gap])).sum();
    let is_dropped = |interval: f64| interval > DROPPED_INTERVALS * median && !is_gap(interval);
    let dropped = intervals.iter().filter(|interval| is_dropped(**interval)).map(|interval| absent(*interval)).sum();
    let regular = intervals.iter().filter(|interval| **interval <= DROPPED_INTERVALS * median);
    let square: f64 = regular.clone().map(|interval| (interval / median - 1.0).powi(2)).sum();
    let jitter = (square / regular.count().max(1) as f64).sqrt();
    Clock {
        rate_hz: 1.0 / median,
        interval_s: median,
        jitter,
        gaps,
        missing_samples: missing,
        dropped_samples: dropped,
    }
}

/// Findings on it; a stated unit of time is accepted.
#[must_use]
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn findings(clock: &Clock, time: &[f64], unit_declared: bool) -> Vec<Finding> {
    let mut findings = vec![Finding::note(
        "sampling",
        format!(
            "{} samples at {} samples/s over {} s",
            time.len(),
            significant(clock.rate_hz, 6),
            significant(time[time.len() - 1] - time[0], 6)
        ),
    )];
    if clock.interval_s > SLOWEST_S && !unit_declared {
        let likely = if clock.interval_s > 1e3 * SLOWEST_S { ("microseconds", "us") } else { ("milliseconds", "ms") };
        findings.push(Finding::refusal(
            "time_unit",
            format!(
                "the time column steps by {} where seconds are expected, like times in {}: {:.3} samples/s",
                clock.interval_s, likely.0, clock.rate_hz
            ),
            format!("give --time-unit {}, or --time-unit s if it is in seconds", likely.1),
        ));
    }
    if let Some(first) = clock.gaps.first() {
        findings.push(
            Finding::warning(
                "gaps",
                format!(
                    "{} in which about {} samples are missing",
                    if clock.gaps.len() == 1 { "a gap".to_owned() } else { format!("{} gaps", clock.gaps.len()) },
                    clock.missing_samples
                ),
                "the record is split into segments, each with its own start state",
            )
            .at(*first, time),
        );
    }
    if clock.dropped_samples > 0 {
        let share = 100.0 * clock.dropped_samples as f64 / time.len() as f64;
        findings.push(Finding::note(
            "dropped_rows",
            format!(
                "{} rows are missing singly or in twos and threes, {share:.1} %; on an even clock their command is interpolated and their \
                 position is not used",
                clock.dropped_samples
            ),
        ));
    }
    if clock.jitter > DIGITS_SHARE {
        findings.push(Finding::note(
            "jitter",
            format!("intervals scatter by {:.2} % rms; times are used as recorded", 100.0 * clock.jitter),
        ));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_and_jitter_are_counted() {
        let mut time: Vec<f64> = (0..1000).map(|n| 0.005 * f64::from(n)).collect();
        time.drain(400..410);
        time.drain(100..106);
        time.remove(50);
        let clock = clock(&time);
        assert_eq!((clock.gaps.as_slice(), clock.missing_samples), ([98, 392].as_slice(), 16));
        assert_eq!(clock.dropped_samples, 1);
        assert!((clock.rate_hz - 200.0).abs() < 1e-6 && clock.jitter < 1e-9);
        assert!(
            findings(&clock, &time, false).iter().any(|finding| finding.kind == "gaps" && finding.sample == Some(98))
        );
    }

    #[test]
    fn milliseconds_are_told_from_seconds() {
        let time: Vec<f64> = (0..200).map(|n| 5.0 * f64::from(n)).collect();
        let found = findings(&clock(&time), &time, false);
        assert!(found.iter().any(|finding| finding.kind == "time_unit" && finding.remedy.contains("ms")), "{found:?}");
        assert!(findings(&clock(&time), &time, true).iter().all(|finding| finding.kind != "time_unit"));
    }
}
