//! The cost of a model on records: output error, with start state and offset of every record free.
//!
//! ```text
//! y = δ(θ, z0) + b + e,    cost ½ Σ_records Σ_n (w[n] / σ)²,   w the whitened e
//! ```
//!
//! δ is linear in the start z0 and the offset b, so that for every θ they are solved for exactly, and the search is over θ = (ln |k|, ln ω,
//! ln ζ, 1/p, T) alone. With r the residual, J = ∂δ/∂θ and Φ = ∂(δ + b)/∂(z0, b), all whitened,
//!
//! ```text
//! gradient -J'r,   curvature J'J - J'Φ (Φ'Φ)⁻¹ Φ'J
//! ```

use nalgebra::{Matrix4, Vector4};

use super::{
    dependence::{Remainder, depends_on_motion},
    layout::{GAINS, GREATEST_LAG_S, LEAST_OMEGA, LN_OMEGA, LN_ZETA, Layout, ZETAS},
    noise::Noise,
    rate_noise,
    simulation::{Simulator, Start},
};
use crate::{
    frequency::DelayedModel,
    least_squares::{Expansion, Problem},
    linear_least_squares::{dot_in_lanes, subtract},
    signal::record::Record,
    spikes::{bridge, spikes},
};
use actuator_fmu::parameters::Order;

/// Records, a layout and the noise of each record.
pub struct OutputError<'a> {
    /// Estimated parameters.
    pub layout: Layout,
    simulators: &'a [(&'a Record, Simulator<'a>)],
    noise: Vec<Noise>,
    /// Excluded samples at the start of each record, which depend on commands from before it.
    excluded: Vec<usize>,
    /// Excluded samples of each record: spikes, and inserted rows.
    spikes: Vec<Vec<usize>>,
    /// Noise of each sample relative to that of its record; `None` if it is constant.
    noise_sizes: Vec<Option<Vec<f64>>>,
}

/// The residual of one record.
pub struct RecordResidual {
    /// Measured minus modelled position; zero where the position depends on commands from before the record.
    pub residual: Vec<f64>,
    /// The offset b.
    pub offset: f64,
}

impl RecordResidual {
    /// Without a model: the measurement itself.
    pub fn all(record: &Record) -> Self {
        Self { residual: record.position().to_vec(), offset: 0.0 }
    }
}

/// One record at one θ, whitened.
struct Whitened {
    /// δ from rest, not whitened.
    modelled: Vec<f64>,
    /// r, with start and offset solved for.
    residual: Vec<f64>,
    /// Φ
    nuisance: Vec<Vec<f64>>,
    /// (Φ'Φ)⁻¹
    inverse: Matrix4<f64>,
    start: Start,
    offset: f64,
}

impl<'a> OutputError<'a> {
    /// With the current estimate of the noise.
    pub fn new(layout: Layout, simulators: &'a [(&'a Record, Simulator<'a>)], noise: Vec<Noise>) -> Self {
        let excluded = simulators
            .iter()
            .map(|(record, _)| samples_before(record, layout.declared_delay_s.unwrap_or(LEAD_IN_S)))
            .collect();
        let count = simulators.len();
        Self { layout, simulators, noise, excluded, spikes: rows_put_in(simulators), noise_sizes: vec![None; count] }
    }

    /// With different noise, and the current estimate of the delay.
    pub fn with_noise(&self, noise: Vec<Noise>, x: &[f64]) -> Self {
        let least = if self.layout.declared_delay_s.is_some() { 0.0 } else { LEAD_IN_S };
        let delay_s = self.layout.model(x).map_or(least, |model| model.delay_s.max(least));
        let excluded = self.simulators.iter().map(|(record, _)| samples_before(record, delay_s)).collect();
        let (spikes, noise_sizes) = (self.spikes.clone(), self.noise_sizes.clone());
        Self { layout: self.layout, simulators: self.simulators, noise, excluded, spikes, noise_sizes }
    }

    /// With different samples excluded.
    pub fn with_spikes(&self, spikes: Vec<Vec<usize>>) -> Self {
        Self { spikes, ..self.with_layout(self.layout) }
    }

    /// With noise that varies from sample to sample.
    pub fn with_noise_sizes(&self, noise_sizes: Vec<Option<Vec<f64>>>) -> Self {
        Self { noise_sizes, ..self.with_layout(self.layout) }
    }

