//! Output error of a hypothesis on records, as a least-squares problem.
//!
//! ```text
//! y = δ(θ) + Σ b_j c_j(t) + e,    cost ½ Σ_records Σ_n (w[n] / σ)²,   w the whitened e
//! ```
//!
//! The factors b of the measurement terms (bias and drift, a sinusoid) are free in every record and solved for exactly; the search is
//! over θ.
//! Derivatives are finite differences, since the error of the simulator is far below them, or follow from laws of similarity.

use std::sync::Arc;

use super::{
    jacobian::{Jacobian, Positions, SimulationCache},
    similarity::needs_rate,
    space::Space,
    trace::{Simulated, Trace},
};
use crate::{
    estimate::noise::Noise,
    least_squares::{Expansion, Problem},
    linear_least_squares::{dot, solve, subtract},
    parallel,
};
use actuator_fmu::parameters::Model;

/// A hypothesis on records, with the current estimate of their noise.
pub struct OutputError<'a> {
    /// Maps parameter vectors to models.
    pub space: &'a Space,
    /// The records.
    pub traces: &'a [Trace<'a>],
    /// Their noise.
    pub noise: &'a [Noise],
    /// ∂(simulated)/∂x of each record for the parameters of the base, from a similar model: accurate enough for the first steps of a search.
    pub base_sensitivities: Option<&'a BaseSensitivities>,
    /// Whether a search ends before the step that would lower the cost by less than the tolerance.
    pub ends_early: bool,
    /// The latest simulations.
    pub cache: &'a SimulationCache,
}

/// Sensitivities of each record to the parameters of the base, which are the first of every vector.
pub type BaseSensitivities = Vec<Vec<Vec<f64>>>;

/// The residual of one record at one θ.
pub struct RecordResidual {
    /// Measured minus simulated position and terms, after the settling time [deg].
    pub residual: Vec<f64>,
    /// Factors of the terms.
    pub factors: Vec<f64>,
}

impl<'a> OutputError<'a> {
    /// For a search to its end, with all derivatives by differences.
    pub fn new(space: &'a Space, traces: &'a [Trace<'a>], noise: &'a [Noise], cache: &'a SimulationCache) -> Self {
        Self { space, traces, noise, base_sensitivities: None, ends_early: false, cache }
    }
}

impl OutputError<'_> {
    /// The residual of each record; none where the motion diverges.
    pub fn record_residuals(&self, x: &[f64]) -> Option<Vec<RecordResidual>> {
        let simulated = self.simulated(x)?;
        let each = simulated.iter().enumerate();
        Some(each.map(|(index, simulated)| self.record_residual(x, index, &simulated.position)).collect())
    }

    /// As above, not whitened, where the sum of their squares is below a limit; records are simulated one after another, and no further ones once it
    /// is reached.
    pub fn record_residuals_below(&self, limit: f64, x: &[f64]) -> Option<Vec<RecordResidual>> {
        let model = self.space.model(x)?;
        let mut square = 0.0;
        let mut found = Vec::new();
        for index in 0..self.traces.len() {
            let record = self.record_residual(x, index, &self.simulated_below(limit - square, index, &model)?.position);
            square += dot(&record.residual, &record.residual);
            if square.is_nan() || square >= limit {
                return None;
            }
            found.push(record);
        }
        Some(found)
    }

    fn record_residual(&self, x: &[f64], index: usize, simulated: &[f64]) -> RecordResidual {
        let difference = self.difference(index, simulated);
        let columns = self.columns(x, index);
        if columns.is_empty() {
            return RecordResidual { residual: difference, factors: Vec::new() };
        }
        let white: Vec<Vec<f64>> = columns.iter().map(|column| self.white(column.clone(), index)).collect();
        let factors = solve(&white, &self.white(difference.clone(), index));
        let mut residual = difference;
        subtract(&mut residual, &columns, &factors);
        RecordResidual { residual, factors }
    }

    fn difference(&self, index: usize, simulated: &[f64]) -> Vec<f64> {
        let trace = &self.traces[index];
        let measured = &trace.record.position()[trace.settling..];
        let left = measured.iter().zip(&simulated[trace.settling..]).map(|(measured, simulated)| measured - simulated);
        trace.where_measured(left.collect())
    }

    /// Columns of the terms over the evaluated samples; for a sensor that slipped also a step, since its size shows only beside a model.
    fn columns(&self, x: &[f64], index: usize) -> Vec<Vec<f64>> {
        let trace = &self.traces[index];
        let time = trace.record.time();
        let columns = self.space.columns(x, time, trace.begins_in_motion()).into_iter();
        let columns = columns.map(|column| column[trace.settling..].to_vec());
        columns.chain(trace.slip()).map(|column| trace.where_measured(column)).collect()
    }

