//! Quasi-Newton minimisation with the BFGS update of the inverse Hessian (Broyden, Fletcher, Goldfarb and Shanno), as used by the report
//! (its reference 12), with its two stopping rules.
//!
//! ```text
//! d = -B g,   x⁺ = x + a d,   s = x⁺ - x,   y = g⁺ - g,   ρ = 1 / y's
//! B⁺ = (I - ρ s y') B (I - ρ y s') + ρ s s'
//! ```
//!
//! The step length a satisfies the strong Wolfe conditions (J. Nocedal and S. Wright, Numerical Optimization, section 3.5), so that y's > 0
//! and B stays positive definite.
//!
//! Our own, since the crate `argmin` has neither the report's rules nor a maximum step, and brings seven crates, one unmaintained.

use nalgebra::{SMatrix, SVector};

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The cost fell below the required minimum.
    SmallCost,
    /// No parameter changed by more than its relative tolerance in one iteration.
    SmallStep,
    /// The line search found no decrease: rounding errors, or a cost that is not finite.
    NoStep,
    /// The maximum number of iterations was reached.
    Iterations,
}

impl Stop {
    /// In words.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::SmallCost => "converged: weighted error below 1e-4",
            Self::SmallStep => "converged: parameters changed by less than 1e-4 of themselves",
            Self::NoStep => "stopped: no lower cost along the search direction",
            Self::Iterations => "stopped after the greatest number of iterations",
        }
    }

    /// Whether one of the report's rules ended it.
    pub fn is_convergence(self) -> bool {
        matches!(self, Self::SmallCost | Self::SmallStep)
    }
}

/// The report's rules.
#[derive(Debug, Clone, Copy)]
pub struct Rules {
    /// ε²_min
    pub least_cost: f64,
    /// (Δθ/θ)_min
    pub least_change: f64,
}

/// End of a search.
#[derive(Debug, Clone)]
pub struct End<const N: usize> {
    /// Parameters.
    pub x: SVector<f64, N>,
    /// Cost there.
    pub cost: f64,
    /// Number of steps.
    pub iterations: usize,
    /// Reason.
    pub stop: Stop,
}

const MOST_ITERATIONS: usize = 200;

/// Searches from x; `evaluate` returns cost and gradient.
pub fn minimise<const N: usize>(
    evaluate: impl Fn(&SVector<f64, N>) -> (f64, SVector<f64, N>),
    start: SVector<f64, N>,
    rules: Rules,
) -> End<N> {
    let mut x = start;
    let (mut cost, mut gradient) = evaluate(&x);
    let mut inverse = SMatrix::<f64, N, N>::identity();
    for iteration in 0..MOST_ITERATIONS {
        let end = |stop| End { x, cost, iterations: iteration, stop };
        if cost <= rules.least_cost {
            return end(Stop::SmallCost);
        }
        let mut direction = -inverse * gradient;
        let falls = direction.dot(&gradient) < 0.0;
        if !falls {
            inverse.fill_with_identity();
            direction = -gradient;
        }
        // The scale is unknown before the first step: start with a length of at most one.
        let first = if iteration == 0 { 1.0_f64.min(1.0 / gradient.abs().sum()) } else { 1.0 };
        // No parameter may be halved in one step: a gain that overshoots zero would not return.
        let longest = direction
            .iter()
            .zip(x.iter())
            .map(|(d, x)| GREATEST_CHANGE * x.abs() / d.abs())
            .fold(f64::INFINITY, f64::min);
        let first = first.min(longest);
        let Some((length, next_cost, next_gradient)) =
            line_search(&evaluate, &x, cost, &gradient, &direction, [first, longest])
        else {
            return end(Stop::NoStep);
        };
        let step = direction * length;
        let change = next_gradient - gradient;
        x += step;
        (cost, gradient) = (next_cost, next_gradient);
        if step.iter().zip(x.iter()).all(|(step, x)| step.abs() < rules.least_change * x.abs()) {
            return End { x, cost, iterations: iteration + 1, stop: Stop::SmallStep };
        }
        let product = change.dot(&step);
        if product > 0.0 {
            let rho = 1.0 / product;
            let left = SMatrix::<f64, N, N>::identity() - step * change.transpose() * rho;
            inverse = left * inverse * left.transpose() + step * step.transpose() * rho;
        }
    }
    End { x, cost, iterations: MOST_ITERATIONS, stop: Stop::Iterations }
}

/// Minimum fraction of the initial decrease that a step must achieve, and maximum remaining fraction of the initial slope.
const SUFFICIENT_DECREASE: f64 = 1e-4;
const CURVATURE_SHARE: f64 = 0.9;

/// Maximum relative change of a parameter in one step.
const GREATEST_CHANGE: f64 = 0.5;

/// Maximum number of halvings and doublings of one line search.
const TRIALS: usize = 60;

/// A length that meets both conditions, with cost and gradient there; or the best one found.
fn line_search<const N: usize>(
    evaluate: &impl Fn(&SVector<f64, N>) -> (f64, SVector<f64, N>),
    x: &SVector<f64, N>,
    cost: f64,
    gradient: &SVector<f64, N>,
    direction: &SVector<f64, N>,
    [first, longest]: [f64; 2],
) -> Option<(f64, f64, SVector<f64, N>)> {
    let slope = gradient.dot(direction);
    let (mut low, mut high): (f64, Option<f64>) = (0.0, None);
    let mut length = first;
    let mut best = None;
    for _ in 0..TRIALS {
        let (here, there) = evaluate(&(x + direction * length));
        if !(here.is_finite() && here <= cost + SUFFICIENT_DECREASE * length * slope) {
            high = Some(length);
        } else {
            let left = there.dot(direction);
            best = Some((length, here, there));
            if left.abs() <= CURVATURE_SHARE * slope.abs() || (left < 0.0 && length >= longest) {
                return best;
            }
            // Still falling: longer; rising: shorter.
            if left < 0.0 { low = length } else { high = Some(length) }
        }
        length = high.map_or((2.0 * length).min(longest), |high| 0.5 * (low + high));
    }
    best
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    #[test]
    fn the_bottom_of_rosenbrocks_valley_is_found() {
        let valley = |x: &Vector2<f64>| {
            let (a, b) = (1.0 - x.x, x.y - x.x * x.x);
            (a * a + 100.0 * b * b, Vector2::new(-2.0 * a - 400.0 * x.x * b, 200.0 * b))
        };
        let rules = Rules { least_cost: 1e-20, least_change: 1e-12 };
        // Parameters keep their sign: a start on the side of the minimum.
        let end = minimise(valley, Vector2::new(0.2, 3.0), rules);
        assert!(end.stop.is_convergence(), "{:?}", end.stop);
        assert!((end.x - Vector2::new(1.0, 1.0)).amax() < 1e-9, "{}", end.x);
    }
}
