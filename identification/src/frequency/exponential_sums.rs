//! Sums of exponentials at uneven times, Σ_i J_i exp(-2πj n x_i) with 0 <= x_i <= 1, for many n at once.
//!
//! Each J is spread over an even grid, twice as fine as required by the highest n, with the kernel φ(z) = exp(β (√(1 - z²) - 1)); a
//! discrete Fourier transform of the grid is divided by that of the kernel (A. H. Barnett, J. Magland and L. af Klinteberg, SIAM J. Sci.
//! Comput. 41, 2019). The width of the kernel gives an error of 1e-13 of the root of Σ|J|².

use nalgebra::Complex;

use crate::{fourier, parallel};

/// Grid points under the kernel.
const WIDTH: usize = 15;

/// Half of it.
const HALF_WIDTH: f64 = 0.5 * WIDTH as f64;

/// β, for a grid twice as fine as needed.
const SHAPE: f64 = 2.3 * WIDTH as f64;

/// Intervals of the integral for the kernel's transform: its integrand is smooth and vanishes at both ends.
const INTERVALS: u32 = 48;

/// Σ_i a_i exp(-2πj n x_i) and Σ_i b_i exp(-2πj n x_i) for n = 1 to `count`.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of grid points
pub(super) fn of_pairs(places: &[f64], pairs: &[Complex<f64>], count: usize) -> Vec<[Complex<f64>; 2]> {
    let size = transform_length(4 * count + 2 * WIDTH);
    let mut grid = vec![Complex::<f64>::default(); size];
    for (place, pair) in places.iter().zip(pairs) {
        let at = place * size as f64;
        let first = (at - HALF_WIDTH).ceil();
        let mut index = first.rem_euclid(size as f64) as usize;
        for tap in 0..WIDTH {
            let z = (first + tap as f64 - at) / HALF_WIDTH;
            grid[index] += pair * (SHAPE * ((1.0 - z * z).max(0.0).sqrt() - 1.0)).exp();
            index += 1;
            if index == size {
                index = 0;
            }
        }
    }
    fourier::forward(size).process(&mut grid);
    // ∫ φ(z) cos(a z) dz over z = sin θ, by the trapezoidal rule; it is even in θ.
    let angles = (1..INTERVALS / 2).map(|node| std::f64::consts::PI * f64::from(node) / f64::from(INTERVALS));
    let nodes: Vec<[f64; 2]> = angles
        .map(|angle| [angle.sin(), 2.0 * (SHAPE * (angle.cos() - 1.0)).exp() * angle.cos()])
        .chain([[0.0, 1.0]])
        .collect();
    let spacing = HALF_WIDTH * std::f64::consts::PI / f64::from(INTERVALS);
    let kernel = |n: usize| {
        let a = std::f64::consts::TAU * HALF_WIDTH * n as f64 / size as f64;
        spacing * nodes.iter().map(|[z, weight]| weight * (a * z).cos()).sum::<f64>()
    };
    // Two real signals in one transform: the even part is that of a, the odd part j times that of b.
    let split = |n: usize| {
        let (here, mirrored) = (grid[n], grid[size - n].conj());
        let half = 0.5 / kernel(n);
        [(here + mirrored) * half, (here - mirrored) * Complex::new(0.0, -half)]
    };
    parallel::ranges(count, |range| range.map(|n| split(n + 1)).collect())
}

/// The smallest number from `least` on without prime factors above five, for a fast transform.
fn transform_length(least: usize) -> usize {
    let smooth = |mut number: usize| {
        for factor in [2, 3, 5] {
            while number.is_multiple_of(factor) {
                number /= factor;
            }
        }
        number == 1
    };
    (least..).find(|number| smooth(*number)).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_the_sums_term_by_term() {
        let places: Vec<f64> = (0..=500).map(|i| (f64::from(i) / 500.0).powf(1.3)).collect();
        let pairs: Vec<Complex<f64>> =
            (0..=500).map(|i| Complex::new((0.9 * f64::from(i)).sin(), (0.37 * f64::from(i * i)).cos())).collect();
        let sums = of_pairs(&places, &pairs, 200);
        for n in [1_u32, 2, 57, 199, 200] {
            let direct = |part: fn(&Complex<f64>) -> f64| -> Complex<f64> {
                let terms = places.iter().zip(&pairs);
                terms.map(|(x, pair)| Complex::from_polar(part(pair), -std::f64::consts::TAU * f64::from(n) * x)).sum()
            };
            let [a, b] = sums[n as usize - 1];
            let (a_error, b_error) = ((a - direct(|pair| pair.re)).norm(), (b - direct(|pair| pair.im)).norm());
            assert!(a_error < 1e-11 && b_error < 1e-11, "{n}: {a_error} {b_error}");
        }
    }

    #[test]
    fn lengths_of_transforms_are_smooth_and_hardly_longer_than_asked_for() {
        assert_eq!([7, 97, 1000, 1001].map(transform_length), [8, 100, 1000, 1024]);
    }
}
