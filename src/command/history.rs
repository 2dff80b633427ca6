//! The past of a piecewise linear command, over the length of the delay.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::operator::Piece;

/// Knot of a piecewise linear command, which is linear from this time to the next knot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Knot {
    /// \[s\]
    pub time: f64,
    /// \[deg\]
    pub value: f64,
    /// [deg/s]
    pub slope: f64,
}

impl Knot {
    fn at(&self, time: f64) -> f64 {
        // The first knot is at -∞: 0 times its distance would be NaN.
        if self.slope == 0.0 { self.value } else { self.value + self.slope * (time - self.time) }
    }

    /// True if a piece continues the line of this knot: start and end lie on it within rounding. Errors do not accumulate, since every
    /// piece is compared with the same knot.
    fn goes_on(&self, time: f64, piece: Piece) -> bool {
        const ROUNDINGS: f64 = 4.0 * f64::EPSILON;
        let is_same = |one: f64, other: f64| (one - other).abs() <= ROUNDINGS * one.abs().max(other.abs());
        if self.slope == 0.0 || piece.slope == 0.0 {
            return self.slope == piece.slope && self.value == piece.value;
        }
        is_same(self.at(time), piece.value) && is_same(self.at(time + piece.length), piece.at(piece.length))
    }
}

/// Change made by the last recorded piece.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub enum Change {
    /// None: it continues the line of the last knot.
    #[default]
    None,
    /// A new knot.
    Appended(Knot),
    /// A knot replaced at the same time.
    Replaced(Knot, Knot),
}

/// Knots in the order of time.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct History {
    knots: VecDeque<Knot>,
}

impl Clone for History {
    /// With the same capacity, so that later changes do not allocate.
    fn clone(&self) -> Self {
        let mut knots = VecDeque::with_capacity(self.knots.capacity());
        knots.extend(&self.knots);
        Self { knots }
    }

    #[inline]
    fn clone_from(&mut self, source: &Self) {
        if !(self.knots.is_empty() && source.knots.is_empty()) {
            self.copy(source);
        }
    }
}

impl<'a> Extend<&'a Knot> for History {
    fn extend<T: IntoIterator<Item = &'a Knot>>(&mut self, knots: T) {
        self.knots.extend(knots);
    }
}

impl History {
    #[inline(never)]
    fn copy(&mut self, source: &Self) {
        self.knots.clear();
        self.reserve(source.knots.capacity());
        self.knots.extend(&source.knots);
    }

    /// Capacity in knots.
    pub fn reserve(&mut self, knots: usize) {
        self.knots.reserve(knots.saturating_sub(self.knots.len()));
    }

    /// True without knots.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.knots.is_empty()
    }

    /// Removes all knots.
    pub fn clear(&mut self) {
        self.knots.clear();
    }

    /// A constant command at all times.
    pub fn start(&mut self, value: f64) {
        self.knots.clear();
        self.knots.push_back(Knot { time: f64::MIN, value, slope: 0.0 });
    }

    /// All knots.
    pub fn iter(&self) -> impl Iterator<Item = &Knot> {
        self.knots.iter()
    }

    /// Shifts the knots from one time to another.
    pub fn move_knots(&mut self, from: f64, to: f64) {
        self.knots.iter_mut().filter(|knot| knot.time == from).for_each(|knot| knot.time = to);
    }

    /// Removes knots older than a time \[s\].
    pub fn forget_before(&mut self, time: f64) {
        while self.knots.get(1).is_some_and(|next| next.time <= time) {
            self.knots.pop_front();
        }
    }

    /// The change that recording the command from `time` \[s\] on would make.
    #[must_use]
    pub fn change(&self, time: f64, piece: Piece) -> Change {
        let Piece { value, slope, .. } = piece;
        let knot = Knot { time, value, slope };
        match self.knots.back() {
            Some(last) if last.goes_on(time, piece) => Change::None,
            // The same instant, after a step of zero length.
            Some(last) if last.time >= time => Change::Replaced(*last, Knot { time: last.time, ..knot }),
            _ => Change::Appended(knot),
        }
    }

    /// Applies a change.
    pub fn apply(&mut self, change: Change) {
        match change {
            Change::None => {}
            Change::Appended(knot) => self.knots.push_back(knot),
            Change::Replaced(_, knot) => {
                self.knots.pop_back();
                self.knots.push_back(knot);
            }
        }
    }

    /// Reverts the last change.
    pub fn undo(&mut self, change: Change) {
        match change {
            Change::None => {}
            Change::Appended(_) => drop(self.knots.pop_back()),
            Change::Replaced(knot, _) => {
                self.knots.pop_back();
                self.knots.push_back(knot);
            }
        }
    }

    /// The history with a change that is not applied.
    #[must_use]
    pub fn with(&self, change: Change) -> Past<'_> {
        let (count, last) = match change {
            Change::None => (self.knots.len(), None),
            Change::Appended(knot) => (self.knots.len() + 1, Some(knot)),
            Change::Replaced(_, knot) => (self.knots.len(), Some(knot)),
        };
        Past { knots: &self.knots, last, count }
    }
}

