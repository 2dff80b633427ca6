//! Sequences of calls: lives of a few instances, advanced by valid calls and disturbed by all others.
//!
//! Checks after every call: the status is one of the standard's and not `fmi2Fatal`; numbers returned by a valid call are finite; a refusal
//! has a message; a refused call has changed nothing (compared by the serialized state, for a fraction of the calls).

mod arguments;
mod life;
mod random;
mod sound;
mod states;
mod tally;

use std::ops::Range;

use fastrand::Rng;

pub use tally::Tally;

use crate::{
    host::{Host, take_messages},
    watchdog,
};
use arguments::one_in;
use life::Life;

/// Random calls of one life; valid ones are added.
const CALLS_OF_A_LIFE: usize = 400;

/// The life with this number, drawn from it and the seed.
#[must_use]
pub fn life(host: &Host, seed: u64, number: u64) -> Tally {
    watchdog::begin(number);
    let mut life = Life::new(host, Rng::with_seed(seed.wrapping_mul(1 << 32).wrapping_add(number)));
    for _ in 0..CALLS_OF_A_LIFE {
        match life.rng.u8(..16) {
            _ if life.instances.is_empty() => life.instantiate(),
            0 if one_in(&mut life.rng, 4) => life.instantiate(),
            0 if one_in(&mut life.rng, 8) => life.free_one(),
            1..8 => sound::forward(&mut life),
            _ => random::call(&mut life),
        }
    }
    for known in std::mem::take(&mut life.instances) {
        life.free(known.component);
    }
    take_messages();
    life.tally
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
        const LIVES: u64 = if cfg!(miri) { 2 } else { 40 };
        let _alone = crate::alone();
        let tally = lives(&Host::new(Functions::linked()), 208_452, 0..LIVES);
        let [ok, _, _, refused, fatal] = tally.statuses;
        assert!(fatal == 0 && ok > tally.calls() / 5 && refused > tally.calls() / 20, "{tally:?}");
        // Otherwise nothing would be tested: every function is called, and nearly every one succeeds at times.
        let never = ["fmi2CancelStep"]; // no step is ever pending
        for (name, [calls, successes]) in &tally.functions {
            assert!(*calls > 0 && (*successes > 0 || never.contains(name) || cfg!(miri)), "{name} {tally:?}");
        }
        assert!(tally.functions.len() == 44 || cfg!(miri), "{}", tally.functions.len());
        assert!(tally.compared > 0);
    }
}
