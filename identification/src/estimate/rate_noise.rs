//! Noise whose size depends on the rate of the actuator.
//!
//! The whitened residual w is sorted by the model's rate into classes of equal size, and separate variances v of the classes are compared
//! with a common one by the Bayesian information criterion:
//!
//! ```text
//! N ln v̄ - Σ n ln v - (classes - 1) ln N > 10
//! ```
//!
//! Then each sample is weighted by 1/v of its class: maximum-likelihood estimates for noise of these variances, with correct standard
//! errors (generalised least squares; R. J. Carroll and D. Ruppert, Transformation and Weighting in Regression, 1988). Otherwise nothing
//! changes.

use crate::sorting::sort_by_number;

/// Number of classes of the rate.
const CLASSES: usize = 8;

/// Minimum number of samples of a class: its variance is then known to a seventh.
const FEWEST: usize = 100;

/// Evidence (twice the logarithm of the odds) that counts as strong.
const STRONG: f64 = 10.0;

/// Minimum variance of a class relative to the mean: where there is hardly any noise, small model errors are not amplified.
const LEAST_SHARE: f64 = 1e-3;

/// Noise of each sample relative to the root mean square; `None` if it is constant. `left_out` samples are ignored.
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn sizes(whitened: &[f64], motion: &[f64], left_out: impl Fn(usize) -> bool) -> Option<Vec<f64>> {
    let rate = |n: usize| (motion[(n + 1).min(motion.len() - 1)] - motion[n.saturating_sub(1)]).abs();
    let mut order: Vec<usize> = (0..whitened.len()).filter(|n| !left_out(*n)).collect();
    let samples = order.len();
    if samples < CLASSES * FEWEST {
        return None;
    }
    sort_by_number(&mut order, |n| rate(*n));
    let classes: Vec<&[usize]> = order.chunks(samples.div_ceil(CLASSES)).collect();
    let variance =
        |class: &[usize]| class.iter().map(|n| whitened[*n] * whitened[*n]).sum::<f64>() / class.len() as f64;
    let mean = variance(&order);
    let variances: Vec<f64> = classes.iter().map(|class| variance(class).max(LEAST_SHARE * mean)).collect();
    let apart: f64 = classes.iter().zip(&variances).map(|(class, v)| class.len() as f64 * v.ln()).sum();
    let evidence = samples as f64 * mean.ln() - apart - (classes.len() - 1) as f64 * (samples as f64).ln();
    if evidence.is_nan() || evidence <= STRONG {
        return None;
    }
    let mut sizes = vec![1.0; whitened.len()];
    for (class, variance) in classes.iter().zip(&variances) {
        class.iter().for_each(|n| sizes[*n] = (variance / mean).sqrt());
    }
    Some(sizes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_follow_the_rate_where_the_noise_does() {
        let motion: Vec<f64> = (0..8000).map(|n| (0.01 * f64::from(n)).sin()).collect();
        let even: Vec<f64> = (0..8000).map(|n| (f64::from(n) * 0.754_877_666).fract() - 0.5).collect();
        assert_eq!(sizes(&even, &motion, |_| false), None);
        let grown: Vec<f64> =
            even.iter().zip(0..).map(|(w, n)| w * (0.2 + (0.01 * f64::from(n)).cos().abs())).collect();
        let sizes = sizes(&grown, &motion, |_| false).unwrap();
        // At rest at n = 157, fastest at n = 314.
        assert!(sizes[157] < 0.5 && sizes[314] > 1.2, "{} {}", sizes[157], sizes[314]);
    }
}
