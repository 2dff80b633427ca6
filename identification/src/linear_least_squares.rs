//! Linear least squares over columns of samples: inner products, coefficients, residuals.

use std::ops::Deref;

use nalgebra::{DMatrix, DVector};

/// Σ a b over the common length, in independent partial sums, so that additions do not wait for each other. Their number determines the
/// rounding.
pub fn dot_in_lanes<const LANES: usize>(a: &[f64], b: &[f64]) -> f64 {
    let length = a.len().min(b.len());
    let (a, b) = (a[..length].chunks_exact(LANES), b[..length].chunks_exact(LANES));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; LANES];
    for (a, b) in a.zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Σ a b in eight lanes.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    dot_in_lanes::<8>(a, b)
}

/// values - Σ factor column, column by column.
pub fn subtract<'a>(
    values: &mut [f64],
    columns: impl IntoIterator<Item = &'a Vec<f64>>,
    factors: impl IntoIterator<Item = &'a f64>,
) {
    for (column, factor) in columns.into_iter().zip(factors) {
        values.iter_mut().zip(column).for_each(|(value, column)| *value -= factor * column);
    }
}

/// Least-squares coefficients of columns; zero if a column is not finite.
pub fn solve(columns: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    Regression::new(columns.iter().map(Vec::as_slice)).solve(right)
}

/// Columns with their normal equations, for several right-hand sides.
#[derive(Clone)]
pub struct Regression<C> {
    columns: Vec<C>,
    scales: Vec<f64>,
    /// Inner products of the normalised columns, the lower triangle row by row.
    normal: Vec<f64>,
}

impl<C: Deref<Target = [f64]>> Regression<C> {
    /// On these columns.
    pub fn new(columns: impl Iterator<Item = C>) -> Self {
        columns.fold(Self { columns: Vec::new(), scales: Vec::new(), normal: Vec::new() }, Self::and)
    }

    /// On one more column.
    pub fn and(mut self, column: C) -> Self {
        // Columns are normalised: below the root of this a column is collinear with others.
        const RIDGE: f64 = 1e-12;
        let square = dot(&column, &column);
        let own = if square > 0.0 { square.sqrt() } else { 1.0 };
        for (other, scale) in self.columns.iter().zip(&self.scales) {
            self.normal.push(dot(&column, other) / (own * scale));
        }
        self.normal.push(square / (own * own) + RIDGE);
        self.columns.push(column);
        self.scales.push(own);
        self
    }

    /// Least-squares coefficients; zero if a column is not finite.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let size = self.columns.len();
        let mut normal = DMatrix::zeros(size, size);
        let mut products = self.normal.iter();
        for row in 0..size {
            for (column, product) in products.by_ref().take(row + 1).enumerate() {
                (normal[(row, column)], normal[(column, row)]) = (*product, *product);
            }
        }
        let products = self.columns.iter().zip(&self.scales).map(|(column, scale)| dot(column, right) / scale);
        let products = DVector::from_iterator(size, products);
        let factors = normal.cholesky().map_or_else(|| DVector::zeros(size), |factor| factor.solve(&products));
        let sound = factors.iter().all(|factor| factor.is_finite());
        factors.iter().zip(&self.scales).map(|(factor, scale)| if sound { factor / scale } else { 0.0 }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_of_columns_leave_a_residual_that_is_orthogonal_to_them() {
        let columns: Vec<Vec<f64>> =
            [0.3, 0.7].iter().map(|f| (0..50).map(|n| (f * f64::from(n)).sin()).collect()).collect();
        let mut values: Vec<f64> = (0..50).map(|n| (0.01 * f64::from(n)).exp()).collect();
        let factors = solve(&columns, &values);
        subtract(&mut values, &columns, &factors);
        assert!(columns.iter().all(|column| dot(column, &values).abs() < 1e-9));
    }

    #[test]
    fn lanes_change_the_rounding_of_an_inner_product_only() {
        let values: Vec<f64> = (0..43).map(|n| f64::from(n).cos()).collect();
        let plain: f64 = values.iter().zip(&values[2..]).map(|(a, b)| a * b).sum();
        for sum in [dot_in_lanes::<4>(&values, &values[2..]), dot_in_lanes::<8>(&values, &values[2..])] {
            assert!((sum - plain).abs() < 1e-12, "{sum} {plain}");
        }
    }
}
