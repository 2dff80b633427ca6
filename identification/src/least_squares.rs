//! Nonlinear least squares with bounds: the Levenberg-Marquardt step for any cost with curvature; independent of actuators.
//!
//! With residual r(x) and J = ∂r/∂x, the cost is ½ r'r, its gradient g = J'r, its curvature A = J'J (Gauss and Newton). A step solves (A +
//! λ diag A) d = -g over the parameters that are not held at a bound; λ decreases when the cost does and increases otherwise (D. W.
//! Marquardt, J. SIAM 11, 1963).

use nalgebra::{DMatrix, DVector};

/// Cost, gradient and curvature at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct Expansion {
    /// ½ r'r
    pub cost: f64,
    /// J'r
    pub gradient: DVector<f64>,
    /// J'J
    pub curvature: DMatrix<f64>,
}

impl Expansion {
    /// At a point without a model: infinite cost, no gradient and no curvature.
    #[must_use]
    pub fn infeasible(size: usize) -> Self {
        Self { cost: f64::INFINITY, gradient: DVector::zeros(size), curvature: DMatrix::zeros(size, size) }
    }

    /// Adds to the element of the symmetric curvature at `row`, `column` and to its mirror image.
    pub fn add_curvature(&mut self, row: usize, column: usize, value: f64) {
        self.curvature[(row, column)] += value;
        if row != column {
            self.curvature[(column, row)] += value;
        }
    }
}

/// The function to minimise.
pub trait Problem {
    /// Cost only; not finite where the model does not exist.
    fn cost(&self, x: &[f64]) -> f64;
    /// Cost, if it is below a limit; otherwise any number that is not.
    fn cost_below(&self, _limit: f64, x: &[f64]) -> f64 {
        self.cost(x)
    }
    /// Cost, gradient and curvature.
    fn expand(&self, x: &[f64]) -> Expansion;
    /// As above after a step to `x` that lowered the cost, using the previous points; exact unless a problem overrides it.
    fn expand_after_step(&self, x: &[f64]) -> Expansion {
        self.expand(x)
    }
    /// As above at the end of a search, where the cost is known; exact unless a problem overrides it.
    fn expand_at_end(&self, x: &[f64], _cost: f64) -> Expansion {
        self.expand(x)
    }
    /// Whether [`Self::expand_after_step`] approximates.
    fn approximates(&self) -> bool {
        false
    }
    /// Whether a search ends before the step that is predicted to lower the cost by less than the tolerance, and not with it.
    fn ends_before_last_step(&self) -> bool {
        false
    }
    /// Minimum and maximum of each parameter.
    fn bounds(&self) -> Vec<[f64; 2]>;
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The next step would lower the cost by less than the tolerance.
    Converged,
    /// No step, however small, lowers the cost: rounding errors dominate.
    Exhausted,
    /// The maximum number of iterations was reached.
    Stopped,
}

impl Ending {
    /// In words.
    #[must_use]
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Converged => "converged: a further step would change nothing",
            Self::Exhausted => "converged to rounding errors",
            Self::Stopped => "stopped after the greatest number of iterations; not converged",
        }
    }

    /// Whether the result is a minimum.
    #[must_use]
    pub fn is_minimum(self) -> bool {
        self != Self::Stopped
    }
}

/// End of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// Parameters.
    pub x: Vec<f64>,
    /// Cost, gradient and curvature there.
    pub at: Expansion,
    /// How it ended.
    pub ending: Ending,
    /// Number of steps.
    pub iterations: usize,
    /// Parameters at a bound.
    pub at_bound: Vec<bool>,
}

/// Far more than the ten or so of a well-posed search.
pub const MOST_ITERATIONS: usize = 100;

/// Tolerance: the search ends when a step is predicted to lower the cost by less than this fraction. The cost of N samples is ½ N σ² and
/// one standard error costs ½ σ²: with N = 15 000 the fraction is that of a few thousandths of a standard error.
pub const TIGHT_TOLERANCE: f64 = 1e-9;

/// As above for preliminary searches: a tenth of a standard error.
pub const LOOSE_TOLERANCE: f64 = 1e-6;

const FIRST_DAMPING: f64 = 1e-3;
const LEAST_DAMPING: f64 = 1e-12;
const GREATEST_DAMPING: f64 = 1e10;

/// A step with at least this fraction of the predicted decrease shows that the derivatives are accurate enough for the next.
const LEAST_GAIN_RATIO: f64 = 0.5;

/// Searches from a start, first moved inside the bounds, until a step lowers the cost by less than a fraction of it.
pub fn minimise(problem: &impl Problem, start: &[f64], share: f64) -> Minimum {
    minimise_within(problem, start, share, MOST_ITERATIONS)
}

