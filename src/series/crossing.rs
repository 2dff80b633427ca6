//! The first instant at which a series leaves a range: found with certainty, since bounds of its second derivative exclude
//! crossings elsewhere.

use super::{
    range::{Range, Side},
    taylor::{BEND, NUMBER, Series, TERMS},
};

/// Instants are located to this share of τ.
const RESOLUTION: f64 = 4.0 * f64::EPSILON;

/// Intervals of τ shorter than this are not bisected further.
const MIN_INTERVAL: f64 = 1e-12;

/// A search bisects so often, twice down to the shortest interval: a signal along its limit, within rounding, would have it look
/// everywhere.
const MOST_BISECTIONS: u32 = 100;

impl Series {
    /// The earliest τ up to `until` at which the signal is outside the range by more than the tolerance, and the side on which it leaves.
    #[must_use]
    pub fn leaves(&self, range: Range, tolerance: f64, until: f64) -> Option<(f64, Side)> {
        self.leaves_with_bounds(self.bounds(), range, tolerance, until)
    }

    /// The same for d/dτ.
    #[must_use]
    pub fn derivative_leaves(&self, range: Range, tolerance: f64, until: f64) -> Option<(f64, Side)> {
        let bounds = self.derivative_bounds();
        if bounds.0 >= range.low - tolerance && bounds.1 <= range.high + tolerance {
            return None;
        }
        self.derivative().leaves_with_bounds(bounds, range, tolerance, until)
    }

    fn leaves_with_bounds(&self, bounds: (f64, f64), range: Range, tolerance: f64, until: f64) -> Option<(f64, Side)> {
        let (low, high) = (range.low - tolerance, range.high + tolerance);
        let first = |sign: f64, limit: f64, until: f64| Search { series: self, sign, limit, until }.first();
        let above = (bounds.1 > high).then(|| first(1.0, high, until)).flatten();
        let until = above.unwrap_or(until);
        let below = (bounds.0 < low).then(|| first(-1.0, low, until)).flatten();
        match (above, below) {
            (Some(above), Some(below)) if below < above => Some((below, Side::Below)),
            (Some(above), _) => Some((above, Side::Above)),
            (None, below) => below.map(|tau| (tau, Side::Below)),
        }
    }
}

/// Search for the first sign change from non-positive to positive of f = sign × (series - limit).
///
/// It advances from the left over what cannot contain a crossing. With f = Q + Σ D_i, polynomial and decays, from τ on f is at most
///
/// ```text
/// Q + Σ D_i + (Q' + Σ D_i') s + (B + Σ' D_i'') s² / 2        tangents; Σ' over decays that fall to 0 from above
/// Q + Σ' D_i + Q' s + B s² / 2                               decays frozen, or at 0 where they rise to it
/// ```
///
/// with B >= Q'' over the segment. Where both are positive ahead, the first root of the later one is the next τ: Newton's method, from a
/// side on which it never passes a crossing. Where f only rises up to a point beyond the limit, the one crossing is refined.
struct Search<'a> {
    series: &'a Series,
    sign: f64,
    limit: f64,
    /// Crossings after this τ do not matter.
    until: f64,
}

/// Value and slope of f at an instant, in their parts.
#[derive(Clone, Copy, Default)]
struct Local {
    polynomial: f64,
    slope: f64,
    /// Decays that fall to 0 from above: value, slope (negative), second derivative.
    falling: [f64; 3],
    /// Decays that rise to 0 from below: value (negative), slope.
    rising: [f64; 2],
}

impl Local {
    fn value(&self) -> f64 {
        self.polynomial + self.falling[0] + self.rising[0]
    }
}

/// How far ahead a + b s + c s² / 2 stays at or below 0, with c >= 0; infinite where it always does.
fn reach(a: f64, b: f64, c: f64) -> f64 {
    if a > 0.0 {
        return 0.0;
    }
    let root = (b * b - 2.0 * a * c).sqrt();
    if b > 0.0 {
        -2.0 * a / (b + root)
    } else if c > 0.0 {
        (root - b) / c
    } else {
        f64::INFINITY
    }
}

