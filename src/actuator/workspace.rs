//! Buffers that steps reuse. No result depends on their content.

use super::{constants::Actuator, segment::SegmentSolution};
use crate::{operator::Piece, transition::Transition};

/// A cache of transitions and buffers.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    /// Transitions of the most recent step sizes: masters repeat one, or a few that differ in the last bits.
    cache: Vec<Transition>,
    oldest: usize,
    pub(super) pieces: Vec<Piece>,
    pub(super) solution: SegmentSolution,
}

impl Workspace {
    /// Number of cached transitions.
    const CACHE_SIZE: usize = 4;

    /// The transition of this duration, from the cache where it is there.
    pub(super) fn transition(&mut self, actuator: &Actuator, duration: f64) -> &Transition {
        let known = self.cache.iter().position(|transition| transition.duration() == duration);
        let index = known.unwrap_or_else(|| {
            let made = Transition::new(actuator.base, actuator.order, duration);
            if self.cache.len() < Self::CACHE_SIZE {
                self.cache.push(made);
                return self.cache.len() - 1;
            }
            let index = self.oldest;
            self.oldest = (index + 1) % Self::CACHE_SIZE;
            self.cache[index] = made;
            index
        });
        &self.cache[index]
    }

    /// Discards the cached transitions; to be called when the parameters change.
    pub fn clear(&mut self) {
        self.cache.clear();
        self.oldest = 0;
    }
}
