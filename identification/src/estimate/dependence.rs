//! Whether the residual of records still depends on the motion: a score test.
//!
//! Under noise alone the whitened residual w is independent of any function f of command and motion. The functions here are typical errors
//! of actuator models: earlier commands, rate and acceleration (another linear part), powers (gains), signs (friction and play), each
//! whitened and orthogonalised to what the parameters can explain. Sums of f w over blocks of a record give
//!
//! ```text
//! T² = n m' S⁻¹ m,   m mean and S covariance of n blocks
//! ```
//!
//! whose distribution requires neither white noise nor noise of constant variance (H. Hotelling, Ann. Math. Stat. 2, 1931; W. K. Newey,
//! Econometrica 53, 1985).

use nalgebra::{DMatrix, DVector};

use crate::linear_least_squares::{dot, solve, subtract};

/// T² over its degrees of freedom that noise alone exceeds in one of some ten thousand records.
const GREATEST: f64 = 3.5;

/// Number of blocks of all records together.
const BLOCKS: usize = 256;

/// A function with a smaller remainder than this is explained by the parameters.
const EXPLAINED: f64 = 1e-6;

/// Earlier commands, in samples.
const LAGS: [usize; 5] = [0, 2, 5, 10, 20];

/// One record.
pub struct Remainder<'a> {
    /// Command.
    pub command: &'a [f64],
    /// Modelled position.
    pub motion: &'a [f64],
    /// Whitened residual.
    pub whitened: Vec<f64>,
    /// Columns that the parameters, the start and the offset can explain.
    pub explained: Vec<Vec<f64>>,
}

/// Functions of command and motion.
fn functions(command: &[f64], motion: &[f64]) -> Vec<Vec<f64>> {
    let count = motion.len();
    let at = |values: &[f64], n: usize| values[n.min(count - 1)];
    let rate: Vec<f64> = (0..count).map(|n| at(motion, n + 1) - motion[n.saturating_sub(1)]).collect();
    let bend: Vec<f64> =
        (0..count).map(|n| at(motion, n + 1) - 2.0 * motion[n] + motion[n.saturating_sub(1)]).collect();
    let mut functions: Vec<Vec<f64>> =
        LAGS.iter().map(|lag| (0..count).map(|n| command[n.saturating_sub(*lag)]).collect()).collect();
    let of =
        |values: &[f64], function: fn(f64) -> f64| values.iter().map(|value| function(*value)).collect::<Vec<f64>>();
    functions.extend([
        of(motion, f64::abs),
        of(motion, |x| x * x * x),
        of(&rate, |v| v),
        of(&rate, f64::abs),
        of(&rate, |v| if v == 0.0 { 0.0 } else { v.signum() }),
        of(&rate, |v| v * v * v),
        of(&bend, |a| a),
        of(&bend, |a| if a == 0.0 { 0.0 } else { a.signum() }),
    ]);
    functions
}

/// Whether it does. `whiten` applies the filter of a record's residual to a function.
#[allow(clippy::cast_precision_loss)] // counts of blocks
pub fn depends_on_motion(remainders: &[Remainder<'_>], whiten: impl Fn(Vec<f64>, usize) -> Vec<f64>) -> bool {
    let mut blocks: Vec<DVector<f64>> = Vec::new();
    for (index, remainder) in remainders.iter().enumerate() {
        let columns: Vec<Vec<f64>> = functions(remainder.command, remainder.motion)
            .into_iter()
            .map(|function| {
                let mut column = whiten(function, index);
                let whole = dot(&column, &column).sqrt();
                let factors = solve(&remainder.explained, &column);
                subtract(&mut column, &remainder.explained, &factors);
                let length = dot(&column, &column).sqrt();
                let scale = if length > EXPLAINED * whole { 1.0 / length } else { 0.0 };
                column.iter_mut().for_each(|value| *value *= scale);
                column
            })
            .collect();
        let length = remainder.whitened.len().div_ceil((BLOCKS / remainders.len()).max(1));
        for first in (0..remainder.whitened.len()).step_by(length) {
            let block = first..(first + length).min(remainder.whitened.len());
            let sum = |column: &Vec<f64>| dot(&column[block.clone()], &remainder.whitened[block.clone()]);
            blocks.push(DVector::from_iterator(columns.len(), columns.iter().map(sum)));
        }
    }
    let (count, size) = (blocks.len() as f64, blocks.first().map_or(0, DVector::len));
    if count < 4.0 * size as f64 {
        return false;
    }
    let mean = blocks.iter().sum::<DVector<f64>>() / count;
    let covariance = blocks.iter().fold(DMatrix::zeros(size, size), |sum, block| {
        let away = block - &mean;
        sum + &away * away.transpose()
    }) / (count - 1.0);
    // Functions explained by the parameters, or collinear with others, are reduced to rounding errors: directions without variance.
    const LEAST: f64 = 1e-6;
    let eigen = covariance.symmetric_eigen();
    let greatest = eigen.eigenvalues.amax();
    let kept = (0..size).filter(|place| eigen.eigenvalues[*place] > LEAST * greatest);
    let (mut statistic, mut freedom) = (0.0, 0.0);
    for place in kept {
        statistic += count * eigen.eigenvectors.column(place).dot(&mean).powi(2) / eigen.eigenvalues[place];
        freedom += 1.0;
    }
    freedom > 0.0 && statistic * (count - freedom) / (count - 1.0) > GREATEST * freedom
}
