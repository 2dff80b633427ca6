//! Buffers that steps reuse. No result depends on their content.

use super::{constants::Actuator, segment::SegmentSolution};
use crate::{
    command::{Change, EffectInputs},
    transition::Transition,
};

/// A cache of transitions and buffers.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    /// Transitions of the most recent step sizes: masters repeat one, or a few that differ in the last bits.
    cache: [Option<Transition>; CACHE_SIZE],
    latest: usize,
    pub(super) inputs: EffectInputs,
    pub(super) solution: SegmentSolution,
    /// What the last step has changed in the history of the command.
    pub(super) change: Change,
    /// Limits were ignored over a segment, since events made no progress.
    pub(super) has_stalled: bool,
}

/// Number of cached transitions.
const CACHE_SIZE: usize = 4;

impl Workspace {
    /// The transition of this duration, from the cache where it is there.
    #[inline]
    pub(super) fn transition(&mut self, actuator: &Actuator, duration: f64) -> &Transition {
        let is_known = |entry: &Option<Transition>| entry.as_ref().is_some_and(|known| known.duration() == duration);
        if !is_known(&self.cache[self.latest]) {
            let known = self.cache.iter().position(is_known);
            self.latest = known.unwrap_or((self.latest + 1) % CACHE_SIZE);
            if known.is_none() {
                self.cache[self.latest] = None;
            }
        }
        self.cache[self.latest].get_or_insert_with(|| Transition::new(actuator.base, actuator.order, duration))
    }

    /// Discards the cached transitions; to be called when the parameters change.
    pub fn clear(&mut self) {
        self.cache = Default::default();
    }

    /// What the last step has changed in the history of the command.
    #[must_use]
    pub fn change(&self) -> Change {
        self.change
    }

    /// True where the last step ignored limits over a segment, since events made no progress in time.
    #[must_use]
    pub fn has_stalled(&self) -> bool {
        self.has_stalled
    }
}
