//! Estimate of the remaining time of work.
//!
//! Work in parts: the remaining parts of the present stage take as long as those done; later stages take a multiple of that. Work that
//! reports its completed fraction continues at the pace of the latter half of its time. For work that reports nothing until it ends,
//! durations are taken as log-logistic about a usual one, S(t) = 1 / (1 + (t / m)^β), so that after t seconds half of all such work ends
//! within
//!
//! ```text
//! m (1 + 2 (t / m)^β)^(1/β) - t
//! ```
//!
//! more seconds: m at the beginning, less and less up to there, and a fraction of t beyond. It never reaches zero before the work ends.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

/// Prior information on the work.
#[derive(Debug, Clone)]
pub enum Expectation {
    /// Stages of parts, one after another.
    Stages(Vec<Stage>),
    /// A number of bytes; those read are counted elsewhere.
    Bytes(u64, Arc<AtomicU64>),
    /// Completed fractions, each with the time of its report in seconds, and the time limit in seconds.
    Shares(Vec<[f64; 2]>, f64),
    /// Median duration of such work in seconds.
    Usual(f64),
}

/// Parts of about equal duration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    parts: u64,
    /// Duration of one part relative to those of the other stages.
    weight: f64,
    done: u64,
    /// Times in seconds of the start of the stage and of the end of its last part.
    began_s: f64,
    heard_s: f64,
}

impl Stage {
    /// This many parts, each of which takes `weight` times as long as a part of weight 1.
    #[must_use]
    pub fn new(parts: u64, weight: f64) -> Self {
        Self { parts, weight, done: 0, began_s: 0.0, heard_s: 0.0 }
    }

    fn is_over(&self) -> bool {
        self.done >= self.parts
    }

    /// Duration of one part [s].
    fn cost_s(&self) -> Option<f64> {
        #[allow(clippy::cast_precision_loss)] // a count
        (self.done > 0).then(|| (self.heard_s - self.began_s) / self.done as f64)
    }
}

/// β: half of all work ends between 0.6 and 1.7 times the usual duration.
const SHAPE: f64 = 2.0;

/// Remaining fraction assumed for a part that takes longer than the previous ones.
const LEAST_SHARE: f64 = 0.2;

impl Expectation {
    /// For work that reports its completed fraction, and ends at a time limit.
    #[must_use]
    pub fn shares(limit: Option<Duration>) -> Self {
        Self::Shares(Vec::new(), limit.map_or(f64::INFINITY, |limit| limit.as_secs_f64()))
    }

    /// This fraction of the work was completed after this many seconds.
    pub fn hear(&mut self, share: f64, now_s: f64) {
        if let Self::Shares(heard, _) = self {
            heard.push([now_s, share]);
        }
    }

    /// This many parts of the work were completed after this many seconds.
    pub fn advance(&mut self, mut done: u64, now_s: f64) {
        let Self::Stages(stages) = self else { return };
        let mut began_s = 0.0;
        for stage in stages {
            let own = done.min(stage.parts);
            if own > stage.done {
                if stage.done == 0 {
                    stage.began_s = began_s;
                }
                (stage.done, stage.heard_s) = (own, now_s);
            }
            done -= own;
            began_s = stage.heard_s;
        }
    }

    /// Remaining seconds at this time; `None` if unknown.
    #[must_use]
    pub fn left_s(&self, now_s: f64) -> Option<f64> {
        match self {
            Self::Usual(median_s) if *median_s > 0.0 => {
                Some(median_s * (1.0 + 2.0 * (now_s / median_s).powf(SHAPE)).powf(1.0 / SHAPE) - now_s)
            }
            Self::Usual(_) => None,
            Self::Bytes(all, read) => {
                let read = read.load(Ordering::Relaxed);
                #[allow(clippy::cast_precision_loss)] // counts of bytes
                (read > 0).then(|| now_s * all.saturating_sub(read) as f64 / read as f64)
            }
            Self::Stages(stages) => left_s(stages, now_s),
            Self::Shares(heard, longest_s) => {
                let left_s = left_by_share(heard, now_s)?;
                Some(left_s.min((longest_s - now_s).max(0.0)))
            }
        }
    }
}

#[allow(clippy::cast_precision_loss)] // counts
fn left_s(stages: &[Stage], now_s: f64) -> Option<f64> {
    let heard = stages.iter().rev().find_map(|stage| Some((stage.cost_s()?, stage.weight)));
    let (cost_s, weight) = heard?;
    let since_s = now_s - stages.iter().map(|stage| stage.heard_s).fold(0.0, f64::max);
    let mut is_present = true;
    let mut sum = 0.0;
    for stage in stages.iter().filter(|stage| !stage.is_over()) {
        let each = stage.cost_s().unwrap_or(cost_s * stage.weight / weight);
        let left = each * (stage.parts - stage.done) as f64;
        sum += if is_present { (left - since_s).max(LEAST_SHARE * each) } else { left };
        is_present = false;
    }
    Some(sum)
}

/// At the pace of the latter half of the time, including the present silence; `None` before anything is done.
fn left_by_share(heard: &[[f64; 2]], now_s: f64) -> Option<f64> {
    let [_, share] = *heard.last()?;
    let later = heard.partition_point(|[at_s, _]| *at_s < 0.5 * now_s).min(heard.len() - 1);
    let [from_s, from] = if later == 0 { [0.0, 0.0] } else { heard[later - 1] };
    (share > from).then(|| (1.0 - share) * (now_s - from_s) / (share - from))
}

