//! Progress of a search.
//!
//! The work of a search is simulation: it is counted in samples, where they are simulated, by all threads. The remaining work is predicted
//! stage by stage, and updated at the start of each stage. With s the completed fraction, work dw contributes
//!
//! ```text
//! ds = (1 - s) dw / (remaining work)
//! ```
//!
//! so that it never decreases, equals done over total where predictions hold, and otherwise follows the pace of the remaining work.

use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU64, Ordering},
};

/// Completed part of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Done {
    /// Fraction of the work, with the predicted remainder.
    pub share: f64,
    /// Number of simulated samples.
    pub samples: u64,
}

/// Callback with the progress, from any thread and never decreasing. It should be fast: searches wait for it.
pub type Report<'a> = &'a (dyn Fn(Done) + Sync);

/// Minimum change of the fraction that is reported.
const REPORTED_SHARE: f64 = 1e-3;

/// Remaining fraction assumed for a stage that takes longer than predicted: some take five times as long.
const LEAST_LEFT: f64 = 0.5;

/// A stage of a search: its predicted number of samples, and its probability.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stage {
    pub samples: f64,
    pub chance: f64,
}

/// The work of one search.
pub(crate) struct Work<'a> {
    report: Option<Report<'a>>,
    stages: Vec<Stage>,
    /// Number of simulated samples.
    done: AtomicU64,
    /// Number of least-squares searches started.
    searches: AtomicU64,
    ledger: Mutex<Ledger>,
}

/// State of the completed fraction.
struct Ledger {
    share: f64,
    reported: f64,
    /// The part of `done` included in the fraction.
    counted: u64,
    /// Minimum number of samples remaining in the present stage, and in later ones.
    present: f64,
    least: f64,
    behind: f64,
}

impl<'a> Work<'a> {
    /// With these stages.
    pub(crate) fn new(stages: Vec<Stage>, report: Option<Report<'a>>) -> Self {
        let ledger = Ledger { share: 0.0, reported: 0.0, counted: 0, present: 0.0, least: 0.0, behind: 0.0 };
        let [done, searches] = [0, 0].map(AtomicU64::new);
        let work = Self { report, stages, done, searches, ledger: Mutex::new(ledger) };
        work.begin(0);
        work
    }

    /// Starts a stage; the previous ones are finished.
    pub(crate) fn begin(&self, stage: usize) {
        let mut ledger = self.ledger.lock().unwrap_or_else(PoisonError::into_inner);
        ledger.counted = self.done.load(Ordering::Relaxed);
        let mut left = self.stages[stage..].iter();
        ledger.present = left.next().map_or(0.0, |stage| stage.samples);
        ledger.least = LEAST_LEFT * ledger.present;
        ledger.behind = left.map(|stage| stage.chance * stage.samples).sum();
    }

    /// Counts this many simulated samples. If another thread is counting, they are added with the next ones.
    pub(crate) fn add(&self, samples: usize) {
        let Some(report) = self.report else { return };
        let done = self.done.fetch_add(samples as u64, Ordering::Relaxed) + samples as u64;
        let Ok(mut ledger) = self.ledger.try_lock() else { return };
        let done = done.max(ledger.counted);
        ledger.count(done);
        if ledger.share >= ledger.reported + REPORTED_SHARE {
            ledger.reported = ledger.share;
            report(Done { share: ledger.share, samples: done });
        }
    }

    /// Counts the start of a least-squares search.
    pub(crate) fn begin_search(&self) {
        self.searches.fetch_add(1, Ordering::Relaxed);
    }

    /// Number of least-squares searches so far.
    pub(crate) fn searches(&self) -> u64 {
        self.searches.load(Ordering::Relaxed)
    }

    /// Reports completion.
    pub(crate) fn end(&self) {
        let Some(report) = self.report else { return };
        let mut ledger = self.ledger.lock().unwrap_or_else(PoisonError::into_inner);
        (ledger.share, ledger.reported) = (1.0, 1.0);
        report(Done { share: 1.0, samples: self.done.load(Ordering::Relaxed) });
    }
}

impl Ledger {
    #[allow(clippy::cast_precision_loss)] // counts
    fn count(&mut self, done: u64) {
        let new = (done - self.counted) as f64;
        self.counted = done;
        let left = self.present.max(self.least) + self.behind;
        if left > 0.0 {
            // The limit of many small steps: never complete.
            self.share += (1.0 - self.share) * (new / left).min(0.5);
        }
        self.present = (self.present - new).max(self.least);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_stages() -> Vec<Stage> {
        [10_000.0, 90_000.0].map(|samples| Stage { samples, chance: 1.0 }).to_vec()
    }

    /// Reports for some amounts of work, each in its stage.
    fn heard(work: &[(usize, usize)]) -> Vec<Done> {
        let heard = Mutex::new(Vec::new());
        let report = |done: Done| heard.lock().unwrap().push(done);
        let counter = Work::new(two_stages(), Some(&report));
        let mut present = 0;
        for (stage, samples) in work {
            if *stage != present {
                present = *stage;
                counter.begin(present);
            }
            counter.add(*samples);
        }
        counter.end();
        heard.into_inner().unwrap()
    }

    fn shares(work: &[(usize, usize)]) -> Vec<f64> {
        heard(work).iter().map(|done| done.share).collect()
    }

    #[test]
    fn work_as_expected_is_shared_out_evenly() {
        let work: Vec<(usize, usize)> = (0..1000).map(|n| (usize::from(n >= 100), 100)).collect();
        let heard = heard(&work);
        assert!(heard.windows(2).all(|pair| pair[0].share < pair[1].share && pair[0].samples <= pair[1].samples));
        assert_eq!(heard.last(), Some(&Done { share: 1.0, samples: 100_000 }));
        // As planned up to the middle; then more work may follow.
        for done in &heard[..heard.len() / 2] {
            assert!((done.share - 1e-5 * done.samples as f64).abs() < 0.01, "{done:?}");
        }
    }

    #[test]
    fn a_stage_that_takes_longer_never_comes_to_its_end() {
        let heard = shares(&(0..5000).map(|n| (usize::from(n >= 100), 100)).collect::<Vec<_>>());
        assert!(heard.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(heard[heard.len() - 2] < 1.0 && heard.last() == Some(&1.0));
    }

    #[test]
    fn a_stage_that_is_over_sooner_costs_no_share() {
        let heard = shares(&[(0, 1000), (1, 30_000), (1, 30_000)]);
        assert!((heard[0] - 0.01).abs() < 1e-12, "{heard:?}");
        assert!((heard[1] - 0.34).abs() < 1e-12, "{heard:?}");
        assert_eq!(heard.len(), 4);
    }

    #[test]
    fn threads_count_together_and_nothing_is_lost() {
        let heard = Mutex::new(Vec::new());
        let report = |done: Done| heard.lock().unwrap().push(done.share);
        let counter = Work::new(two_stages(), Some(&report));
        counter.begin(1);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..1000).for_each(|_| counter.add(10)));
            }
        });
        counter.add(5000);
        let last = *heard.lock().unwrap().last().unwrap();
        assert!((last - 0.5).abs() < 0.02, "{last}");
        assert!(heard.lock().unwrap().windows(2).all(|pair| pair[0] < pair[1]));
    }
}
