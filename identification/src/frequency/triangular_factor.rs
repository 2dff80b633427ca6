//! Rows of a least-squares problem folded into a triangle: A = Q R, of which only R is kept.
//!
//! The problem is that of local polynomials, with the columns U, U s, U s², 1, s, s² and the right-hand side Y, where s is the position
//! over frequency. Their triangle contains all information of the rows. Triangles of neighbouring rows are stacked as rows, and polynomials
//! in s are polynomials in s + h, so that a triangle can be used at any centre: the rows of long records are folded once, for all
//! neighbourhoods that contain them (T. F. Chan, ACM Trans. Math. Software 8, 1982; J. Demmel et al., SIAM J. Sci. Comput. 34, 2012).

use nalgebra::Complex;

/// Order of both polynomials.
const ORDER: usize = 2;

/// Coefficients of one polynomial.
const EACH: usize = ORDER + 1;

/// Coefficients of both polynomials.
pub(super) const UNKNOWNS: usize = 2 * EACH;

/// Unknowns and right-hand side.
const COLUMNS: usize = UNKNOWNS + 1;

/// A pivot below this fraction of its column is rounding: the rows do not determine the unknown.
const LEAST_PIVOT: f64 = 1e-12;

/// R, by rows.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TriangularFactor([[Complex<f64>; COLUMNS]; COLUMNS]);

/// G at a centre, with its uncertainty.
pub(super) struct Solution {
    response: [Complex<f64>; EACH],
    /// The rows of R⁻¹ that belong to G.
    inverse: [[Complex<f64>; UNKNOWNS]; EACH],
    /// Squared residual of all rows.
    pub(super) residual: f64,
}

impl TriangularFactor {
    /// For the lines of command and position; `place` is s of the first one, `step` that from line to line.
    #[allow(clippy::cast_precision_loss)] // counts of lines
    pub(super) fn of_lines(command: &[Complex<f64>], position: &[Complex<f64>], place: f64, step: f64) -> Self {
        let rows = command.len();
        let mut columns: [Vec<Complex<f64>>; COLUMNS] = std::array::from_fn(|_| Vec::with_capacity(rows));
        for (index, (command, position)) in command.iter().zip(position).enumerate() {
            let s = place + index as f64 * step;
            let powers = [1.0, s, s * s];
            for (order, power) in powers.into_iter().enumerate() {
                columns[order].push(command * power);
                columns[EACH + order].push(Complex::from(power));
            }
            columns[UNKNOWNS].push(*position);
        }
        Self::of_columns(columns)
    }

    /// From several triangles, each with the distance h of its centre from the common one.
    pub(super) fn of_factors<'a>(factors: impl Iterator<Item = (&'a Self, f64)>) -> Self {
        let mut columns: [Vec<Complex<f64>>; COLUMNS] = std::array::from_fn(|_| Vec::new());
        for (Self(rows), h) in factors {
            for values in rows {
                for first in [0, EACH] {
                    let [constant, linear, square] = [values[first], values[first + 1], values[first + 2]];
                    columns[first].push(constant);
                    columns[first + 1].push(linear + constant * h);
                    columns[first + 2].push(square + linear * (2.0 * h) + constant * (h * h));
                }
                columns[UNKNOWNS].push(values[UNKNOWNS]);
            }
        }
        Self::of_columns(columns)
    }

    /// Householder's reflections, column by column.
    fn of_columns(mut columns: [Vec<Complex<f64>>; COLUMNS]) -> Self {
        let mut triangle = [[Complex::default(); COLUMNS]; COLUMNS];
        for pivot in 0..COLUMNS.min(columns[0].len()) {
            let (left, right) = columns.split_at_mut(pivot + 1);
            let reflector = &mut left[pivot][pivot..];
            let length = reflector.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
            let first = reflector[0];
            if length > 0.0 {
                // Away from the first element, to avoid cancellation: v = a + |a| e^(j arg a0) e0.
                let turn = if first.norm() > 0.0 { first / first.norm() } else { Complex::from(1.0) };
                triangle[pivot][pivot] = -turn * length;
                reflector[0] += turn * length;
                // 2 / |v|²
                let scale = 1.0 / (length * (length + first.norm()));
                for column in &mut *right {
                    let column = &mut column[pivot..];
                    let product = product(reflector, column) * scale;
                    column.iter_mut().zip(&*reflector).for_each(|(value, v)| *value -= v * product);
                }
            }
            for (place, column) in right.iter().enumerate() {
                triangle[pivot][pivot + 1 + place] = column[pivot];
            }
        }
        Self(triangle)
    }

    /// The least-squares solution; `None` if the rows do not determine it.
    pub(super) fn solve(&self) -> Option<Solution> {
        let Self(r) = self;
        let determined = |column: usize| {
            let length = (0..=column).map(|row| r[row][column].norm_sqr()).sum::<f64>().sqrt();
            length.is_finite() && r[column][column].norm() > LEAST_PIVOT * length
        };
        if !(0..UNKNOWNS).all(determined) {
            return None;
        }
        // Columns of R⁻¹ from the bottom up, and the solution, R⁻¹ times the right-hand side.
        let mut inverse = [[Complex::default(); UNKNOWNS]; UNKNOWNS];
        for column in 0..UNKNOWNS {
            inverse[column][column] = r[column][column].inv();
            for row in (0..column).rev() {
                let sum: Complex<f64> = (row + 1..=column).map(|k| r[row][k] * inverse[k][column]).sum();
                inverse[row][column] = -sum / r[row][row];
            }
        }
        let response = std::array::from_fn(|row| (row..UNKNOWNS).map(|k| inverse[row][k] * r[k][UNKNOWNS]).sum());
        let solution = Solution {
            response,
            inverse: std::array::from_fn(|row| inverse[row]),
            residual: r[UNKNOWNS][UNKNOWNS].norm_sqr(),
        };
        let finite = |value: &Complex<f64>| value.re.is_finite() && value.im.is_finite();
        (response.iter().all(finite) && solution.residual.is_finite()).then_some(solution)
    }
}