/// The displayed remaining time: it runs down with the clock and drifts towards new estimates instead of jumping to them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shown {
    left_s: Option<f64>,
    at_s: f64,
}

/// Time constant of the drift to a new estimate [s].
const DRIFT_S: f64 = 3.0;

impl Shown {
    /// The remaining time to display after this many seconds.
    pub fn update(&mut self, now_s: f64, estimate_s: Option<f64>) -> Option<f64> {
        let passed_s = now_s - self.at_s;
        let ran_down = self.left_s.map(|left| (left - passed_s).max(0.0));
        self.left_s = match (ran_down, estimate_s) {
            (Some(old), Some(new)) => Some(old + (new - old) * (1.0 - (-passed_s / DRIFT_S).exp())),
            (old, new) => new.or(old),
        };
        self.at_s = now_s;
        self.left_s
    }
}

/// A duration in words, no finer than it is known.
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // seconds
pub fn spoken(seconds: f64) -> String {
    let rounded = |to: f64| (seconds / to).ceil() * to;
    match seconds {
        ..1.0 => "a moment".to_owned(),
        ..20.0 => format!("{:.0} s", rounded(1.0)),
        ..60.0 => format!("{:.0} s", rounded(5.0)),
        ..600.0 => {
            let whole = rounded(10.0) as u64;
            format!("{} min {:02} s", whole / 60, whole % 60)
        }
        ..7200.0 => format!("{:.0} min", rounded(60.0) / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_that_take_alike_end_when_they_are_said_to() {
        let mut work = Expectation::Stages(vec![Stage::new(10, 1.0), Stage::new(4, 15.0)]);
        assert_eq!(work.left_s(0.1), None);
        work.advance(5, 1.0);
        assert_eq!(work.left_s(1.0), Some(1.0 + 60.0 * 0.2));
        work.advance(10, 2.0);
        assert_eq!(work.left_s(2.0), Some(12.0));
        // The second stage takes half of the expected time.
        work.advance(12, 5.0);
        assert_eq!(work.left_s(5.0), Some(3.0));
        assert_eq!(work.left_s(5.5), Some(2.5));
        // A part that takes longer than others is not finished yet.
        assert!((work.left_s(50.0).unwrap() - 0.3).abs() < 1e-12);
        work.advance(14, 51.0);
        assert_eq!(work.left_s(51.0), Some(0.0));
    }

    #[test]
    fn what_says_nothing_has_always_some_time_left_and_less_of_it_up_to_the_usual() {
        let work = Expectation::Usual(10.0);
        let left = |now: f64| work.left_s(now).unwrap();
        assert_eq!(left(0.0), 10.0);
        assert!((0..70).all(|t| left(0.1 * f64::from(t)) > left(0.1 * f64::from(t + 1))));
        assert!((0..1000).all(|t| left(f64::from(t)) > 0.4 * f64::from(t)));
        assert_eq!(Expectation::Usual(0.0).left_s(1.0), None);
    }

    #[test]
    fn shares_go_on_at_their_latest_pace_and_not_beyond_a_limit() {
        let mut work = Expectation::shares(None);
        assert_eq!(work.left_s(1.0), None);
        // Half of the work in ten seconds, and then at a quarter of that pace.
        (1..=10).for_each(|second| work.hear(0.05 * f64::from(second), f64::from(second)));
        assert!((work.left_s(10.0).unwrap() - 10.0).abs() < 1e-9);
        assert!(work.left_s(12.0).unwrap() > 10.0, "silence is no progress");
        (11..=30).for_each(|second| work.hear(0.5 + 0.0125 * f64::from(second - 10), f64::from(second)));
        assert!((work.left_s(30.0).unwrap() - 20.0).abs() < 1e-9);
        work.hear(1.0, 31.0);
        assert_eq!(work.left_s(31.0), Some(0.0));
        let mut cut = Expectation::shares(Some(Duration::from_secs(5)));
        cut.hear(0.01, 1.0);
        assert_eq!(cut.left_s(2.0), Some(3.0));
    }

    #[test]
    fn bytes_are_read_at_the_rate_of_those_before_them() {
        let read = Arc::new(AtomicU64::new(0));
        let work = Expectation::Bytes(1000, Arc::clone(&read));
        assert_eq!(work.left_s(1.0), None);
        read.store(250, Ordering::Relaxed);
        assert_eq!(work.left_s(2.0), Some(6.0));
    }

    #[test]
    fn what_is_shown_runs_down_and_does_not_jump() {
        let mut shown = Shown::default();
        assert_eq!(shown.update(1.0, None), None);
        assert_eq!(shown.update(1.1, Some(20.0)), Some(20.0));
        assert_eq!(shown.update(3.1, Some(18.0)), Some(18.0));
        let mut before = 18.0;
        for step in 1..100 {
            let now = shown.update(3.1 + 0.1 * f64::from(step), Some(60.0)).unwrap();
            assert!((now - before).abs() < 2.0 && now < 60.0, "{before} {now}");
            before = now;
        }
        assert!(before > 55.0);
    }

    #[test]
    fn times_are_no_finer_than_they_are_known() {
        let words = [0.4, 7.3, 33.0, 61.0, 125.0, 1900.0, 9000.0].map(spoken);
        assert_eq!(words, ["a moment", "8 s", "35 s", "1 min 10 s", "2 min 10 s", "32 min", "2.5 h"]);
    }
}