    /// Whitened columns of the terms of a record.
    pub fn whitened_columns(&self, x: &[f64], index: usize) -> Vec<Vec<f64>> {
        self.columns(x, index).into_iter().map(|column| self.white(column, index)).collect()
    }

    /// Whitened, in units of the noise.
    fn white(&self, column: Vec<f64>, index: usize) -> Vec<f64> {
        white(&self.noise[index], column)
    }

    /// ½ Σ w² of a record's whitened residual w, and w.
    fn whitened(&self, x: &[f64], index: usize, simulated: &[f64]) -> (f64, Vec<f64>) {
        let white = self.white(self.record_residual(x, index, simulated).residual, index);
        (0.5 * dot(&white, &white), white)
    }

    /// Whitened ∂(simulated + terms)/∂x of every record, without the part that the terms explain.
    pub fn sensitivities(&self, x: &[f64], simulated: &Arc<Positions>) -> Vec<Vec<Vec<f64>>> {
        self.whitened_sensitivities(&self.jacobian(x, simulated))
    }

    fn whitened_sensitivities(&self, jacobian: &Jacobian) -> Vec<Vec<Vec<f64>>> {
        let whitened = |index: usize| -> Vec<Vec<f64>> {
            let terms = self.whitened_columns(&jacobian.x, index);
            let each = (0..jacobian.columns[index].len()).map(|place| {
                let mut column = self.whitened_sensitivity(jacobian, index, place);
                let factors = solve(&terms, &column);
                subtract(&mut column, &terms, &factors);
                column
            });
            each.collect()
        };
        parallel::indexed(jacobian.columns.len(), whitened)
    }

    /// Sensitivity to one parameter in one record, with the part that the terms explain.
    pub fn whitened_sensitivity(&self, jacobian: &Jacobian, index: usize, place: usize) -> Vec<f64> {
        let column = if self.space.changes_motion(place) {
            self.traces[index].where_measured(jacobian.columns[index][place].clone())
        } else {
            self.sensitivity_of_terms(&jacobian.x, index, place, &jacobian.simulated[index].position)
        };
        self.white(column, index)
    }

    /// Sensitivity to a parameter on which only the measurement terms depend.
    fn sensitivity_of_terms(&self, x: &[f64], index: usize, place: usize, simulated: &[f64]) -> Vec<f64> {
        let (step, moved) = self.moved(x, place);
        let factors = self.record_residual(x, index, simulated).factors;
        let (here, there) = (self.columns(x, index), self.columns(&moved, index));
        let mut column = vec![0.0; simulated.len() - self.traces[index].settling];
        for ((here, there), factor) in here.iter().zip(&there).zip(&factors) {
            let change = there.iter().zip(here).map(|(there, here)| factor * (there - here) / step);
            column.iter_mut().zip(change).for_each(|(value, change)| *value += change);
        }
        column
    }

    fn expansion(&self, x: &[f64], simulated: &Positions, jacobian: &Jacobian) -> Expansion {
        let mut sum = Expansion { cost: 0.0, ..Expansion::infeasible(x.len()) };
        for (index, columns) in self.whitened_sensitivities(jacobian).iter().enumerate() {
            let (cost, residual) = self.whitened(x, index, &simulated[index].position);
            sum.cost += cost;
            for (row, column) in columns.iter().enumerate() {
                sum.gradient[row] -= dot(column, &residual);
                for (other, with) in columns.iter().enumerate().take(row + 1) {
                    sum.add_curvature(row, other, dot(column, with));
                }
            }
        }
        sum
    }

    /// Position of each record, without measurement terms; none where the motion diverges.
    pub fn simulated(&self, x: &[f64]) -> Option<Arc<Positions>> {
        if let Some(known) = self.cache.get(x) {
            return Some(known);
        }
        let model = self.space.model(x)?;
        let positions = parallel::map(self.traces, |trace| self.simulate(trace, &model));
        let positions = Arc::new(positions.into_iter().collect::<Option<Positions>>()?);
        self.cache.keep(x, &positions);
        Some(positions)
    }

    fn simulate(&self, trace: &Trace<'_>, model: &Model) -> Option<Simulated> {
        trace.simulated_while(model, needs_rate(self.space, model, trace), |_, _| true)
    }

    /// The motion through a record; none where it diverges, or where the sum of squares of the residual is seen not to be below a limit before it ends:
    /// about their mean, the squares of any samples have a smaller sum than those of all.
    fn simulated_below(&self, limit: f64, index: usize, model: &Model) -> Option<Simulated> {
        let trace = &self.traces[index];
        let is_bound = trace.is_complete() && self.space.frees_only_levels(trace.begins_in_motion());
        let limit = if is_bound && trace.quantiser.is_none() { limit } else { f64::INFINITY };
        let measured = trace.record.position();
        let (mut count, mut sum, mut square) = (0.0, 0.0, 0.0);
        trace.simulated_while(model, needs_rate(self.space, model, trace), |sample, position| {
            if sample < trace.settling {
                return true;
            }
            let difference = measured[sample] - position;
            count += 1.0;
            sum += difference;
            square += difference * difference;
            count * square - sum * sum < count * limit
        })
    }
}

