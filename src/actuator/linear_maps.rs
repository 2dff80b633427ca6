//! The maps of an actuator: one for each length of a piece that comes again, and each mode.

use super::{
    linear_map::LinearMap,
    linear_system::{Kind, LinearSystem},
};

/// Lengths of pieces are the same within this share, above what they differ by in the last bits.
const SAME_LENGTH: f64 = 1e-9;

/// Most maps of an actuator: steps and parts of them, each in some modes.
pub(super) const MOST_MAPS: usize = 48;

/// Lengths without a map that are remembered: a map is made when one comes again.
const REMEMBERED_LENGTHS: usize = 4;

/// After this number of pieces, no map over a whole one is tried where less than half of their lengths had been seen, as under an uneven clock.
const FIRST_PIECES: u32 = 16;

/// The maps of an actuator.
#[derive(Debug, Clone, Default)]
pub(super) struct LinearMaps {
    pub(super) maps: Vec<LinearMap>,
    /// Lengths that were asked for, and those that had been seen.
    asked: u32,
    seen: u32,
    /// The latest lengths without a map, and where the next one is written.
    missed: [f64; REMEMBERED_LENGTHS],
    next: usize,
}

impl LinearMaps {
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// False where lengths do not come again, after so many that this is no chance.
    pub(super) fn are_worth_it(&self) -> bool {
        self.asked < FIRST_PIECES || self.come_again()
    }

    /// Whether most lengths do.
    pub(super) fn come_again(&self) -> bool {
        self.asked <= 2 * self.seen
    }

    /// True for the length of a map, if most lengths come again.
    pub(super) fn have(&self, length: f64) -> bool {
        self.come_again() && self.maps.iter().any(|map| is_same(map.length, length))
    }

    /// True for the length of a map, or of a piece not long ago; else it is remembered.
    pub(super) fn have_seen(&mut self, length: f64) -> bool {
        self.asked = self.asked.saturating_add(1);
        if self.maps.iter().any(|map| is_same(map.length, length))
            || self.missed.iter().any(|missed| is_same(*missed, length))
        {
            self.seen = self.seen.saturating_add(1);
            return true;
        }
        self.missed[self.next] = length;
        self.next = (self.next + 1) % REMEMBERED_LENGTHS;
        false
    }

    /// The map of this kind over exactly this length, where there is one.
    #[inline]
    pub(super) fn known(&self, kind: &Kind, length: f64) -> Option<&LinearMap> {
        self.maps.iter().find(|map| map.length == length && map.kind == *kind)
    }

    /// A length was asked for that has a map.
    #[inline]
    pub(super) fn has_found(&mut self) {
        (self.asked, self.seen) = (self.asked.saturating_add(1), self.seen.saturating_add(1));
    }

    /// The map of a system over this length; none where there are too many.
    pub(super) fn get(&mut self, system: &LinearSystem<'_>, length: f64) -> Option<&LinearMap> {
        let is_wanted = |map: &LinearMap| is_same(map.length, length) && map.kind == system.kind;
        if let Some(index) = self.maps.iter().position(is_wanted) {
            return Some(&self.maps[index]);
        }
        if self.maps.len() == MOST_MAPS {
            return None;
        }
        self.maps.push(LinearMap::new(system, length));
        self.maps.last()
    }
}

/// Two lengths of pieces are the same.
fn is_same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME_LENGTH * other
}
