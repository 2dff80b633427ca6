//! The cubic spring added to a linear system: its force is the interpolating polynomial through five instants of a piece, the nodes of
//! Lobatto quadrature.

use super::linear_system::{Columns, FORCE, FORCES, LinearSystem, POSITION, RATE, ROWS, SIZE, add, states};
use crate::series::FACTORIAL;

/// Instants at which the cubic spring is evaluated, as fractions of the piece.
const NODES: usize = FORCES;
const NODE: [f64; NODES] = [0.0, 0.172_673_164_646_011_4, 0.5, 0.827_326_835_353_988_6, 1.0];

/// For each node, the coefficients of the Lagrange polynomial in τ (1 there, 0 at the other nodes).
const POLYNOMIALS: [[f64; NODES]; NODES] = polynomials();

/// Fixed-point iteration of the positions under a cubic spring: it ends when the remaining change, extrapolated from the rate of
/// convergence, is below this relative tolerance; maximum number of iterations.
const CHANGE_OF_POSITION: f64 = 1e-8;
const MOST_REPETITIONS: usize = 8;

/// Contributions of the force at the nodes.
#[derive(Debug, Clone)]
pub(super) struct CubicSpring {
    /// For each entry of z, its contribution to the positions at all nodes but the first.
    columns: Vec<(usize, [f64; NODES - 1])>,
    /// For each node, its contribution to these positions.
    positions: [[f64; NODES - 1]; NODES],
    /// For each node, its contribution to the states at the end.
    states: [[f64; ROWS]; NODES],
}

impl CubicSpring {
    /// For a system over this length [s] with these columns.
    pub fn new(system: &LinearSystem<'_>, length: f64, after: &Columns) -> Self {
        let inner: [Columns; NODES - 2] = std::array::from_fn(|node| system.after(NODE[node + 1] * length));
        let at_nodes = |place: usize| -> [f64; NODES - 1] {
            std::array::from_fn(|node| inner.get(node).unwrap_or(after)[place][POSITION])
        };
        // A force τ^n has the n-th derivative n! / length^n at the start.
        let factors: [f64; NODES] = std::array::from_fn(|n| FACTORIAL[n] / length.powi(n as i32));
        let columns = (0..SIZE).map(|place| (place, at_nodes(place)));
        Self {
            columns: columns.filter(|(_, adds)| *adds != [0.0; NODES - 1]).collect(),
            positions: POLYNOMIALS.map(|polynomial| {
                let mut sums = [0.0; NODES - 1];
                (0..NODES).for_each(|n| add(&mut sums, [(polynomial[n] * factors[n], &at_nodes(FORCE + n))]));
                sums
            }),
            states: POLYNOMIALS.map(|polynomial| {
                let mut sums = [0.0; ROWS];
                (0..NODES).for_each(|n| add(&mut sums, [(polynomial[n] * factors[n], &states(&after[FORCE + n]))]));
                sums
            }),
        }
    }

    /// Adds the contribution of the spring to the states at the end, from z at the start; false if the iteration does not converge.
    pub fn add_to<const N: usize>(&self, sums: &mut [f64; N], before: &[f64; SIZE], cubic: f64, length: f64) -> bool {
        let Some(forces) = self.forces(before, cubic, length) else { return false };
        add(sums, forces.into_iter().zip(&self.states));
        true
    }

    /// Spring force over ω² at the nodes, consistent with the positions that result from it; `None` if the iteration does not converge.
    fn forces(&self, before: &[f64; SIZE], cubic: f64, length: f64) -> Option<[f64; NODES]> {
        let (start, rate) = (before[POSITION], before[RATE]);
        let force = |position: f64| -cubic * position * position * position;
        let slope = -3.0 * cubic * start * start * rate * length;
        let mut forces = NODE.map(|node| force(start) + slope * node);
        let mut without = [0.0; NODES - 1];
        add(&mut without, self.columns.iter().map(|(place, column)| (before[*place], column)));
        // The first node does not move.
        add(&mut without, [(forces[0], &self.positions[0])]);
        let (mut last, mut last_change) = ([f64::INFINITY; NODES - 1], 0.0);
        for _ in 0..MOST_REPETITIONS {
            let mut positions = without;
            add(&mut positions, forces.into_iter().zip(&self.positions).skip(1));
            let (mut change, mut size) = (0.0_f64, start.abs());
            for (node, position) in positions.iter().enumerate() {
                forces[node + 1] = force(*position);
                change = larger(change, (position - last[node]).abs());
                size = larger(size, position.abs());
            }
            let enough = CHANGE_OF_POSITION * size;
            if change <= enough || change * change <= enough * last_change {
                return Some(forces);
            }
            (last, last_change) = (positions, if change.is_finite() { change } else { 0.0 });
        }
        None
    }
}

/// The larger of two numbers; the first one if the second is NaN. A plain comparison compiles to one instruction, unlike `f64::max`.
fn larger(one: f64, other: f64) -> f64 {
    if other > one { other } else { one }
}

/// Lagrange's polynomials of the nodes.
const fn polynomials() -> [[f64; NODES]; NODES] {
    let mut all = [[0.0; NODES]; NODES];
    let mut one = 0;
    while one < NODES {
        let (mut product, mut other, mut degree) = ([0.0; NODES], 0, 0);
        product[0] = 1.0;
        while other < NODES {
            if other != one {
                let scale = 1.0 / (NODE[one] - NODE[other]);
                let mut n = degree + 1;
                while n > 0 {
                    product[n] = scale * (product[n - 1] - NODE[other] * product[n]);
                    n -= 1;
                }
                product[0] *= -scale * NODE[other];
                degree += 1;
            }
            other += 1;
        }
        all[one] = product;
        one += 1;
    }
    all
}