    /// The excluded samples of each record.
    pub fn spikes(&self) -> &[Vec<usize>] {
        &self.spikes
    }

    /// The noise of each record.
    pub fn noise(&self) -> &[Noise] {
        &self.noise
    }

    /// Records with the same noise and another layout.
    pub fn with_layout(&self, layout: Layout) -> Self {
        Self {
            layout,
            simulators: self.simulators,
            noise: self.noise.clone(),
            excluded: self.excluded.clone(),
            spikes: self.spikes.clone(),
            noise_sizes: self.noise_sizes.clone(),
        }
    }

    /// The spikes in the residual of each record at θ.
    pub fn find_spikes(&self, x: &[f64]) -> Vec<Vec<usize>> {
        let whole = self.with_spikes(vec![Vec::new(); self.simulators.len()]);
        let each = whole.residuals(x).into_iter().zip(self.simulators).zip(rows_put_in(self.simulators));
        each.map(|((left, (record, _)), mut left_out)| {
            left_out.extend(spikes(&left.residual, &motion(record, &left.residual), record.position()));
            left_out.sort_unstable();
            left_out.dedup();
            left_out
        })
        .collect()
    }

    /// For rate-dependent noise: its size at each sample, from the whitened residual at θ.
    pub fn find_noise_sizes(&self, x: &[f64]) -> Vec<Option<Vec<f64>>> {
        let even = self.with_noise_sizes(vec![None; self.simulators.len()]);
        let each = even.residuals(x).into_iter().enumerate();
        each.map(|(index, left)| {
            let motion = motion(self.simulators[index].0, &left.residual);
            let whitened = even.white(left.residual, index);
            // Excluded, or accidentally next to zero: such samples give no information on the size.
            rate_noise::sizes(&whitened, &motion, |sample| whitened[sample] == 0.0)
        })
        .collect()
    }

    /// Whether the residual at θ still depends on command and motion.
    pub fn depends_on_motion(&self, x: &[f64]) -> bool {
        let explained = self.projected(x);
        let each = self.residuals(x).into_iter().zip(explained).enumerate();
        let motions: Vec<Vec<f64>> = self
            .residuals(x)
            .iter()
            .zip(self.simulators)
            .map(|(left, (record, _))| motion(record, &left.residual))
            .collect();
        let remainders: Vec<Remainder<'_>> = each
            .map(|(index, (left, mut explained))| {
                let record = self.simulators[index].0;
                explained.push(self.white(vec![1.0; record.len()], index));
                let whitened = self.white(left.residual, index);
                Remainder { command: record.command(), motion: &motions[index], whitened, explained }
            })
            .collect();
        depends_on_motion(&remainders, |column, index| self.white(column, index))
    }

    /// The residual of each record.
    pub fn residuals(&self, x: &[f64]) -> Vec<RecordResidual> {
        let Some(model) = self.layout.model(x) else { return Vec::new() };
        let each = self.simulators.iter().enumerate().map(|(index, (record, simulator))| {
            let Whitened { start, offset, .. } = self.whitened(&model, index);
            let modelled = simulator.position(&model, start);
            let residual = record.position().iter().zip(&modelled).map(|(measured, model)| measured - model - offset);
            let mut residual: Vec<f64> = residual.collect();
            residual[..self.excluded[index]].fill(0.0);
            bridge(&mut residual, &self.spikes[index]);
            RecordResidual { residual, offset }
        });
        each.collect()
    }

