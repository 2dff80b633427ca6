//! Sensitivities of all records to the parameters that they share, with their normal equations: what a linear step explains of a residual.

use std::sync::Arc;

use crate::linear_least_squares::{Regression, subtract};

/// Columns by record, parameter and sample.
pub type Columns = Vec<Vec<Vec<f64>>>;

/// Columns and their normal equations.
pub struct Sensitivities {
    columns: Columns,
    regression: Regression<Arc<[f64]>>,
}

/// A least-squares step, and the residual of each record after it.
pub struct LinearStep {
    /// Of each column; of the additional one last.
    pub factors: Vec<f64>,
    /// Residuals minus columns times factors.
    pub left: Vec<Vec<f64>>,
}

impl Sensitivities {
    /// On these columns.
    pub fn new(columns: Columns) -> Self {
        let size = columns.first().map_or(0, Vec::len);
        let joined =
            |place: usize| columns.iter().flat_map(|record: &Vec<Vec<f64>>| record[place].iter().copied()).collect();
        let regression = Regression::new((0..size).map(joined));
        Self { columns, regression }
    }

    /// The columns.
    pub fn into_columns(self) -> Columns {
        self.columns
    }

    /// The step that explains most of the residuals, with an additional column of each record where there is one.
    pub fn step(&self, additional: Option<&[Vec<f64>]>, residuals: &[Vec<f64>]) -> LinearStep {
        let right = residuals.concat();
        let factors = match additional {
            Some(column) => self.regression.clone().and(column.concat().into()).solve(&right),
            None => self.regression.solve(&right),
        };
        let mut left = residuals.to_vec();
        for (index, residual) in left.iter_mut().enumerate() {
            let own = additional.map(|column| &column[index]);
            subtract(residual, self.columns[index].iter().chain(own), &factors);
        }
        LinearStep { factors, left }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear_least_squares::dot;

    #[test]
    fn a_step_leaves_what_is_orthogonal_to_the_columns_of_all_records_together() {
        let wave =
            |frequency: f64, count: u32| -> Vec<f64> { (0..count).map(|n| (frequency * f64::from(n)).sin()).collect() };
        let columns: Columns = [30, 50].iter().map(|count| vec![wave(0.3, *count), wave(0.5, *count)]).collect();
        let additional = [wave(0.7, 30), wave(0.7, 50)];
        let residuals = [wave(0.31, 30), wave(0.68, 50)];
        let sensitivities = Sensitivities::new(columns.clone());
        for additional in [None, Some(additional.as_slice())] {
            let LinearStep { factors, left } = sensitivities.step(additional, &residuals);
            assert_eq!(factors.len(), 2 + usize::from(additional.is_some()));
            let joined = |place: usize| [columns[0][place].clone(), columns[1][place].clone()].concat();
            let all = (0..2).map(joined).chain(additional.map(<[Vec<f64>]>::concat));
            let products: Vec<f64> = all.map(|column| dot(&column, &left.concat())).collect();
            assert!(products.iter().all(|product| product.abs() < 1e-9), "{products:?}");
        }
    }
}
