//! The maps of an actuator: one for each recurring piece length and each mode.

use super::{
    linear_map::LinearMap,
    linear_system::{Kind, LinearSystem},
};

/// Relative tolerance for equal piece lengths, above their rounding differences.
const SAME_LENGTH: f64 = 1e-9;

/// Maximum number of maps of an actuator: steps and parts of them, each in some modes.
pub(super) const MOST_MAPS: usize = 48;

/// Number of lengths without a map that are remembered: a map is made when a length recurs.
const REMEMBERED_LENGTHS: usize = 4;

/// Number of pieces after which maps over whole pieces are no longer tried if less than half of the lengths have recurred, as with an uneven
/// clock.
const FIRST_PIECES: u32 = 16;

/// The maps of an actuator.
#[derive(Debug, Clone, Default)]
pub(super) struct LinearMaps {
    pub(super) maps: Vec<LinearMap>,
    /// Number of lengths requested, and of those seen before.
    asked: u32,
    seen: u32,
    /// The latest lengths without a map, and the index of the next one.
    missed: [f64; REMEMBERED_LENGTHS],
    next: usize,
}

impl LinearMaps {
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// False if lengths do not recur, after enough pieces to exclude chance.
    pub(super) fn are_worth_it(&self) -> bool {
        self.asked < FIRST_PIECES || self.come_again()
    }

    /// Whether most lengths recur.
    pub(super) fn come_again(&self) -> bool {
        self.asked <= 2 * self.seen
    }

    /// True if there is a map of this length and most lengths recur.
    pub(super) fn have(&self, length: f64) -> bool {
        self.come_again() && self.maps.iter().any(|map| is_same(map.length, length))
    }

    /// True if there is a map of this length or it was requested recently; otherwise it is remembered.
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

    /// The map of this kind with exactly this length, if there is one.
    #[inline]
    pub(super) fn known(&self, kind: &Kind, length: f64) -> Option<&LinearMap> {
        self.maps.iter().find(|map| map.length == length && map.kind == *kind)
    }

    /// Records the request for a length that has a map.
    #[inline]
    pub(super) fn has_found(&mut self) {
        (self.asked, self.seen) = (self.asked.saturating_add(1), self.seen.saturating_add(1));
    }

    /// The map of a system over this length, made if necessary; `None` if the maximum number is reached.
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

/// True if two piece lengths are equal within the tolerance.
fn is_same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME_LENGTH * other
}
