//! The first instant at which a series leaves a range: found with certainty, since bounds of its second derivative exclude crossings
//! elsewhere.

use super::{
    bounds::{Local, Outline, reach_by_third_derivative},
    range::{Range, Side},
    root::Point,
    taylor::{BEND, Decay, NUMBER, Series, TERMS},
};

/// Relative tolerance of instants, in τ.
const RESOLUTION: f64 = 4.0 * f64::EPSILON;

/// Intervals of τ shorter than this are not bisected further.
const MIN_INTERVAL: f64 = 1e-12;

/// Maximum number of bisections of a search, twice those down to the shortest interval: a signal along its limit, within rounding, would
/// require a search everywhere.
const MOST_BISECTIONS: u32 = 100;

impl Series {
    /// The earliest τ up to `until` at which the signal is outside the range by more than the tolerance, and the side on which it leaves.
    #[must_use]
    pub fn leaves(&self, range: Range, tolerance: f64, until: f64) -> Option<(f64, Side)> {
        let limits = Range { low: range.low - tolerance, high: range.high + tolerance };
        if self.is_line() {
            return self.line_leaves(limits, until);
        }
        let outline = Outline::of(self);
        match outline.stays_in(limits, until) {
            [true, true] => None,
            stays => self.search(&outline, stays, limits, until),
        }
    }

    /// As above for d/dτ.
    #[must_use]
    pub fn derivative_leaves(&self, range: Range, tolerance: f64, until: f64) -> Option<(f64, Side)> {
        let limits = Range { low: range.low - tolerance, high: range.high + tolerance };
        if self.is_line() {
            return side_beyond(self.terms[1], limits).map(|side| (0.0, side));
        }
        let outline = Outline::of_derivative(self);
        match outline.stays_in(limits, until) {
            [true, true] => None,
            stays => self.derivative().search(&outline, stays, limits, until),
        }
    }

    fn is_line(&self) -> bool {
        self.length <= 2 && self.decays[0].amplitude == 0.0 && self.decays[1].amplitude == 0.0
    }

    /// For a straight line.
    fn line_leaves(&self, limits: Range, until: f64) -> Option<(f64, Side)> {
        let [start, slope] = [self.terms[0], self.terms[1]];
        let tau = |limit: f64| beyond((limit - start) / slope, 0.0, until);
        side_beyond(start, limits).map(|side| (0.0, side)).or_else(|| {
            let side = side_beyond(start + slope * until, limits)?;
            Some((tau(if side == Side::Above { limits.high } else { limits.low }), side))
        })
    }

    /// Across the ends for which the bounds do not exclude it.
    fn search(&self, outline: &Outline, stays: [bool; 2], limits: Range, until: f64) -> Option<(f64, Side)> {
        let (sum, magnitude) = self.signed_and_absolute_sum(&BEND);
        let first = |sign: f64, limit: f64, until: f64| {
            let (start, bend) = (outline.local(sign, limit), outline.bend(sign, until));
            let (up, down) = (0.5 * (magnitude + sign * sum), 0.5 * (magnitude - sign * sum));
            Search { series: self, sign, limit, until, up, down }.first(start, bend)
        };
        let above = if stays[0] { None } else { first(1.0, limits.high, until) };
        let below = if stays[1] { None } else { first(-1.0, limits.low, above.unwrap_or(until)) };
        match (above, below) {
            (Some(above), Some(below)) if below < above => Some((below, Side::Below)),
            (Some(above), _) => Some((above, Side::Above)),
            (None, below) => below.map(|tau| (tau, Side::Below)),
        }
    }
}

/// Search for the first sign change from non-positive to positive of f = sign × (series - limit).
///
/// It advances from the left over intervals that bounds of f ahead (`bounds`) show to be free of crossings. If all of them become positive
/// ahead, the first root of the latest one is the next τ: Newton's method, from a side on which it never passes a crossing. If f only rises
/// up to a point beyond the limit, the one crossing is refined.
struct Search<'a> {
    series: &'a Series,
    sign: f64,
    limit: f64,
    /// Crossings after this τ do not matter.
    until: f64,
    /// Bounds, at least 0, of Q'' and of -Q'' for τ in [0, 1].
    up: f64,
    down: f64,
}

