//! Derivatives of the simulated positions of a hypothesis: differences, updates by the steps of a search, and what follows from the motion itself.

use std::sync::Arc;

use super::{
    jacobian::{Jacobian, Positions},
    output_error::OutputError,
    similarity::Similarity,
};
use crate::parallel;

/// Step of logarithms and of numbers of the size of one: large relative to rounding, small relative to any curvature.
const STEP: f64 = 1e-5;

impl OutputError<'_> {
    /// Derivatives by differences, unless they are known.
    pub fn jacobian(&self, x: &[f64], simulated: &Arc<Positions>) -> Arc<Jacobian> {
        if let Some(known) = self.cache.jacobian().filter(|known| known.is_exact && known.x == x) {
            return known;
        }
        let similar = self.similarities(x, simulated);
        let places: Vec<(usize, usize)> =
            (0..self.traces.len()).flat_map(|index| (0..x.len()).map(move |place| (index, place))).collect();
        let columns = parallel::map(&places, |(index, place)| {
            let follows = similar.get(*index).is_some_and(|similar| similar.gives(*place));
            if follows { Vec::new() } else { self.sensitivity(x, *index, *place, &simulated[*index].position) }
        });
        let mut columns = columns.into_iter();
        let mut columns: Vec<Vec<Vec<f64>>> =
            (0..self.traces.len()).map(|_| columns.by_ref().take(x.len()).collect()).collect();
        for (index, similar) in similar.iter().enumerate() {
            similar.complete(&mut columns[index], &simulated[index], self.traces[index].settling);
        }
        self.cache.keep_jacobian(Jacobian { x: x.to_vec(), simulated: simulated.clone(), columns, is_exact: true })
    }

    /// Derivatives updated by the step that led to `x`, where those at its start are known.
    pub fn jacobian_after_step(&self, x: &[f64], simulated: &Arc<Positions>) -> Arc<Jacobian> {
        let updated = self.cache.jacobian().and_then(|known| known.after_step(x, simulated));
        updated.map_or_else(|| self.jacobian(x, simulated), |updated| self.cache.keep_jacobian(updated))
    }

    /// What follows without a simulation in each record; nothing where derivatives by the base are known.
    fn similarities(&self, x: &[f64], simulated: &Positions) -> Vec<Similarity> {
        let Some(model) = self.space.model(x).filter(|_| self.base_sensitivities.is_none()) else { return Vec::new() };
        let each = self.traces.iter().zip(simulated);
        each.map(|(trace, simulated)| Similarity::of(self.space, x, &model, trace, simulated)).collect()
    }

    fn sensitivity(&self, x: &[f64], index: usize, place: usize, simulated: &[f64]) -> Vec<f64> {
        let settling = self.traces[index].settling;
        let nothing = || vec![0.0; simulated.len() - settling];
        let known = self.base_sensitivities.and_then(|columns| columns[index].get(place));
        if let Some(known) = known.filter(|_| self.space.hypothesis.base_free) {
            return known.clone();
        }
        if !self.space.changes_motion(place) {
            return nothing();
        }
        let (step, moved) = self.moved(x, place);
        let Some(other) = self.space.model(&moved).and_then(|model| self.traces[index].position(&model)) else {
            return nothing();
        };
        let pairs = other[settling..].iter().zip(&simulated[settling..]);
        pairs.map(|(moved, here)| (moved - here) / step).collect()
    }

    /// A vector with one element moved, inside its range.
    pub fn moved(&self, x: &[f64], place: usize) -> (f64, Vec<f64>) {
        let step = if x[place] + STEP > self.space.bounds()[place][1] { -STEP } else { STEP };
        let mut moved = x.to_vec();
        moved[place] += step;
        (step, moved)
    }
}
