//! The exponential of a sparse matrix by scaling, its series and squaring.
//!
//! ```text
//! e^A = (e^(A / 2^s))^(2^s)
//! ```
//!
//! Several times faster for such a matrix than the general one of `nalgebra`, which solves for a quotient of polynomials. That one also
//! requires `nalgebra` with `std`, and hence vectors and products of large matrices that no FMU needs: a sixth of the compilation time of
//! its binary.

/// Number of terms of the series; the truncation error is that at a norm of 1/2.
#[derive(Clone, Copy)]
pub(crate) enum Terms {
    /// 0.5^11 / 11! = 1e-11.
    Ten = 10,
    /// 0.5^15 / 15! = 2e-17: below rounding.
    Fourteen = 14,
}

/// Of a matrix given by columns.
pub(crate) fn exponential<const N: usize>(mut matrix: [[f64; N]; N], terms: Terms) -> [[f64; N]; N] {
    // Rates in different units differ by large factors: the balanced similar matrix needs fewer squarings.
    let scales = balance(&mut matrix);
    let norm = matrix.iter().map(|column| column.iter().map(|entry| entry.abs()).sum::<f64>()).fold(0.0, f64::max);
    let squares = (2.0 * norm).log2().ceil().clamp(0.0, 64.0) as i32;
    let scale = 0.5_f64.powi(squares);
    let sparse = matrix.map(|column| Sparse::new(column.map(|entry| scale * entry)));
    let mut result: [[f64; N]; N] = std::array::from_fn(|place| {
        let (mut sum, mut term) = ([0.0; N], [0.0; N]);
        (sum[place], term[place]) = (1.0, 1.0);
        for n in 1..=terms as u32 {
            let mut next = [0.0; N];
            sparse.iter().zip(&term).for_each(|(column, factor)| column.add_to(&mut next, *factor));
            term = next.map(|number| number / f64::from(n));
            sum.iter_mut().zip(&term).for_each(|(sum, term)| *sum += term);
        }
        sum
    });
    for _ in 0..squares {
        result = std::array::from_fn(|place| product(&result, &result[place]));
    }
    for (column, of_column) in result.iter_mut().enumerate() {
        of_column.iter_mut().zip(scales).for_each(|(entry, scale)| *entry *= scale / scales[column]);
    }
    result
}

/// A column as its nonzero entries.
struct Sparse<const N: usize> {
    entries: [(usize, f64); N],
    count: usize,
}

impl<const N: usize> Sparse<N> {
    fn new(column: [f64; N]) -> Self {
        let (mut entries, mut count) = ([(0, 0.0); N], 0);
        for (row, entry) in column.into_iter().enumerate().filter(|(_, entry)| *entry != 0.0) {
            entries[count] = (row, entry);
            count += 1;
        }
        Self { entries, count }
    }

    fn add_to(&self, sums: &mut [f64; N], factor: f64) {
        self.entries[..self.count].iter().for_each(|(row, entry)| sums[*row] += entry * factor);
    }
}

/// A matrix times a vector.
fn product<const N: usize>(matrix: &[[f64; N]; N], vector: &[f64; N]) -> [f64; N] {
    let mut sums = [0.0; N];
    for (column, value) in matrix.iter().zip(vector).filter(|(_, value)| **value != 0.0) {
        sums.iter_mut().zip(column).for_each(|(sum, entry)| *sum += entry * value);
    }
    sums
}

/// Balances A: replaces it by D⁻¹ A D with rows and columns of similar norm where both are nonzero (Osborne 1960); returns the diagonal of
/// D.
fn balance<const N: usize>(matrix: &mut [[f64; N]; N]) -> [f64; N] {
    const SWEEPS: usize = 3;
    let mut scales = [1.0; N];
    for place in (0..SWEEPS).flat_map(|_| 0..N) {
        let others = || (0..N).filter(|other| *other != place);
        let of_column = others().map(|row| matrix[place][row].abs()).sum::<f64>();
        let of_row = others().map(|column| matrix[column][place].abs()).sum::<f64>();
        if of_column == 0.0 || of_row == 0.0 {
            continue;
        }
        let factor = (of_row / of_column).sqrt();
        scales[place] *= factor;
        matrix[place].iter_mut().for_each(|entry| *entry *= factor);
        matrix.iter_mut().for_each(|column| column[place] /= factor);
    }
    scales
}

#[cfg(test)]
mod tests {
    use nalgebra::SMatrix;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// V Λ V⁻¹ has the exponential V e^Λ V⁻¹; a pair of rates σ ± iω is the block [σ ω; -ω σ], e^σ times a rotation.
        #[test]
        fn it_is_that_of_the_modes(
            directions in prop::collection::vec(-0.15_f64..0.15, 25),
            rates in prop::collection::vec(-3.0_f64..1.0, 3),
            frequencies in prop::collection::vec(0.0_f64..3.0, 2),
            sizes in prop::collection::vec(-2.0_f64..2.0, 5),
        ) {
            let v = SMatrix::<f64, 5, 5>::identity() + SMatrix::from_vec(directions);
            let back = v.try_inverse().unwrap();
            let (mut modes, mut moved) = (SMatrix::<f64, 5, 5>::zeros(), SMatrix::<f64, 5, 5>::zeros());
            (modes[(4, 4)], moved[(4, 4)]) = (rates[2], rates[2].exp());
            for (at, (sigma, omega)) in rates.iter().zip(&frequencies).enumerate().map(|(n, pair)| (2 * n, pair)) {
                let (sine, cosine) = omega.sin_cos();
                for (row, column, rate, value) in
                    [(0, 0, *sigma, cosine), (1, 1, *sigma, cosine), (0, 1, *omega, sine), (1, 0, -omega, -sine)]
                {
                    modes[(at + row, at + column)] = rate;
                    moved[(at + row, at + column)] = sigma.exp() * value;
                }
            }
            let (whole, expected) = (v * modes * back, v * moved * back);
            // With entries in different units.
            let size = |row: usize, column: usize| 10_f64.powf(sizes[row] - sizes[column]);
            let matrix: [[f64; 5]; 5] = std::array::from_fn(|column| std::array::from_fn(|row| whole[(row, column)] * size(row, column)));
            for (terms, tolerance) in [(Terms::Ten, 1e-8), (Terms::Fourteen, 1e-12)] {
                let found = exponential(matrix, terms);
                for (column, of_column) in found.iter().enumerate() {
                    for (row, entry) in of_column.iter().enumerate() {
                        let expected = expected[(row, column)] * size(row, column);
                        prop_assert!((entry - expected).abs() < tolerance * size(row, column), "{entry} {expected}");
                    }
                }
            }
        }
    }
}
