//! Fits of several records of one condition, combined: x = (ln k, ln ω, ln ζ) with the inverse covariances as weights,
//!
//! ```text
//! C = (Σ Cᵢ⁻¹)⁻¹,   x = C Σ Cᵢ⁻¹ xᵢ,   s² = Σ (xᵢ - x)' Cᵢ⁻¹ (xᵢ - x) / (3 (n - 1))
//! ```
//!
//! which for long records is equivalent to fitting them together. s is Birge's ratio: 1 if records differ as their standard errors predict.
//! Above 1 they differ by more (the actuator changed, or the model is wrong), and C is multiplied by s² (R. T. Birge, Phys. Rev. 40, 1932).
//!
//! The unknown part of the lag 1/p makes ω and ζ uncertain in the same way in all records and does not average out. If p is not identified,
//! the stated standard errors are therefore those of one record. Responses hardly depend on it, since ω and ζ compensate the lag; their
//! errors follow from the covariances at one lag, which do average out.

use nalgebra::{Matrix3, Vector3};

use super::summary::{FitSummary, IDENTIFIABLE};
use actuator_fmu::error::{Error, Result};

/// The fits combined, and Birge's ratio. Fits without a covariance have equal weights, and their scatter gives the standard error.
///
/// # Errors
/// No fit; covariances that cannot be inverted.
pub fn combined(fits: &[&FitSummary]) -> Result<(FitSummary, Option<f64>)> {
    let Some(first) = fits.first() else { return Err(Error::new("fits", "none", "one or more")) };
    let stated: Option<Vec<Matrix3<f64>>> =
        fits.iter().map(|fit| fit.covariance_of_all_lags()?.try_inverse()).collect();
    let weights = stated.clone().unwrap_or_else(|| vec![Matrix3::identity(); fits.len()]);
    let total: Matrix3<f64> = weights.iter().sum();
    let covariance = total
        .try_inverse()
        .ok_or_else(|| Error::new("covariance of the fits", "singular", "parameters that the records identify"))?;
    let sum: Vector3<f64> = fits.iter().zip(&weights).map(|(fit, weight)| weight * fit.logarithms()).sum();
    let mean = covariance * sum;
    let squares: f64 = fits
        .iter()
        .zip(&weights)
        .map(|(fit, weight)| {
            let away = fit.logarithms() - mean;
            away.dot(&(weight * away))
        })
        .sum();
    // Three numbers from each record, three degrees of freedom used by the mean.
    let freedom = 3.0 * (fits.len() as f64 - 1.0);
    let birge = (freedom > 0.0).then(|| (squares / freedom).sqrt());
    let excess = birge.unwrap_or(1.0).max(1.0).powi(2);
    let shared = if fits.iter().any(|fit| fit.pole_above.is_some()) { fits.len() as f64 } else { 1.0 };
    let widened = match (&stated, birge) {
        (Some(_), _) => covariance * shared.max(excess),
        (None, Some(birge)) => covariance * birge.powi(2),
        (None, None) => covariance * f64::NAN,
    };
    let at_one_lag: Option<Matrix3<f64>> =
        fits.iter().map(|fit| fit.covariance_at_one_lag()?.try_inverse()).sum::<Option<Matrix3<f64>>>();
    let at_one_lag = at_one_lag.and_then(|total| total.try_inverse()).map_or(widened, |covariance| covariance * excess);
    let mut values = first.values;
    let mut std_errors = [None; 4];
    for (place, index) in IDENTIFIABLE.into_iter().enumerate() {
        values[index] = mean[place].exp().copysign(first.values[index]);
        let error = widened[(place, place)].sqrt() * values[index].abs();
        std_errors[index] = error.is_finite().then_some(error);
    }
    // Each record's bound holds with 95 %; the median is the one most records agree on.
    let mut bounds: Vec<f64> = fits.iter().filter_map(|fit| fit.pole_above).collect();
    bounds.sort_unstable_by(f64::total_cmp);
    let unit = fits[0].unit;
    let squares = fits.iter().map(|fit| Ok(fit.unit.convert(fit.residual_rms, unit)?.powi(2)));
    let squares_mean = squares.sum::<Result<f64>>()? / fits.len() as f64;
    let third = fits.iter().filter(|fit| fit.order == 3).count();
    let unidentified = fits.iter().flat_map(|fit| fit.not_identifiable.clone());
    let summary = FitSummary {
        order: if 2 * third > fits.len() { 3 } else { 2 },
        values,
        std_errors,
        covariance: std_errors[0].map(|_| without_lags(&at_one_lag)),
        pole_above: bounds.get(bounds.len() / 2).copied(),
        delay_s: fits.iter().map(|fit| fit.delay_s).sum::<f64>() / fits.len() as f64,
        converged: fits.iter().all(|fit| fit.converged),
        ending: format!(
            "{} fits combined, {} of them converged",
            fits.len(),
            fits.iter().filter(|fit| fit.converged).count()
        ),
        at_bound: unique(fits.iter().flat_map(|fit| fit.at_bound.clone())),
        not_identifiable: unique(unidentified),
        unit,
        residual_rms: squares_mean.sqrt(),
        notes: Vec::new(),
    };
    Ok((summary, birge.filter(|_| stated.is_some())))
}

