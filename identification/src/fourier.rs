//! Plans of Fourier transforms, kept by each thread: a plan costs as much as some transforms of its length.

use std::{cell::RefCell, sync::Arc};

use rustfft::{Fft, FftPlanner};

/// Longest transform whose plan is kept: a plan holds a few numbers for each sample.
const LONGEST_KEPT: usize = 1 << 17;

thread_local! {
    static PLANNER: RefCell<FftPlanner<f64>> = RefCell::new(FftPlanner::new());
}

/// The transform Σ x[n] exp(-2πi n m / N).
pub fn forward(length: usize) -> Arc<dyn Fft<f64>> {
    planned(length, FftPlanner::plan_fft_forward)
}

/// The transform Σ X[m] exp(2πi n m / N), without the factor 1/N.
pub fn inverse(length: usize) -> Arc<dyn Fft<f64>> {
    planned(length, FftPlanner::plan_fft_inverse)
}

fn planned(length: usize, plan: fn(&mut FftPlanner<f64>, usize) -> Arc<dyn Fft<f64>>) -> Arc<dyn Fft<f64>> {
    if length > LONGEST_KEPT {
        return plan(&mut FftPlanner::new(), length);
    }
    PLANNER.with_borrow_mut(|planner| plan(planner, length))
}

#[cfg(test)]
mod tests {
    use rustfft::num_complex::Complex;

    use super::*;

    #[test]
    fn the_inverse_undoes_the_transform_with_a_kept_plan_and_without() {
        for length in [7_usize, 16, LONGEST_KEPT + 1] {
            let values: Vec<Complex<f64>> = (0..length).map(|n| Complex::new((0.3 * n as f64).sin(), 0.1)).collect();
            let mut transformed = values.clone();
            forward(length).process(&mut transformed);
            let sum: Complex<f64> = values.iter().sum();
            assert!((transformed[0] - sum).norm() < 1e-9 * length as f64, "{length}");
            inverse(length).process(&mut transformed);
            let farthest =
                values.iter().zip(&transformed).map(|(a, b)| (a - b / length as f64).norm()).fold(0.0, f64::max);
            assert!(farthest < 1e-9, "{length}: {farthest}");
        }
    }
}