/// Knots with a possibly different last one.
#[derive(Debug, Clone, Copy)]
pub struct Past<'a> {
    knots: &'a VecDeque<Knot>,
    last: Option<Knot>,
    count: usize,
}

impl Past<'_> {
    fn knot(&self, index: usize) -> Option<Knot> {
        let last = self.last.filter(|_| index + 1 == self.count);
        last.or_else(|| self.knots.get(index).copied()).filter(|_| index < self.count)
    }

    /// Number of knots at or before a time [s].
    fn count_until(&self, time: f64) -> usize {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = usize::midpoint(low, high);
            if self.knot(middle).is_some_and(|knot| knot.time <= time) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Only the knots before a time [s].
    #[must_use]
    pub fn before(self, time: f64) -> Self {
        let mut count = self.count;
        while count > 1 && self.knot(count - 1).is_some_and(|knot| knot.time >= time) {
            count -= 1;
        }
        // The changed knot is the last one; without it nothing has changed.
        Self { last: self.last.filter(|_| count == self.count), count, ..self }
    }

    /// The piece that starts at a time [s], up to the next knot at most; a knot within the time resolution counts as reached. Before the
    /// first knot the command has the value of that knot.
    #[must_use]
    pub fn piece(&self, time: f64, now: Piece) -> Option<Piece> {
        let reached = self.count_until(time + now.time_resolution);
        let (value, slope) = match reached.checked_sub(1).and_then(|index| self.knot(index)) {
            Some(knot) => (knot.at(time), knot.slope),
            None => (self.knot(0)?.value, 0.0),
        };
        let next = self.knot(reached).map_or(f64::INFINITY, |next| next.time - time);
        Some(Piece { value, slope, length: now.length.min(next), ..now })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(value: f64, slope: f64, length: f64) -> Piece {
        Piece { value, slope, length, time_resolution: 0.0 }
    }

    fn recorded(pieces: &[(f64, f64, f64)]) -> History {
        let mut history = History::default();
        let mut time = 0.0;
        for (value, slope, length) in pieces {
            let piece = piece(*value, *slope, *length);
            history.apply(history.change(time, piece));
            time += length;
        }
        history
    }

    #[test]
    fn pieces_of_one_line_are_one_knot() {
        let ramp: Vec<_> = (0..1000).map(|step| (1.0 + 0.3 * 1e-3 * f64::from(step), 0.3, 1e-3)).collect();
        assert_eq!(recorded(&ramp).knots.len(), 1);
        assert_eq!(recorded(&[(1.0, 0.0, 0.1), (1.0, 0.0, 0.1), (1.0, 0.5, 0.1), (1.05, 0.0, 0.1)]).knots.len(), 3);
        assert_eq!(recorded(&[(0.0, 1.0, 0.1), (0.1, 1.0 + 1e-12, 0.1)]).knots.len(), 2);
    }

    #[test]
    fn before_its_first_knot_the_command_is_held() {
        let history = recorded(&[(2.0, 3.0, 1.0), (0.0, 0.0, 1.0)]);
        let at = |time: f64| history.with(Change::None).piece(time, piece(9.0, 9.0, 9.0)).unwrap();
        assert_eq!(at(-0.5), piece(2.0, 0.0, 0.5));
        assert_eq!(at(0.5), piece(3.5, 3.0, 0.5));
        assert_eq!(at(1.0), piece(0.0, 0.0, 9.0));
    }

    #[test]
    fn a_change_is_seen_before_it_is_made_and_can_be_taken_back() {
        let history = recorded(&[(1.0, 0.0, 1.0), (2.0, 0.0, 1.0)]);
        for (time, now) in [(2.0, piece(5.0, 1.0, 1.0)), (1.0, piece(5.0, 1.0, 1.0)), (2.0, piece(2.0, 0.0, 1.0))] {
            let change = history.change(time, now);
            let mut made = history.clone();
            made.apply(change);
            for at in [0.5, 1.5, 2.5] {
                assert_eq!(history.with(change).piece(at, now), made.with(Change::None).piece(at, now));
            }
            made.undo(change);
            assert_eq!(made, history);
        }
    }
}