fn without_lags(covariance: &Matrix3<f64>) -> [[f64; 5]; 5] {
    let at = |row: usize, column: usize| if row < 3 && column < 3 { covariance[(row, column)] } else { 0.0 };
    std::array::from_fn(|row| std::array::from_fn(|column| at(row, column)))
}

fn unique(texts: impl Iterator<Item = String>) -> Vec<String> {
    texts.fold(Vec::new(), |mut unique, text| {
        if !unique.contains(&text) {
            unique.push(text);
        }
        unique
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use actuator_fmu::parameters::PositionUnit;

    /// With p identified, unless stated otherwise.
    fn fitted(omega: f64, error: f64) -> FitSummary {
        let covariance = without_lags(&Matrix3::new(
            1e-6,
            0.0,
            0.0,
            0.0,
            error * error,
            0.5 * error * 0.01,
            0.0,
            0.5 * error * 0.01,
            1e-4,
        ));
        FitSummary {
            order: 2,
            values: [-1.1, 1e4, omega, 0.6],
            std_errors: [Some(1e-3), None, Some(error * omega), Some(6e-3)],
            covariance: Some(covariance),
            pole_above: None,
            delay_s: 0.0,
            converged: true,
            ending: String::new(),
            at_bound: Vec::new(),
            not_identifiable: Vec::new(),
            unit: PositionUnit::Degree,
            residual_rms: 0.1,
            notes: Vec::new(),
        }
    }

    #[test]
    fn equal_fits_combine_to_themselves_with_errors_that_shrink_as_their_root() {
        let one = fitted(165.0, 0.01);
        let (sum, scatter) = combined(&[&one, &one, &one, &one]).unwrap();
        for (found, expected) in sum.values.iter().zip(one.values) {
            assert!((found / expected - 1.0).abs() < 1e-12);
        }
        assert!((sum.std_errors[2].unwrap() / one.std_errors[2].unwrap() - 0.5).abs() < 1e-9);
        assert!(scatter.unwrap() < 1e-9);
        let unknown = FitSummary { pole_above: Some(1e4), ..one.clone() };
        let (sum, _) = combined(&[&unknown, &unknown, &unknown, &unknown]).unwrap();
        assert!(
            (sum.std_errors[2].unwrap() / one.std_errors[2].unwrap() - 1.0).abs() < 1e-9 && sum.pole_above == Some(1e4)
        );
    }

    #[test]
    fn the_surer_fit_counts_more_and_disagreement_widens_the_errors() {
        // With equal ζ in both, ω alone is weighted with its conditional variances; by symmetry of ρ with 1/σ².
        let (near, far) = (fitted(165.0, 0.001), fitted(180.0, 0.01));
        let (sum, scatter) = combined(&[&near, &far]).unwrap();
        assert!((sum.values[2] - 165.0).abs() < 1.0, "{sum:?}");
        assert!(
            scatter.unwrap() > 3.0 && sum.std_errors[2].unwrap() > 3.0 * 0.001 * 160.0 * 0.9,
            "{scatter:?} {sum:?}"
        );
    }

    #[test]
    fn fits_without_covariance_count_alike() {
        let fits = [150.0, 160.0, 170.0].map(|omega| FitSummary { covariance: None, ..fitted(omega, 0.01) });
        let (sum, scatter) = combined(&fits.each_ref()).unwrap();
        assert!((sum.values[2] - (150.0_f64 * 160.0 * 170.0).cbrt()).abs() < 1e-9 && scatter.is_none());
        assert!(sum.std_errors[2].unwrap() > 1.0);
    }
}