impl Search<'_> {
    fn value(&self, tau: f64) -> f64 {
        self.sign * (self.series.at(tau) - self.limit)
    }

    fn point(&self, tau: f64) -> Point {
        let (mut value, mut slope) = self.series.polynomial_at(tau);
        let mut decaying = 0.0;
        for decay in self.series.decays.iter().filter(|decay| decay.amplitude != 0.0) {
            let rest = decay.at(tau);
            let fall = decay.exponent * rest;
            (value, slope, decaying) = (value + rest, slope - fall, decaying + fall.abs());
        }
        Point { tau, value: self.sign * (value - self.limit), slope: self.sign * slope, decaying }
    }

    fn local(&self, tau: f64) -> Local {
        let (polynomial, slope) = self.series.polynomial_at(tau);
        let mut local = Local::polynomial(self.sign * (polynomial - self.limit), self.sign * slope);
        for decay in self.series.decays.iter().filter(|decay| decay.amplitude != 0.0) {
            local.add(self.sign * decay.at(tau), decay.exponent);
        }
        local
    }

    /// From 0, if the bounds do not exclude a crossing.
    fn first(&self, start: Local, bend: f64) -> Option<f64> {
        if start.value() > 0.0 { Some(0.0) } else { self.advance(start, bend) }
    }

    /// From 0, where f is at or below 0 and its polynomial below the parabola of this second derivative.
    fn advance(&self, start: Local, mut bend: f64) -> Option<f64> {
        /// Far more than any search has taken; the remainder is bisected.
        const MOST_ADVANCES: usize = 60;
        /// After a first step shorter than this the signal may be leaving its limit.
        const SHORT: f64 = 0.1;
        let (mut tau, mut here) = (0.0, start);
        let mut before: Option<Point> = None;
        if tau >= self.until {
            return None;
        }
        for _ in 0..MOST_ADVANCES {
            if let Some((end, there)) = self.end_of_rise(tau, &here) {
                let here = here.point(tau);
                let guess = match there.or(before) {
                    Some(other) => here.root_with(&other),
                    None => self.root_by_start(&here),
                };
                return Some(self.refine((tau, end), here, guess));
            }
            if self.down == 0.0 && here.rising[0] == 0.0 {
                // Convex: if the end is beyond the limit, there is one crossing before it, and otherwise none.
                let end = self.point(self.until);
                let guess = self.until - end.value / end.slope;
                return (end.value > 0.0).then(|| self.refine((tau, self.until), end, guess));
            }
            let mut step = here.reach(bend);
            if tau == 0.0 && step < SHORT {
                step = step.max(reach_by_third_derivative(self.series, self.sign, self.limit, self.until));
            }
            if step >= self.until - tau {
                return None;
            }
            if step < MIN_INTERVAL {
                break;
            }
            before = Some(here.point(tau));
            tau += step;
            here = self.local(tau);
            bend = self.up;
            if here.stays(bend, self.until - tau) {
                return None;
            }
        }
        let at_tau = if tau == 0.0 { start.value() } else { self.value(tau) };
        if at_tau > 0.0 {
            // Within rounding the bound is the crossing itself.
            return Some(tau);
        }
        self.between(tau, at_tau, self.until, self.value(self.until), &mut { MOST_BISECTIONS })
    }

    /// A τ beyond the limit up to which f only rises from here, with f there if it was evaluated; found if a doubled Newton step leads to
    /// one.
    fn end_of_rise(&self, tau: f64, here: &Local) -> Option<(f64, Option<Point>)> {
        let slope = here.total_slope();
        if slope <= 0.0 {
            return None;
        }
        // At least the shift of the crossing due to rounding.
        let end = (tau - 2.0 * here.value() / slope + MIN_INTERVAL).min(self.until);
        let long = end - tau;
        // Minimum slope up to there: that of rising decays only decreases.
        let least = here.slope - self.down * long + here.falling[1];
        if least + here.rising[1] <= 0.0 {
            return None;
        }
        // Minimum value there, if the rising decays stayed constant.
        if least > 0.0 && here.value() + (here.slope - 0.5 * self.down * long + here.falling[1]) * long > 0.0 {
            return Some((end, None));
        }
        let there = self.local(end);
        (there.value() > 0.0 && least + there.rising[1] > 0.0).then(|| (end, Some(there.point(end))))
    }

    /// Estimate of the first root after τ = 0, by the Taylor polynomial of third degree.
    fn root_by_start(&self, start: &Point) -> f64 {
        let terms = &self.series.terms;
        let (mut second, mut third) = (2.0 * terms[2], 6.0 * terms[3]);
        for Decay { amplitude, exponent } in &self.series.decays {
            let bend = amplitude * exponent * exponent;
            second += bend;
            third -= bend * exponent;
        }
        start.root_by_derivatives(self.sign * second, self.sign * third)
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
        // For a signal that starts at its limit the chord bound would bisect down to the shortest interval: there the tangent is the better
        // bound.
        if at_a <= 0.0 && at_a + self.sign * self.series.slope_at(a) * width + 0.5 * below * width * width <= 0.0 {
            return None;
        }
        if at_b > 0.0 && at_b - at_a > above.max(below) * width * width {
            let (from, to) = (self.point(a), self.point(b));
            return Some(self.refine((a, b), from, from.root_with(&to)));
        }
        if width.is_nan() || width < MIN_INTERVAL || *left == 0 {
            return (at_b > 0.0).then_some(b);
        }
        *left -= 1;
        let middle = 0.5 * (a + b);
        let at_middle = self.value(middle);
        let earlier = self.between(a, at_a, middle, at_middle, left);
        // If the middle is positive, the left half contains a crossing, and the right half need not be searched.
        if earlier.is_some() || at_middle > 0.0 {
            earlier.or(Some(middle))
        } else {
            self.between(middle, at_middle, b, at_b, left)
        }
    }

    /// The one crossing between a (at or below the limit) and b (beyond it), to a few roundings, from a known point and an estimate.
    fn refine(&self, (mut a, mut b): (f64, f64), mut before: Point, mut tau: f64) -> f64 {
        let rate = |decay: &Decay| if decay.amplitude == 0.0 { 0.0 } else { decay.exponent };
        let fastest = rate(&self.series.decays[0]).max(rate(&self.series.decays[1]));
        let bend = self.up + self.down;
        for _ in 0..100 {
            if !(tau > a && tau < b) {
                tau = 0.5 * (a + b);
            }
            if b - a <= RESOLUTION * b || tau <= a || tau >= b {
                return b;
            }
            let here = self.point(tau);
            if here.value > 0.0 {
                b = tau;
            } else {
                a = tau;
            }
            let root = here.root_with(&before);
            if here.error_of_root(root, &before, fastest, bend) <= RESOLUTION * b {
                return beyond(root, a, b);
            }
            (before, tau) = (here, root);
        }
        b
    }
}

