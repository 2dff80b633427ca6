//! Buffers that steps reuse. No result depends on their content.

use super::{constants::Actuator, corners::CornerResponse, linear_maps::LinearMaps, segment::SegmentSolution};
use crate::{
    command::{Change, EffectInputs},
    transition::Transition,
};

/// A cache of transitions and buffers.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    /// Transitions of the most recent step sizes, the latest first: masters repeat one, or a few that differ in the last bits.
    cache: [Transition; CACHE_SIZE],
    pub(super) maps: LinearMaps,
    corners: CornerResponse,
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
    /// The transition of this duration, cached if possible.
    #[inline]
    pub(super) fn transition(&mut self, actuator: &Actuator, duration: f64) -> &Transition {
        if self.cache[0].duration() != duration {
            self.bring_to_front(actuator, duration);
        }
        &self.cache[0]
    }

    /// Replaces the least recently used one.
    #[inline(never)]
    fn bring_to_front(&mut self, actuator: &Actuator, duration: f64) {
        let known = self.cache.iter().position(|transition| transition.duration() == duration);
        let place = known.unwrap_or(CACHE_SIZE - 1);
        if known.is_none() {
            self.cache[place] = Transition::new(actuator.base, actuator.order, duration);
        }
        self.cache[..=place].rotate_right(1);
    }

    /// The response to corners in steps of this duration.
    pub(super) fn corners(&mut self, actuator: &Actuator, duration: f64) -> &CornerResponse {
        if self.corners.duration() != duration {
            self.corners = CornerResponse::new(actuator, duration);
        }
        &self.corners
    }

    /// Discards the cached transitions; to be called when the parameters change.
    pub fn clear(&mut self) {
        self.cache = Default::default();
        self.maps.clear();
        self.corners = CornerResponse::default();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        effects::Effects,
        parameters::{Order, table},
    };

    #[test]
    fn a_transition_from_the_cache_is_that_of_its_duration() {
        let base = table()[0].base;
        let actuator = Actuator::new(base, Order::Third, &Effects::default());
        let mut workspace = Workspace::default();
        for duration in [1, 2, 1, 3, 4, 5, 2, 1, 1, 5, 6, 3].map(|ms| 1e-3 * f64::from(ms)) {
            let expected = Transition::new(base, Order::Third, duration);
            assert_eq!(*workspace.transition(&actuator, duration), expected);
        }
    }
}
