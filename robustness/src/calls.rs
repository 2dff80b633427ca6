//! Sequences of calls: lives of a few instances, led forward by sound calls and disturbed by all others.
//!
//! What is checked after every call: the status is one of the standard's and not `fmi2Fatal`; numbers that a sound call has put out are
//! finite; a refusal has a message; a refused call has changed nothing (told by the serialized state, for a share of the calls).

mod arguments;
mod life;
mod random;
mod sound;
mod states;

use std::{collections::BTreeMap, ops::Range, time::Duration};

pub use life::CALLS_OF_A_LIFE;

use crate::{host::Host, watchdog};

/// What came of many calls.
#[derive(Debug, Default, Clone)]
pub struct Tally {
    /// Calls by status, `fmi2OK` first.
    pub statuses: [u64; 5],
    /// Calls of each function, and those that succeeded.
    pub functions: BTreeMap<&'static str, [u64; 2]>,
    /// Refused calls after which the state was compared with the one before.
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

    /// Two runs together.
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

/// The life with this number, drawn from it and the seed.
#[must_use]
pub fn life(host: &Host, seed: u64, number: u64) -> Tally {
    watchdog::begin(number);
    life::live(host, fastrand::Rng::with_seed(seed.wrapping_mul(1 << 32).wrapping_add(number)))
}

/// Lives with these numbers.
#[must_use]
pub fn lives(host: &Host, seed: u64, numbers: Range<u64>) -> Tally {
    numbers.fold(Tally::default(), |tally, number| tally.and(life(host, seed, number)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functions::Functions;

    #[test]
    fn no_sequence_of_calls_breaks_an_instance() {
        const LIVES: u64 = if cfg!(miri) { 2 } else { 100 };
        let tally = lives(&Host::new(Functions::linked()), 208_452, 0..LIVES);
        let [ok, _, _, refused, fatal] = tally.statuses;
        assert!(fatal == 0 && ok > tally.calls() / 5 && refused > tally.calls() / 20, "{tally:?}");
        // Else it would test nothing: every function is called, and nearly every one succeeds at times.
        let never = ["fmi2CancelStep", "fmi2GetIntegerStatus"];
        for (name, [calls, successes]) in &tally.functions {
            assert!(*calls > 0 && (*successes > 0 || never.contains(name) || cfg!(miri)), "{name} {tally:?}");
        }
        assert!(tally.functions.len() == 43 || cfg!(miri), "{}", tally.functions.len());
        assert!(tally.compared > 0);
    }
}
