//! Plain output error: a hypothesis fitted by the mean square of its residual, not whitened, in the unit of the records.
//!
//! ```text
//! min Σ_records Σ_n (y[n] - δ(θ)[n] - b_record)²
//! ```
//!
//! Where a model has another structure than the actuator, the residual is no noise, and a likelihood that whitens it takes any remainder for noise;
//! this cost does not. It is used for searches far from the given model and for everything that is judged on unseen records.

use std::sync::Arc;

use super::{
    hypothesis::Hypothesis,
    jacobian::{Jacobian, SimulationCache},
    output_error::{OutputError, RecordResidual},
    space::Space,
    trace::Trace,
};
use crate::{
    estimate::noise::Noise,
    least_squares::{Ending, minimise_within},
    linear_least_squares::dot,
};
use actuator_fmu::parameters::Model;

/// Relative decrease of the mean square by a step below which a search ends: what is compared differs by hundredths.
const TOLERANCE: f64 = 1e-5;

/// A hypothesis at one θ.
#[derive(Debug, Clone)]
pub struct PlainFit {
    /// Maps parameter vectors to models.
    pub space: Space,
    /// θ
    pub x: Vec<f64>,
    /// The model.
    pub model: Model,
    /// Measured minus simulated position of each record after the settling time, about its level where that is free.
    pub residuals: Vec<Vec<f64>>,
    /// Whether a search converged here.
    pub converged: bool,
}

impl PlainFit {
    /// Searches from the start of the space; none where the motion diverges.
    pub fn search(space: Space, traces: &[Trace<'_>], most_iterations: usize) -> Option<Self> {
        let start = space.start();
        Self::search_from(space, &start, traces, most_iterations)
    }

    /// Searches from a vector.
    pub fn search_from(space: Space, start: &[f64], traces: &[Trace<'_>], most_iterations: usize) -> Option<Self> {
        if start.is_empty() {
            return Self::at(space, Vec::new(), traces);
        }
        Self::searched(space, start, traces, most_iterations, SimulationCache::default())
    }

    /// Searches from the best of the starts of some spaces, since a search ends at the nearest minimum.
    pub fn search_from_nearest(
        spaces: impl Iterator<Item = Space>,
        traces: &[Trace<'_>],
        most_iterations: usize,
    ) -> Option<Self> {
        let nearest = Self::nearest_start(spaces, traces)?;
        Self::search_from(nearest.space, &nearest.x, traces, most_iterations)
    }

    /// Continues the search on some of the records that it was fitted to; `jacobian` is that of all of them.
    pub fn refitted(
        &self,
        jacobian: &Jacobian,
        records: &[usize],
        traces: &[Trace<'_>],
        most_iterations: usize,
    ) -> Option<Self> {
        let cache = SimulationCache::knowing(jacobian.of_records(records));
        let traces: Vec<Trace<'_>> = records.iter().map(|record| traces[*record].clone()).collect();
        Self::searched(self.space.clone(), &self.x, &traces, most_iterations, cache)
    }

    fn searched(
        space: Space,
        start: &[f64],
        traces: &[Trace<'_>],
        most_iterations: usize,
        cache: SimulationCache,
    ) -> Option<Self> {
        traces.first().into_iter().for_each(Trace::begin_search);
        let minimum =
            with_problem(&space, traces, &cache, |problem| minimise_within(problem, start, TOLERANCE, most_iterations));
        let fit = Self::evaluated(space, minimum.x, traces, &cache)?;
        Some(Self { converged: minimum.ending != Ending::Stopped, ..fit })
    }

    /// Derivatives of the simulated positions.
    pub fn jacobian(&self, traces: &[Trace<'_>]) -> Option<Arc<Jacobian>> {
        with_problem(&self.space, traces, &SimulationCache::default(), |problem| {
            Some(problem.jacobian(&self.x, &problem.simulated(&self.x)?))
        })
    }

    /// Without a search.
    pub fn at(space: Space, x: Vec<f64>, traces: &[Trace<'_>]) -> Option<Self> {
        Self::evaluated(space, x, traces, &SimulationCache::default())
    }

    /// Without a search, at the start of the space.
    pub fn at_start(space: Space, traces: &[Trace<'_>]) -> Option<Self> {
        let start = space.start();
        Self::at(space, start, traces)
    }

    /// The best of the starts of some spaces. All but the best are simulated only until they are worse.
    pub fn nearest_start(spaces: impl Iterator<Item = Space>, traces: &[Trace<'_>]) -> Option<Self> {
        let mut least = f64::INFINITY;
        let mut nearest = None;
        for space in spaces {
            let x = space.start();
            let cache = SimulationCache::default();
            let found = with_problem(&space, traces, &cache, |problem| problem.record_residuals_below(least, &x));
            if let Some(found) = found.and_then(|residuals| Self::with_residuals(space, x, residuals)) {
                least = found.residuals.iter().map(|residual| dot(residual, residual)).sum();
                nearest = Some(found);
            }
        }
        nearest
    }

    fn evaluated(space: Space, x: Vec<f64>, traces: &[Trace<'_>], cache: &SimulationCache) -> Option<Self> {
        let residuals = with_problem(&space, traces, cache, |problem| problem.record_residuals(&x))?;
        Self::with_residuals(space, x, residuals)
    }

    fn with_residuals(space: Space, x: Vec<f64>, residuals: Vec<RecordResidual>) -> Option<Self> {
        let residuals: Vec<Vec<f64>> = residuals.into_iter().map(|record| record.residual).collect();
        let finite = residuals.iter().flatten().all(|value| value.is_finite());
        let model = space.model(&x).filter(|_| finite)?;
        let converged = x.is_empty();
        Some(Self { space, x, model, residuals, converged })
    }

    /// A model with nothing free, levels of the records left in the residuals, as for its FMU; none where the motion diverges.
    pub fn as_it_is(model: &Model, traces: &[Trace<'_>]) -> Option<Self> {
        Self::at(Space::new(Hypothesis::default(), model, &model.base, 0.0), Vec::new(), traces)
    }

    /// The same about the levels.
    pub fn beside_levels(model: &Model, traces: &[Trace<'_>]) -> Option<Self> {
        let with_levels = Hypothesis { wide: true, ..Hypothesis::default() };
        Self::at(Space::new(with_levels, model, &model.base, 0.0), Vec::new(), traces)
    }

    /// The same θ on other records.
    pub fn on(&self, traces: &[Trace<'_>]) -> Option<Self> {
        Self::at(self.space.clone(), self.x.clone(), traces)
    }

    /// Mean square of the residual of each record.
    pub fn mean_squares(&self) -> Vec<f64> {
        self.residuals.iter().map(|residual| mean_square(residual)).collect()
    }

    /// Mean square of all residuals together.
    #[allow(clippy::cast_precision_loss)] // counts of samples
    pub fn mean_square(&self) -> f64 {
        let count: usize = self.residuals.iter().map(Vec::len).sum();
        self.residuals.iter().flatten().map(|value| value * value).sum::<f64>() / count.max(1) as f64
    }
}

/// Mean of the squares.
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64
}

fn with_problem<R>(
    space: &Space,
    traces: &[Trace<'_>],
    cache: &SimulationCache,
    use_it: impl FnOnce(&OutputError<'_>) -> R,
) -> R {
    let noise: Vec<Noise> = traces.iter().map(|_| Noise::white(1.0)).collect();
    use_it(&OutputError::new(space, traces, &noise, cache))
}