impl Solution {
    /// G at s, and its variance for unit variance of each row.
    pub(super) fn at(&self, s: f64) -> (Complex<f64>, f64) {
        let powers = [1.0, s, s * s];
        let response = self.response.iter().zip(powers).map(|(value, power)| value * power).sum();
        let column = |k: usize| (0..EACH).map(|order| self.inverse[order][k] * powers[order]).sum::<Complex<f64>>();
        (response, (0..UNKNOWNS).map(|k| column(k).norm_sqr()).sum())
    }
}

/// Σ conj(a) b, in two partial sums.
fn product(a: &[Complex<f64>], b: &[Complex<f64>]) -> Complex<f64> {
    let mut sums = [Complex::<f64>::default(); 2];
    let (a_pairs, b_pairs) = (a.chunks_exact(2), b.chunks_exact(2));
    let rest: Complex<f64> = a_pairs.remainder().iter().zip(b_pairs.remainder()).map(|(a, b)| a.conj() * b).sum();
    for (a, b) in a_pairs.zip(b_pairs) {
        sums[0] += a[0].conj() * b[0];
        sums[1] += a[1].conj() * b[1];
    }
    sums[0] + sums[1] + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(count: u32) -> (Vec<Complex<f64>>, Vec<Complex<f64>>) {
        let command: Vec<Complex<f64>> =
            (0..count).map(|l| Complex::from_polar(1.0, f64::from(l * l) * 0.37)).collect();
        let position = (0..count).map(|l| {
            let s = 0.1 * (f64::from(l) - 20.0);
            let noise = Complex::new(f64::from(l * 7 % 5), f64::from(l * 3 % 7)) * 1e-3;
            command[l as usize] * (Complex::new(2.0, 1.0) + s * 0.5 - s * s * 0.25) + Complex::new(0.3, 0.2) * s + noise
        });
        (command.clone(), position.collect())
    }

    #[test]
    fn folded_parts_say_what_all_rows_say() {
        let (command, position) = lines(41);
        let whole = TriangularFactor::of_lines(&command, &position, -2.0, 0.1).solve().unwrap();
        // Parts of 10 rows, each with its own centre at its first row.
        let parts: Vec<(TriangularFactor, f64)> = (0..41)
            .step_by(10)
            .map(|first| {
                let end = (first + 10).min(41);
                let part = TriangularFactor::of_lines(&command[first..end], &position[first..end], 0.0, 0.1);
                (part, 0.1 * (first as f64 - 20.0))
            })
            .collect();
        let folded = TriangularFactor::of_factors(parts.iter().map(|(part, h)| (part, *h))).solve().unwrap();
        for s in [-0.3, 0.0, 1.0] {
            let ((a, a_variance), (b, b_variance)) = (whole.at(s), folded.at(s));
            assert!((a - b).norm() < 1e-12 && (a_variance / b_variance - 1.0).abs() < 1e-10);
            assert!((a - (Complex::new(2.0, 1.0) + s * 0.5 - s * s * 0.25)).norm() < 0.02);
        }
        assert!((whole.residual / folded.residual - 1.0).abs() < 1e-9);
    }

    #[test]
    fn rows_that_do_not_determine_the_response_give_none() {
        let (mut command, position) = lines(41);
        command
            .iter_mut()
            .enumerate()
            .filter(|(line, _)| *line != 20)
            .for_each(|(_, value)| *value = Complex::default());
        assert!(TriangularFactor::of_lines(&command, &position, -2.0, 0.1).solve().is_none());
    }
}