impl Search<'_> {
    fn value(&self, tau: f64) -> f64 {
        self.sign * (self.series.at(tau) - self.limit)
    }

    fn local(&self, tau: f64) -> Local {
        let terms = &self.series.terms;
        let (polynomial, slope) = if tau == 0.0 { (terms[0], terms[1]) } else { self.series.polynomial_at(tau) };
        let mut local =
            Local { polynomial: self.sign * (polynomial - self.limit), slope: self.sign * slope, ..Local::default() };
        for decay in self.series.decays.iter().filter(|decay| decay.amplitude != 0.0) {
            let (value, rate) = (self.sign * decay.at(tau), decay.exponent);
            if value > 0.0 {
                local.falling =
                    [local.falling[0] + value, local.falling[1] - rate * value, local.falling[2] + rate * rate * value];
            } else {
                local.rising = [local.rising[0] + value, local.rising[1] - rate * value];
            }
        }
        local
    }

    fn first(&self) -> Option<f64> {
        let start = self.sign * (self.series.start() - self.limit);
        if start > 0.0 { Some(0.0) } else { self.advance(start) }
    }

    /// Bounds, at least 0, of Q'' and of -Q'' for τ in [0, 1].
    fn polynomial_bends(&self) -> (f64, f64) {
        let (sum, magnitude) = self.series.signed_and_absolute_sum(&BEND);
        let (up, down) = (0.5 * (magnitude + sum), 0.5 * (magnitude - sum));
        if self.sign > 0.0 { (up, down) } else { (down, up) }
    }

    /// From 0, where f is at or below 0.
    fn advance(&self, start: f64) -> Option<f64> {
        /// Far more than any search has taken; what is left is bisected.
        const MOST_ADVANCES: usize = 60;
        let (up, down) = self.polynomial_bends();
        let mut tau = 0.0;
        let mut here = self.local(0.0);
        if tau >= self.until {
            return None;
        }
        for _ in 0..MOST_ADVANCES {
            let Local { polynomial, slope, falling, rising } = here;
            let frozen = reach(polynomial + falling[0], slope, up);
            let tangents = reach(here.value(), slope + falling[1] + rising[1], up + falling[2]);
            let step = frozen.max(tangents);
            if step >= self.until - tau {
                return None;
            }
            if let Some(end) = self.end_of_rise(tau, &here, down) {
                return Some(self.refine(tau, here.value(), end.0, end.1));
            }
            if step < MIN_INTERVAL {
                break;
            }
            tau += step;
            here = self.local(tau);
        }
        let at_tau = if tau == 0.0 { start } else { self.value(tau) };
        if at_tau > 0.0 {
            // Within rounding the bound is the crossing itself.
            return Some(tau);
        }
        self.between(tau, at_tau, self.until, self.value(self.until), &mut { MOST_BISECTIONS })
    }

    /// A τ beyond the limit, with f there, up to which f only rises from here; found where Newton's method doubled leads to one.
    fn end_of_rise(&self, tau: f64, here: &Local, down: f64) -> Option<(f64, f64)> {
        let slope = here.slope + here.falling[1] + here.rising[1];
        if slope <= 0.0 {
            return None;
        }
        // Not short of what rounding moves the crossing by.
        let end = (tau - 2.0 * here.value() / slope + MIN_INTERVAL).min(self.until);
        // Least slope up to there: that of rising decays only falls.
        let least = here.slope - down * (end - tau) + here.falling[1];
        if least + here.rising[1] <= 0.0 {
            return None;
        }
        let there = self.local(end);
        (there.value() > 0.0 && least + there.rising[1] > 0.0).then(|| (end, there.value()))
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
    fn between(&self, a: f64, at_a: f64, b: f64, at_b: f64, left: &mut u32) -> Option<f64> {
        let width = b - a;
        let (above, below) = self.curvature_bounds(a, b);
        if at_b <= 0.0 && at_a.max(at_b) + above * width * width / 8.0 <= 0.0 {
            return None;
        }
        // For a signal that starts at its limit the bound by the chord would bisect down to the shortest interval: there the
        // tangent is the better bound.
        if at_a <= 0.0 && at_a + self.sign * self.series.slope_at(a) * width + 0.5 * below * width * width <= 0.0 {
            return None;
        }
        if at_b > 0.0 && at_b - at_a > above.max(below) * width * width {
            return Some(self.refine(a, at_a, b, at_b));
        }
        if width.is_nan() || width < MIN_INTERVAL || *left == 0 {
            return (at_b > 0.0).then_some(b);
        }
        *left -= 1;
        let middle = 0.5 * (a + b);
        let at_middle = self.value(middle);
        let earlier = self.between(a, at_a, middle, at_middle, left);
        // Where the middle is positive, the left half contains a crossing, and the right half need not be searched.
        if earlier.is_some() || at_middle > 0.0 {
            earlier.or(Some(middle))
        } else {
            self.between(middle, at_middle, b, at_b, left)
        }
    }

    /// The one crossing between a (at or below) and b (above), by Newton's method within that bracket; returns a τ that is beyond the
    /// limit, by a few roundings.
    fn refine(&self, mut a: f64, at_a: f64, mut b: f64, at_b: f64) -> f64 {
        let mut tau = b - at_b * (b - a) / (at_b - at_a);
        for _ in 0..100 {
            if !(tau > a && tau < b) {
                tau = 0.5 * (a + b);
            }
            if b - a <= RESOLUTION * b || tau <= a || tau >= b {
                return b;
            }
            let here = self.local(tau);
            let (value, slope) = (here.value(), here.slope + here.falling[1] + here.rising[1]);
            let change = -value / slope;
            if value > 0.0 {
                b = tau;
            } else {
                a = tau;
            }
            if change.abs() <= RESOLUTION * b {
                return if value > 0.0 { tau } else { self.beyond(tau, b) };
            }
            tau += change;
        }
        b
    }

    /// The first τ found beyond the limit a few roundings after this one, at which it is reached; b is beyond.
    fn beyond(&self, tau: f64, b: f64) -> f64 {
        let steps = (0..10).map(|doubled| tau + f64::from(1 << doubled) * RESOLUTION * tau);
        steps.take_while(|next| *next < b).find(|next| self.value(*next) > 0.0).unwrap_or(b)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::series::Decay;

    proptest! {
        /// Nothing is stepped over, with decays of any strength and speed: before the instant found, the signal is nowhere above; at it, it is.
        #[test]
        fn the_first_crossing_is_found(
            coefficients in prop::collection::vec(-1.0_f64..1.0, 1..8),
            amplitude in -1.0_f64..1.0,
            exponent in 0.0_f64..7.0,
            other in (-1.0_f64..1.0, 3.0_f64..10.0),
            limit in -2.0_f64..2.0,
        ) {
            let mut series = Series::polynomial(&coefficients);
            series.decays[0] = Decay { amplitude, exponent: exponent.exp() };
            series.decays[1] = Decay { amplitude: other.0, exponent: other.1.exp() };
            let found = series.leaves(Range::below(limit), 0.0, 1.0).map(|(tau, _)| tau);
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
        let found = series.leaves(Range { low: -1e-3, high: 0.2499 }, 0.0, 1.0).unwrap();
        assert!((found.0 - 0.49).abs() < 1e-12 && found.1 == Side::Above);
        assert_eq!(series.leaves(Range { low: -1e-3, high: 0.25 }, 1e-15, 1.0), None);
        let turns = series.derivative_leaves(Range::above(0.0), 0.0, 1.0).unwrap();
        assert!((turns.0 - 0.5).abs() < 1e-12 && turns.1 == Side::Below);
    }
}
