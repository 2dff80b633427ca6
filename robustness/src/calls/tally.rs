//! Outcomes of calls.

use std::{collections::BTreeMap, time::Duration};

/// Outcomes of many calls.
#[derive(Debug, Default, Clone)]
pub struct Tally {
    /// Calls by status, `fmi2OK` first.
    pub statuses: [u64; 5],
    /// Calls of each function, and those that succeeded.
    pub functions: BTreeMap<&'static str, [u64; 2]>,
    /// Refused calls after which the state was compared with that before.
    pub compared: u64,
    /// The slowest call, with its function.
    pub slowest: (Duration, &'static str),
}

impl Tally {
    /// Number of calls.
    #[must_use]
    pub fn calls(&self) -> u64 {
        self.statuses.iter().sum()
    }

    /// The sum of two runs.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.statuses.iter_mut().zip(other.statuses).for_each(|(here, there)| *here += there);
        for (name, counts) in other.functions {
            let here = self.functions.entry(name).or_default();
            here.iter_mut().zip(counts).for_each(|(here, there)| *here += there);
        }
        self.compared += other.compared;
        self.slowest = self.slowest.max(other.slowest);
        self
    }
}
