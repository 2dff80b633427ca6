//! The range within which a signal must stay for a mode to hold.

/// Margin of event indicators: far below what a solver resolves.
const MARGIN: f64 = 1e-12;

/// A closed range of values, possibly unbounded.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Range {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Range {
    /// All values.
    pub const ALL: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// Values of at least `low`.
    #[must_use]
    pub fn above(low: f64) -> Self {
        Self { low, high: f64::INFINITY }
    }

    /// Values of at most `high`.
    #[must_use]
    pub fn below(high: f64) -> Self {
        Self { low: f64::NEG_INFINITY, high }
    }

    /// The value, or the end beyond which it lies. Unlike `f64::clamp` it does not panic if an end is NaN: a motion that overflows is
    /// refused when the step has been computed.
    #[must_use]
    #[inline]
    pub fn nearest(&self, value: f64) -> f64 {
        if value < self.low {
            self.low
        } else if value > self.high {
            self.high
        } else {
            value
        }
    }

    /// True if at least one end is finite.
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        self.low > f64::NEG_INFINITY || self.high < f64::INFINITY
    }

    /// True if another range lies inside, apart from the ends.
    #[must_use]
    pub fn holds(&self, other: Self) -> bool {
        let above = self.low == f64::NEG_INFINITY || other.low > self.low;
        above && (self.high == f64::INFINITY || other.high < self.high)
    }

    /// Distances of a value from the lower and the upper end, 1 for an infinite end: in units of `scale`, and larger by a margin, so that
    /// they are positive at the ends. They are event indicators: one changes sign where the value leaves the range.
    #[must_use]
    pub fn distances(&self, value: f64, scale: f64) -> [f64; 2] {
        [(value - self.low, self.low), (self.high - value, self.high)].map(|(distance, end)| {
            if end.is_finite() { distance / scale + MARGIN * (1.0 + (end / scale).abs()) } else { 1.0 }
        })
    }
}

/// The end over which a signal leaves its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The upper end.
    Above,
    /// The lower end.
    Below,
}