/// The end beyond which a value lies.
fn side_beyond(value: f64, limits: Range) -> Option<Side> {
    if value > limits.high { Some(Side::Above) } else { (value < limits.low).then_some(Side::Below) }
}

/// This root, between a and b, as a τ beyond the limit within the resolution of τ.
fn beyond(root: f64, a: f64, b: f64) -> f64 {
    (root.max(a) + RESOLUTION * b).min(b)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::series::Decay;

    proptest! {
        /// No crossing is missed, for decays of any amplitude and rate: before the instant found the signal is nowhere above the limit; at it,
        /// it is.
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

        /// The instant found is that of the crossing, to a few roundings: just before it, the signal has not passed the limit.
        #[test]
        fn the_instant_is_that_of_the_crossing(
            coefficients in prop::collection::vec(-1.0_f64..1.0, 1..20),
            amplitude in -1.0_f64..1.0,
            exponent in 0.0_f64..7.0,
            ends in (-2.0_f64..0.0, 0.0_f64..2.0),
        ) {
            let mut series = Series::polynomial(&coefficients);
            series.decays[0] = Decay { amplitude, exponent: exponent.exp() };
            let range = Range { low: series.start() + ends.0, high: series.start() + ends.1 };
            if let Some((tau, side)) = series.leaves(range, 0.0, 1.0) {
                let beyond = |tau: f64| match side {
                    Side::Above => series.at(tau) - range.high,
                    Side::Below => range.low - series.at(tau),
                };
                prop_assert!(beyond(tau) >= -1e-14 && beyond(tau * (1.0 - 1e-14)) <= 1e-14, "{tau} {}", beyond(tau));
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