    /// Columns J of one record at θ, whitened; for the start and offset found there.
    fn sensitivities(&self, x: &[f64], index: usize, white: &Whitened) -> Vec<Vec<f64>> {
        // Central differences with steps of 1e-6 for logarithms and 0.01 µs for lags, one-sided at zero.
        const LOGARITHM_STEP: f64 = 1e-6;
        const LAG_STEP_S: f64 = 1e-8;
        let (_, simulator) = &self.simulators[index];
        let mut models = Vec::with_capacity(2 * x.len());
        let mut widths = Vec::with_capacity(x.len());
        for place in LN_OMEGA..x.len() {
            let step = if place > LN_ZETA { LAG_STEP_S } else { LOGARITHM_STEP };
            let (mut above, mut below) = (x.to_vec(), x.to_vec());
            above[place] += step;
            below[place] -= step;
            if place > LN_ZETA {
                below[place] = below[place].max(0.0);
            }
            // At the bound of a Base there is no model on one side; the sensitivity is taken as zero.
            if let (Some(above_model), Some(below_model)) = (self.layout.model(&above), self.layout.model(&below)) {
                models.extend([above_model, below_model]);
                widths.push(Some(above[place] - below[place]));
            } else {
                widths.push(None);
            }
        }
        let positions = simulator.positions(&models, white.start);
        let mut pairs = positions.chunks_exact(2);
        // Linear in k, the start at rest included.
        let mut columns = vec![white.modelled.clone()];
        columns.extend(widths.into_iter().map(|width| match (width, width.and_then(|_| pairs.next())) {
            (Some(width), Some([above, below])) => above.iter().zip(below).map(|(a, b)| (a - b) / width).collect(),
            _ => Vec::new(),
        }));
        columns.into_iter().map(|column| self.white(column, index)).collect()
    }

    /// A whitened column without the excluded samples.
    fn white(&self, column: Vec<f64>, index: usize) -> Vec<f64> {
        let (noise, count) = (&self.noise[index], self.simulators[index].0.len());
        let mut white = match self.excluded[index] {
            0 => noise.whiten(column, count),
            excluded => noise.whiten_after(column, count, excluded),
        };
        if let Some(sizes) = &self.noise_sizes[index] {
            white.iter_mut().zip(sizes).for_each(|(value, size)| *value /= size);
        }
        // As if not measured: the filtered response to a spike is excluded with it.
        for spike in &self.spikes[index] {
            let end = (spike + 1 + noise.coefficients.len()).min(white.len());
            white[(*spike).min(end)..end].fill(0.0);
        }
        white
    }

    /// Residual and Φ of a record for a model, start and offset solved for.
    fn whitened(&self, model: &DelayedModel, index: usize) -> Whitened {
        let (record, simulator) = &self.simulators[index];
        let modelled = simulator.position(model, Start::zeros());
        let difference: Vec<f64> =
            record.position().iter().zip(&modelled).map(|(measured, model)| measured - model).collect();
        let mut residual = self.white(difference, index);
        let pole = if model.order == Order::Third { simulator.free(model, 0) } else { Vec::new() };
        let columns = [pole, simulator.free(model, 1), simulator.free(model, 2), vec![1.0; record.len()]];
        let nuisance: Vec<Vec<f64>> = columns.into_iter().map(|column| self.white(column, index)).collect();
        let inverse = pseudo_inverse(&Matrix4::from_fn(|row, column| dot(&nuisance[row], &nuisance[column])));
        let solved = inverse * products(&nuisance, &residual);
        subtract(&mut residual, &nuisance, &solved);
        Whitened {
            modelled,
            residual,
            nuisance,
            inverse,
            start: Start::new(solved[0], solved[1], solved[2]),
            offset: solved[3],
        }
    }

    /// J orthogonalised to Φ, one matrix per record: it determines the information on θ.
    pub fn projected(&self, x: &[f64]) -> Vec<Vec<Vec<f64>>> {
        let Some(model) = self.layout.model(x) else { return Vec::new() };
        (0..self.simulators.len())
            .map(|index| {
                let white = self.whitened(&model, index);
                let mut columns = self.sensitivities(x, index, &white);
                for column in &mut columns {
                    let share = white.inverse * products(&white.nuisance, column);
                    subtract(column, &white.nuisance, &share);
                }
                columns
            })
            .collect()
    }
}