impl Problem for OutputError<'_> {
    fn cost(&self, x: &[f64]) -> f64 {
        self.cost_below(f64::INFINITY, x)
    }

    /// Records are simulated one after another, and no further ones once the limit is reached.
    fn cost_below(&self, limit: f64, x: &[f64]) -> f64 {
        let Some(model) = self.space.model(x) else { return f64::INFINITY };
        let mut cost = 0.0;
        let mut positions = Positions::new();
        for index in 0..self.traces.len() {
            let noise = &self.noise[index];
            let left =
                if noise.is_white() { 2.0 * (limit - cost) * noise.innovation_rms.powi(2) } else { f64::INFINITY };
            let Some(simulated) = self.simulated_below(left, index, &model) else { return f64::INFINITY };
            cost += self.whitened(x, index, &simulated.position).0;
            if cost.is_nan() || cost >= limit {
                return f64::INFINITY;
            }
            positions.push(simulated);
        }
        self.cache.keep(x, &Arc::new(positions));
        cost
    }

    fn expand(&self, x: &[f64]) -> Expansion {
        self.simulated(x).map_or_else(
            || Expansion::infeasible(x.len()),
            |simulated| self.expansion(x, &simulated, &self.jacobian(x, &simulated)),
        )
    }

    /// No derivatives: those at the end of a search are not used.
    fn expand_at_end(&self, x: &[f64], cost: f64) -> Expansion {
        Expansion { cost, ..Expansion::infeasible(x.len()) }
    }

    fn expand_after_step(&self, x: &[f64]) -> Expansion {
        self.simulated(x).map_or_else(
            || Expansion::infeasible(x.len()),
            |simulated| self.expansion(x, &simulated, &self.jacobian_after_step(x, &simulated)),
        )
    }

    fn approximates(&self) -> bool {
        true
    }

    fn ends_before_last_step(&self) -> bool {
        self.ends_early
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        self.space.bounds()
    }
}

/// Whitened, in units of the innovations; samples with too few others before them for the filter are zero.
pub fn white(noise: &Noise, column: Vec<f64>) -> Vec<f64> {
    let count = column.len();
    let mut white = noise.whiten_after(column, count, 0);
    white.iter_mut().for_each(|value| *value /= noise.innovation_rms);
    white
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{fitted::Fitted, hypothesis::Hypothesis},
        generated::TestPoint,
        signal::{
            Interpolation,
            excitation::{Excitation, Kind},
            record::Record,
        },
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Model, table},
    };

    /// The second half of a record without noise, and the model that made it.
    fn in_motion() -> (Model, Record) {
        let mode = find("structural_mode").unwrap();
        let effects = Effects::default().with(mode, &[6.0, 0.01, 0.3]).unwrap();
        let model = Model { effects, ..Model::from_set(&table()[0]) };
        let point = TestPoint {
            model: model.clone(),
            excitation: Excitation { duration_s: 20.0, ..Excitation::new(Kind::Sweep) },
            interpolation: Interpolation::Held,
            noise_share: 0.0,
            turbulence: None,
            seed: 1,
        };
        let whole = point.record("whole").unwrap();
        (model, whole.stretch(whole.len() / 2..whole.len()).unwrap())
    }

    fn left(space: Space, record: &Record) -> f64 {
        let trace = Trace::new(record, space.given());
        Fitted::at_start(space, &[trace]).unwrap().rms()
    }

    fn of(model: &Model) -> Space {
        let hypothesis = Hypothesis { effects: vec!["structural_mode"], ..Hypothesis::default() };
        Space::new(hypothesis, model, &model.base, 0.0)
    }

    #[test]
    fn a_mode_that_rings_as_a_record_begins_leaves_nothing() {
        let (model, record) = in_motion();
        let (ringing, at_rest) = (left(of(&model), &record), left(of(&model).without_levels(), &record));
        assert!(ringing < 1e-4 && at_rest > 0.01, "{ringing} {at_rest}");
    }

    #[test]
    fn a_slip_that_is_roughly_known_leaves_nothing() {
        let (model, record) = in_motion();
        let from = record.len() / 3;
        // 0.1 deg of the slip remain in the positions.
        let slipped = record.without(&[], Some((from, -0.1)));
        assert!(left(of(&model), &slipped) < 1e-4, "{}", left(of(&model), &slipped));
    }
}
