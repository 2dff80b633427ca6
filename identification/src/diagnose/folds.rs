//! Linear regressions scored on unused samples, from the normal equations of parts of each record.
//!
//! ```text
//! out-of-sample sum of squares = Σ_parts (s - 2 w·r + w·G w),    w from the normal equations G, r of other parts
//! ```
//!
//! One pass over the samples gives G, r and s of every part; every division into training and test parts is then a small linear system. Columns and
//! targets are centred in each record, which removes its level.

use nalgebra::{DMatrix, DVector};

/// Normal equations of one part of a record.
#[derive(Clone)]
struct Part {
    record: usize,
    gram: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
    samples: f64,
}

/// Normal equations of all parts of all records.
pub struct Folds {
    parts: Vec<Part>,
    records: usize,
    size: usize,
}

/// Parts of a record.
const PARTS: usize = 10;

/// Added to the diagonal, per sample, with columns scaled to an rms of one: keeps the factors of collinear columns from growing. The one with the
/// smallest out-of-sample sum of squares is used: many columns on short records need a large one, few on long ones hardly any.
const RIDGES: [f64; 4] = [1e-6, 1e-4, 1e-2, 0.3];

impl Folds {
    /// Normal equations of the columns and the target of each record.
    #[allow(clippy::cast_precision_loss)] // counts of samples
    pub fn new(columns: &[Vec<Vec<f64>>], targets: &[Vec<f64>]) -> Self {
        let size = columns.first().map_or(0, Vec::len);
        let centred: Vec<Vec<Vec<f64>>> =
            columns.iter().map(|record| record.iter().map(|column| about_mean(column)).collect()).collect();
        let count: usize = targets.iter().map(Vec::len).sum();
        let scales: Vec<f64> = (0..size)
            .map(|place| {
                let square: f64 = centred.iter().flat_map(|record| &record[place]).map(|value| value * value).sum();
                // A column of zeros is not scaled: divided by the smallest number its products would not be finite.
                let scale = (square / count.max(1) as f64).sqrt();
                if scale > f64::MIN_POSITIVE { scale } else { 1.0 }
            })
            .collect();
        let mut parts = Vec::new();
        for (record, (columns, target)) in centred.iter().zip(targets).enumerate() {
            let target = about_mean(target);
            let length = target.len().div_ceil(PARTS).max(1);
            for from in (0..target.len()).step_by(length) {
                let to = (from + length).min(target.len());
                let mut gram = DMatrix::zeros(size, size);
                let mut right = DVector::zeros(size);
                for row in 0..size {
                    for column in 0..=row {
                        let product =
                            crate::linear_least_squares::dot(&columns[row][from..to], &columns[column][from..to])
                                / (scales[row] * scales[column]);
                        (gram[(row, column)], gram[(column, row)]) = (product, product);
                    }
                    right[row] =
                        crate::linear_least_squares::dot(&columns[row][from..to], &target[from..to]) / scales[row];
                }
                let square = target[from..to].iter().map(|value| value * value).sum();
                parts.push(Part { record, gram, right, square, samples: (to - from) as f64 });
            }
        }
        Self { parts, records: targets.len(), size }
    }

    /// Sum of squares of each record.
    pub fn squares(&self) -> Vec<f64> {
        self.of_records(|part| part.square)
    }

    /// Out-of-sample sum of squares of each record, predicted from the others; its sum of squares if it is the only one.
    pub fn left_across_records(&self) -> Vec<f64> {
        if self.records < 2 {
            return self.squares();
        }
        least(|ridge| self.across(ridge))
    }

    fn across(&self, ridge: f64) -> Vec<f64> {
        let left_of = |held: usize| {
            let factors = self.factors(ridge, |part| part.record != held);
            self.parts.iter().filter(|part| part.record == held).map(|part| part.left(&factors)).sum()
        };
        (0..self.records).map(left_of).collect()
    }

    /// Out-of-sample sum of squares of each record, every second part predicted from those between.
    pub fn left_within_records(&self) -> Vec<f64> {
        least(|ridge| self.within(ridge))
    }

    fn within(&self, ridge: f64) -> Vec<f64> {
        let left_of = |record: usize| {
            let own: Vec<&Part> = self.parts.iter().filter(|part| part.record == record).collect();
            let of_half = |parity: usize| {
                let factors = solve(self.size, ridge, own.iter().skip(parity).step_by(2).copied());
                own.iter().skip(1 - parity).step_by(2).map(|part| part.left(&factors)).sum::<f64>()
            };
            of_half(0) + of_half(1)
        };
        (0..self.records).map(left_of).collect()
    }

    fn factors(&self, ridge: f64, teaches: impl Fn(&Part) -> bool) -> DVector<f64> {
        solve(self.size, ridge, self.parts.iter().filter(|part| teaches(part)))
    }

    fn of_records(&self, of: impl Fn(&Part) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.records];
        self.parts.iter().for_each(|part| sums[part.record] += of(part));
        sums
    }
}

impl Part {
    fn left(&self, factors: &DVector<f64>) -> f64 {
        (self.square - 2.0 * factors.dot(&self.right) + factors.dot(&(&self.gram * factors))).max(0.0)
    }
}

/// The result of the ridge with the smallest sum.
fn least(of: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let each = RIDGES.into_iter().map(of);
    each.min_by(|a, b| a.iter().sum::<f64>().total_cmp(&b.iter().sum())).unwrap_or_default()
}

fn solve<'a>(size: usize, ridge: f64, parts: impl Iterator<Item = &'a Part>) -> DVector<f64> {
    let mut gram = DMatrix::zeros(size, size);
    let mut right = DVector::zeros(size);
    let mut samples = 0.0;
    for part in parts {
        gram += &part.gram;
        right += &part.right;
        samples += part.samples;
    }
    for place in 0..size {
        gram[(place, place)] += ridge * samples;
    }
    gram.cholesky().map_or_else(|| DVector::zeros(size), |factor| factor.solve(&right))
}

#[allow(clippy::cast_precision_loss)] // a count of samples
fn about_mean(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|value| value - mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uniform_noise::uniform_noise;

    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut next = uniform_noise(seed);
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn what_columns_carry_is_predicted_on_unseen_samples_and_noise_is_not() {
        let columns: Vec<Vec<Vec<f64>>> =
            (0..2).map(|record| (1..4).map(|seed| noise(10 * record + seed, 2000)).collect()).collect();
        let carried: Vec<Vec<f64>> = columns
            .iter()
            .enumerate()
            .map(|(record, of)| {
                let rest = noise(77 + record as u64, 2000);
                of[0].iter().zip(&of[2]).zip(&rest).map(|((a, b), rest)| a - 0.5 * b + rest + 3.0).collect()
            })
            .collect();
        let unrelated: Vec<Vec<f64>> = (0..2).map(|record| noise(99 + record, 2000)).collect();
        let share = |targets: &[Vec<f64>], left: &dyn Fn(&Folds) -> Vec<f64>| {
            let folds = Folds::new(&columns, targets);
            1.0 - left(&folds).iter().sum::<f64>() / folds.squares().iter().sum::<f64>()
        };
        let across = |folds: &Folds| folds.left_across_records();
        let within = |folds: &Folds| folds.left_within_records();
        // The parts of the target have variances of 1, 0.25 and 1; the last one is noise.
        for left in [&across as &dyn Fn(&Folds) -> Vec<f64>, &within] {
            assert!((share(&carried, left) - 1.25 / 2.25).abs() < 0.03);
            assert!(share(&unrelated, left) < 0.005);
        }
    }
}