impl Problem for OutputError<'_> {
    fn cost(&self, x: &[f64]) -> f64 {
        let Some(model) = self.layout.model(x) else { return f64::INFINITY };
        let cost = |(index, noise): (usize, &Noise)| {
            let white = self.whitened(&model, index);
            0.5 * dot(&white.residual, &white.residual) / noise.innovation_rms.powi(2)
        };
        self.noise.iter().enumerate().map(cost).sum()
    }

    fn expand(&self, x: &[f64]) -> Expansion {
        let size = x.len();
        let mut sum = Expansion::infeasible(size);
        let Some(model) = self.layout.model(x) else { return sum };
        sum.cost = 0.0;
        for (index, noise) in self.noise.iter().enumerate() {
            let weight = noise.innovation_rms.powi(-2);
            let white = self.whitened(&model, index);
            let columns = self.sensitivities(x, index, &white);
            let nuisance: Vec<Vector4<f64>> = columns.iter().map(|column| products(&white.nuisance, column)).collect();
            sum.cost += 0.5 * weight * dot(&white.residual, &white.residual);
            for row in 0..size {
                sum.gradient[row] -= weight * dot(&columns[row], &white.residual);
                for column in 0..=row {
                    let alone = dot(&columns[row], &columns[column]);
                    let curvature = weight * (alone - nuisance[row].dot(&(white.inverse * nuisance[column])));
                    sum.add_curvature(row, column, curvature);
                }
            }
        }
        sum
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        let omegas = [LEAST_OMEGA, greatest_omega(self.simulators)];
        let mut bounds: Vec<[f64; 2]> = [GAINS, omegas, ZETAS].map(|ends| ends.map(f64::ln)).to_vec();
        bounds.resize(self.layout.len(), [0.0, GREATEST_LAG_S]);
        bounds
    }
}

/// Maximum ω that is distinguishable from its alias about half the sampling rate [rad/s].
pub fn greatest_omega(simulators: &[(&Record, Simulator<'_>)]) -> f64 {
    let intervals = simulators.iter().map(|(record, _)| record.sampling().interval_s());
    std::f64::consts::PI / intervals.fold(f64::INFINITY, f64::min)
}

/// The modelled position, up to the offset, from the residual.
fn motion(record: &Record, residual: &[f64]) -> Vec<f64> {
    record.position().iter().zip(residual).map(|(measured, left)| measured - left).collect()
}

/// Σ a b. Four lanes: a different number changes the rounding.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    dot_in_lanes::<4>(a, b)
}

fn products(nuisance: &[Vec<f64>], column: &[f64]) -> Vector4<f64> {
    Vector4::from_fn(|row, _| dot(&nuisance[row], column))
}

/// Excluded start of each record while a delay is estimated [s]: far above any delay of an actuator.
const LEAD_IN_S: f64 = 0.1;

/// Samples of a record before the effect of its first command.
fn samples_before(record: &Record, delay_s: f64) -> usize {
    let first = record.time()[0] + delay_s;
    // A delay of whole samples arrives at one of them.
    record.time().iter().take_while(|time| **time < first - f64::EPSILON * first.abs()).count().min(record.len() / 2)
}

/// Inverse of a Gram matrix, without directions that are not excited: a column close to zero (the start of a fast pole; a second-order
/// model has none), and collinear columns.
fn pseudo_inverse(gram: &Matrix4<f64>) -> Matrix4<f64> {
    // For normalised columns; a smaller eigenvalue is known to fewer than 5 digits in doubles.
    const LEAST: f64 = 1e-10;
    // A pole start error of 1 deg with less than a thousandth of the effect of a position start error of 1 deg.
    const NEXT_TO_NOTHING: f64 = 1e-3;
    let least = NEXT_TO_NOTHING * gram[(1, 1)].sqrt();
    let scale = Vector4::from_fn(|index, _| {
        let length = gram[(index, index)].sqrt();
        if length > 0.0 && (index > 0 || length > least) { 1.0 / length } else { 0.0 }
    });
    let scaled = Matrix4::from_fn(|row, column| gram[(row, column)] * scale[row] * scale[column]);
    let eigen = scaled.symmetric_eigen();
    let inverted = eigen.eigenvalues.map(|value| if value > LEAST { 1.0 / value } else { 0.0 });
    let inverse = eigen.eigenvectors * Matrix4::from_diagonal(&inverted) * eigen.eigenvectors.transpose();
    Matrix4::from_fn(|row, column| inverse[(row, column)] * scale[row] * scale[column])
}

/// Samples of each record without a measured position.
fn rows_put_in(simulators: &[(&Record, Simulator<'_>)]) -> Vec<Vec<usize>> {
    let each = simulators.iter();
    each.map(|(record, _)| (0..record.len()).filter(|sample| !record.is_measured(*sample)).collect()).collect()
}
