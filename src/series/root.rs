//! Estimates of a root from value and slope at a few points.

/// Value and slope of a function at an instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub tau: f64,
    pub value: f64,
    pub slope: f64,
    /// Magnitude of the decaying part of the slope.
    pub decaying: f64,
}

impl Point {
    /// The root of the cubic τ(f) with τ and dτ/df of both points: Newton's method from this one, corrected by the other.
    pub fn root_with(&self, other: &Self) -> f64 {
        // Divided differences over the values here, here, there, there.
        let (here, there) = (1.0 / self.slope, 1.0 / other.slope);
        let per_difference = 1.0 / (other.value - self.value);
        let chord = (other.tau - self.tau) * per_difference;
        let (first, second) = ((chord - here) * per_difference, (there - chord) * per_difference);
        let third = (second - first) * per_difference;
        self.tau - self.value * (here - self.value * (first - other.value * third))
    }

    /// Estimate of the error of that root: a 24th of the fourth derivative of τ(f), times the squares of both distances. The polynomial,
    /// whose second derivative is at most `bend`, contributes some cube of its curvature to that derivative, a decay the cube of its rate
    /// times its share of the slope.
    pub fn error_of_root(&self, root: f64, other: &Self, rate: f64, bend: f64) -> f64 {
        let change = (root - self.tau).abs();
        let both = change * ((self.tau - other.tau).abs() + change);
        let curvature = 1.0 + bend / self.slope;
        let decaying = self.decaying.max(other.decaying) / self.slope;
        (curvature * curvature * curvature + rate * rate * rate * decaying) * both * both
    }

    /// The root by the Taylor polynomial with these derivatives: that of the parabola, corrected.
    pub fn root_by_derivatives(&self, second: f64, third: f64) -> f64 {
        let slope = (self.slope * self.slope - 2.0 * self.value * second).sqrt();
        let long = -2.0 * self.value / (self.slope + slope);
        self.tau + long - third * long * long * long / (6.0 * slope)
    }
}