/// As above, limited to fewer iterations.
pub fn minimise_within(problem: &impl Problem, start: &[f64], share: f64, most_iterations: usize) -> Minimum {
    let bounds = problem.bounds();
    let inside = |x: &[f64]| -> Vec<f64> {
        x.iter().zip(&bounds).map(|(value, [least, greatest])| value.clamp(*least, *greatest)).collect()
    };
    let mut x = inside(start);
    let mut at = problem.expand(&x);
    let mut damping = FIRST_DAMPING;
    let mut ending = Ending::Stopped;
    let mut iterations = 0;
    let mut is_exact = true;
    // If approximate derivatives end a search, convergence is confirmed with exact ones.
    'search: while iterations < most_iterations {
        iterations += 1;
        let free = free(&x, &at.gradient, &bounds);
        loop {
            let Some(step) = damped_step(&at, &free, damping) else {
                ending = Ending::Converged;
                break 'search;
            };
            let moved: Vec<f64> = x.iter().zip(step.iter()).map(|(value, step)| value + step).collect();
            let trial = inside(&moved);
            let taken = DVector::from_iterator(x.len(), trial.iter().zip(&x).map(|(new, old)| new - old));
            let predicted = -(at.gradient.dot(&taken) + 0.5 * taken.dot(&(&at.curvature * &taken)));
            if problem.ends_before_last_step() && predicted.abs() < share * at.cost {
                if is_exact {
                    ending = Ending::Converged;
                    break 'search;
                }
                at = problem.expand(&x);
                is_exact = true;
                break;
            }
            let cost = problem.cost_below(at.cost, &trial);
            if cost < at.cost {
                x = trial;
                let is_last = predicted < share * cost;
                if is_last && is_exact {
                    at = problem.expand_at_end(&x, cost);
                    ending = Ending::Converged;
                    break 'search;
                }
                let is_good = at.cost - cost > LEAST_GAIN_RATIO * predicted;
                is_exact = !problem.approximates() || !is_good || is_last;
                at = if is_exact { problem.expand(&x) } else { problem.expand_after_step(&x) };
                damping = (damping / 10.0).max(LEAST_DAMPING);
                break;
            }
            if !is_exact {
                at = problem.expand(&x);
                is_exact = true;
                break;
            }
            if predicted.abs() < share * at.cost {
                ending = Ending::Converged;
                break 'search;
            }
            damping *= 10.0;
            if damping > GREATEST_DAMPING {
                ending = Ending::Exhausted;
                break 'search;
            }
        }
    }
    let at_bound = x.iter().zip(&bounds).map(|(value, bound)| bound.contains(value)).collect();
    Minimum { x, at, ending, iterations, at_bound }
}

/// Parameters that are not held at a bound.
fn free(x: &[f64], gradient: &DVector<f64>, bounds: &[[f64; 2]]) -> Vec<usize> {
    (0..x.len())
        .filter(|&index| {
            let [least, greatest] = bounds[index];
            !((x[index] <= least && gradient[index] > 0.0) || (x[index] >= greatest && gradient[index] < 0.0))
        })
        .collect()
}

/// The step over the free parameters; `None` if the gradient is zero or the curvature is not a number.
fn damped_step(at: &Expansion, free: &[usize], damping: f64) -> Option<DVector<f64>> {
    let mut curvature = DMatrix::from_fn(free.len(), free.len(), |row, column| at.curvature[(free[row], free[column])]);
    let gradient = DVector::from_iterator(free.len(), free.iter().map(|&index| at.gradient[index]));
    if gradient.iter().all(|value| *value == 0.0) {
        return None;
    }
    let greatest = curvature.diagonal().amax();
    for index in 0..free.len() {
        // A parameter without any influence gets a curvature, so that it does not move.
        curvature[(index, index)] += damping * curvature[(index, index)] + f64::EPSILON * greatest;
    }
    let solution = curvature.cholesky()?.solve(&-gradient);
    let mut step = DVector::zeros(at.gradient.len());
    free.iter().zip(solution.iter()).for_each(|(&index, value)| step[index] = *value);
    step.iter().all(|value| value.is_finite()).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley as least squares: r = (10 (y - x²), 1 - x).
    struct Valley([f64; 2]);

    impl Problem for Valley {
        fn cost(&self, x: &[f64]) -> f64 {
            self.expand(x).cost
        }

        fn expand(&self, x: &[f64]) -> Expansion {
            let r = DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
            let j = DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0]);
            Expansion { cost: 0.5 * r.dot(&r), gradient: j.transpose() * &r, curvature: j.transpose() * &j }
        }

        fn bounds(&self) -> Vec<[f64; 2]> {
            vec![[-5.0, self.0[0]], [-5.0, self.0[1]]]
        }
    }

    #[test]
    fn the_bottom_of_a_valley_is_found() {
        let minimum = minimise(&Valley([5.0, 5.0]), &[-1.2, 1.0], TIGHT_TOLERANCE);
        assert!(minimum.ending.is_minimum() && minimum.iterations < 50);
        assert!((minimum.x[0] - 1.0).abs() < 1e-12 && (minimum.x[1] - 1.0).abs() < 1e-12);
        assert_eq!(minimum.at_bound, [false, false]);
    }

    #[test]
    fn a_bound_is_kept_and_named() {
        // With x <= 0.5 the minimum is at x = 0.5, y = x².
        let minimum = minimise(&Valley([0.5, 5.0]), &[-1.2, 1.0], TIGHT_TOLERANCE);
        assert_eq!(minimum.at_bound, [true, false]);
        assert!((minimum.x[1] - 0.25).abs() < 1e-9, "{minimum:?}");
    }
}
