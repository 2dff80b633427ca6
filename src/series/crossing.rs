//! The first instant at which a series leaves a range: found with certainty, since bounds of its second derivative exclude
//! crossings elsewhere.

use super::{
    range::{Range, Side},
    taylor::{NUMBER, Series, TERMS},
};

/// Intervals of τ shorter than this are not bisected further.
const MIN_INTERVAL: f64 = 1e-12;

impl Series {
    /// The earliest τ at which the signal is outside the range by more than the tolerance, and the side on which it leaves.
    #[must_use]
    pub fn leaves(&self, range: Range, tolerance: f64) -> Option<(f64, Side)> {
        self.leaves_with_bounds(self.bounds(), range, tolerance)
    }

    /// The same for d/dτ.
    #[must_use]
    pub fn derivative_leaves(&self, range: Range, tolerance: f64) -> Option<(f64, Side)> {
        let bounds = self.derivative_bounds();
        if bounds.0 >= range.low - tolerance && bounds.1 <= range.high + tolerance {
            return None;
        }
        self.derivative().leaves_with_bounds(bounds, range, tolerance)
    }

    fn leaves_with_bounds(&self, bounds: (f64, f64), range: Range, tolerance: f64) -> Option<(f64, Side)> {
        let (low, high) = (range.low - tolerance, range.high + tolerance);
        let above = (bounds.1 > high).then(|| Search { series: self, sign: 1.0, limit: high }.first()).flatten();
        let below = (bounds.0 < low).then(|| Search { series: self, sign: -1.0, limit: low }.first()).flatten();
        match (above, below) {
            (Some(above), Some(below)) if below < above => Some((below, Side::Below)),
            (Some(above), _) => Some((above, Side::Above)),
            (None, below) => below.map(|tau| (tau, Side::Below)),
        }
    }
}

/// Search for the first sign change from non-positive to positive of sign × (series - limit).
struct Search<'a> {
    series: &'a Series,
    sign: f64,
    limit: f64,
}

impl Search<'_> {
    fn value(&self, tau: f64) -> f64 {
        self.sign * (self.series.at(tau) - self.limit)
    }

    fn first(&self) -> Option<f64> {
        let start = self.sign * (self.series.start() - self.limit);
        if start > 0.0 { Some(0.0) } else { self.between(0.0, start, 1.0, self.value(1.0)) }
    }

    /// Upper bounds, at least 0, of -f'' and of f'' between a and b, with f = sign × series: they bound the distance of f from its
    /// chord.
    fn curvature_bounds(&self, a: f64, b: f64) -> (f64, f64) {
        let (mut concave, mut convex) = ((0.0, 0.0), (0.0, 0.0));
        let terms = self.series.terms[..self.series.length.min(TERMS)].iter().zip(NUMBER).skip(2).rev();
        for (term, n) in terms {
            let bend = n * (n - 1.0) * self.sign * term;
            let (up, down) = (bend.max(0.0), (-bend).max(0.0));
            concave = (concave.0 * a + down, concave.1 * b + down);
            convex = (convex.0 * a + up, convex.1 * b + up);
        }
        let (mut above, mut below) = (concave.1 - convex.0, convex.1 - concave.0);
        for decay in self.series.decays.iter().filter(|decay| decay.amplitude != 0.0) {
            let bend = |tau: f64| self.sign * decay.exponent * decay.exponent * decay.at(tau);
            above -= bend(a).min(bend(b));
            below += bend(a).max(bend(b));
        }
        (above.max(0.0), below.max(0.0))
    }

    /// Bisects the interval until the bounds prove that there is no crossing, or exactly one.
    fn between(&self, a: f64, at_a: f64, b: f64, at_b: f64) -> Option<f64> {
        let width = b - a;
        let (above, below) = self.curvature_bounds(a, b);
        if at_b <= 0.0 && at_a.max(at_b) + above * width * width / 8.0 <= 0.0 {
            return None;
        }
        // For a signal that starts at its limit the bound by the chord would bisect down to the shortest interval: there the
        // tangent is the better bound.
        if a == 0.0 {
            let slope = self.sign * self.series.slope_at_start();
            if at_a <= 0.0 && at_a + slope * width + 0.5 * below * width * width <= 0.0 {
                return None;
            }
        }
        if at_b > 0.0 && at_b - at_a > above.max(below) * width * width {
            return Some(self.refine(a, at_a, b, at_b));
        }
        if width < MIN_INTERVAL {
            return (at_b > 0.0).then_some(b);
        }
        let middle = 0.5 * (a + b);
        let at_middle = self.value(middle);
        let left = self.between(a, at_a, middle, at_middle);
        // Where the middle is positive, the left half contains a crossing, and the right half need not be searched.
        if left.is_some() || at_middle > 0.0 { left.or(Some(middle)) } else { self.between(middle, at_middle, b, at_b) }
    }

    /// The one crossing between a (at or below) and b (above), by regula falsi in the Illinois variant; returns the upper end,
    /// which is beyond the limit.
    fn refine(&self, mut a: f64, mut at_a: f64, mut b: f64, mut at_b: f64) -> f64 {
        let mut last = 0;
        for _ in 0..100 {
            let width = b - a;
            let mut c = b - at_b * width / (at_b - at_a);
            if !(c > a && c < b) {
                c = 0.5 * (a + b);
            }
            if width <= 4.0 * f64::EPSILON * b || c <= a || c >= b {
                break;
            }
            let at_c = self.value(c);
            if at_c > 0.0 {
                (b, at_b) = (c, at_c);
                if last == 1 {
                    at_a *= 0.5;
                }
                last = 1;
            } else {
                (a, at_a) = (c, at_c);
                if last == -1 {
                    at_b *= 0.5;
                }
                last = -1;
            }
        }
        b
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::series::Decay;

    proptest! {
        /// Nothing is stepped over: before the instant found, the signal is nowhere above; at it, it is.
        #[test]
        fn the_first_crossing_is_found(
            coefficients in prop::collection::vec(-1.0_f64..1.0, 1..8),
            amplitude in -1.0_f64..1.0,
            exponent in 3.0_f64..7.0,
            limit in -2.0_f64..2.0,
        ) {
            let mut series = Series::polynomial(&coefficients);
            series.decays[0] = Decay { amplitude, exponent: exponent.exp() };
            let found = series.leaves(Range::below(limit), 0.0).map(|(tau, _)| tau);
            let end = found.unwrap_or(1.0 + f64::EPSILON);
            for step in 0..10_000 {
                let tau = f64::from(step) * 1e-4;
                prop_assert!(tau >= end || series.at(tau) <= limit + 1e-14, "{tau} {}", series.at(tau));
            }
            if let Some(tau) = found {
                prop_assert!(series.at(tau) >= limit - 1e-14);
            }
        }
    }

    #[test]
    fn a_touch_and_a_double_crossing_inside_a_segment_are_seen() {
        // 0.25 - (τ - 0.5)² passes 0.2499 at 0.5 ± 0.01.
        let series = Series::polynomial(&[0.0, 1.0, -1.0]);
        let found = series.leaves(Range { low: -1e-3, high: 0.2499 }, 0.0).unwrap();
        assert!((found.0 - 0.49).abs() < 1e-12 && found.1 == Side::Above);
        assert_eq!(series.leaves(Range { low: -1e-3, high: 0.25 }, 1e-15), None);
        let turns = series.derivative_leaves(Range::above(0.0), 0.0).unwrap();
        assert!((turns.0 - 0.5).abs() < 1e-12 && turns.1 == Side::Below);
    }
}
