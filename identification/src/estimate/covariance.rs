//! Covariance of estimates from the curvature of their cost.

use nalgebra::{DMatrix, DVector};

/// Minimum eigenvalue of a curvature scaled to unit diagonal: below it a direction is determined by rounding errors only.
const LEAST_EIGENVALUE: f64 = 1e-14;

/// The inverse of a curvature, symmetric and positive by construction, so that correlations stay between -1 and 1 and variances positive
/// for any collinearity of the parameters; `None` if the curvature is not finite.
pub fn inverse(curvature: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let size = curvature.nrows();
    let scale = DVector::from_fn(size, |place, _| {
        let length = curvature[(place, place)].sqrt();
        if length > 0.0 { 1.0 / length } else { 1.0 }
    });
    let scaled = DMatrix::from_fn(size, size, |row, column| {
        0.5 * (curvature[(row, column)] + curvature[(column, row)]) * scale[row] * scale[column]
    });
    if !scaled.iter().all(|value| value.is_finite()) {
        return None;
    }
    let eigen = scaled.symmetric_eigen();
    // Columns of V λ^(-1/2), rows scaled: the inverse is this times its transpose.
    let root = DMatrix::from_fn(size, size, |row, column| {
        scale[row] * eigen.eigenvectors[(row, column)] / eigen.eigenvalues[column].max(LEAST_EIGENVALUE).sqrt()
    });
    Some(&root * root.transpose())
}

/// The correlation of two estimates, signed.
pub fn correlation(covariance: &DMatrix<f64>, one: usize, other: usize) -> f64 {
    let scale = covariance[(one, one)].sqrt() * covariance[(other, other)].sqrt();
    // Rounding may exceed one in the last digit.
    if scale > 0.0 { (covariance[(one, other)] / scale).clamp(-1.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_collinear_parameters_have_correlations_of_one_at_most() {
        // An asymmetry of rounding and a negative determinant, as at the end of a search in a flat valley.
        let curvature =
            DMatrix::from_row_slice(3, 3, &[1.0, 1.0 + 1e-12, 0.1, 1.0 - 1e-12, 1.0 - 1e-15, 0.1, 0.1, 0.1, 4.0]);
        let plain: DMatrix<f64> = curvature.clone().try_inverse().unwrap();
        assert!(plain[(0, 0)] * plain[(1, 1)] < plain[(0, 1)].powi(2) || plain[(0, 0)] < 0.0);
        let covariance = inverse(&curvature).unwrap();
        for row in 0..3 {
            assert!(covariance[(row, row)] > 0.0);
            assert!((0..3).all(|column| (-1.0..=1.0).contains(&correlation(&covariance, row, column))));
        }
        assert!(correlation(&covariance, 0, 1) < -0.999);
        assert!(inverse(&(curvature * f64::NAN)).is_none());
    }
}
