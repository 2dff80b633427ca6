//! A command piece without a change of mode, as one linear map: for approximate simulations in a search, most of whose steps are alike.

use super::{
    cubic_spring::CubicSpring,
    linear_system::{DEMAND, FORCE, Kind, LinearSystem, POLE, POSITION, RATE, ROWS, SIZE, add, states},
};
use crate::transition::Ramp;

/// Rows and columns of a map without output effects, for linear demand and force.
const DRIVE_ROWS: usize = 4;
const DRIVE_COLUMNS: usize = 7;

/// A linear map over a piece.
#[derive(Debug, Clone)]
pub(super) struct LinearMap {
    pub(super) kind: Kind,
    /// [s]
    pub(super) length: f64,
    /// Relative excess of the acceleration within the piece over that at its ends.
    pub(super) beyond: f64,
    /// For each entry of z, its nonzero contribution to the states.
    columns: Vec<(usize, [f64; ROWS])>,
    cubic: Option<CubicSpring>,
    /// As above, from x, δ, v, demand, its slope, force, its slope to x, δ and v.
    drive: [[f64; DRIVE_ROWS]; DRIVE_COLUMNS],
}

impl LinearMap {
    pub(super) fn new(system: &LinearSystem<'_>, length: f64) -> Self {
        let (after, terms) = (system.after(length), &system.actuator.terms);
        let columns = after.iter().map(states).enumerate().filter(|(_, adds)| *adds != [0.0; ROWS]).collect();
        let has_spring = terms.cubic != 0.0 && system.kind.gain.is_some();
        let cubic = has_spring.then(|| CubicSpring::new(system, length, &after));
        let drive = [POLE, POSITION, RATE, DEMAND, DEMAND + 1, FORCE, FORCE + 1].map(|place| {
            let [pole, position, rate] = [POLE, POSITION, RATE].map(|row| after[place][row]);
            [pole, position, rate, 0.0]
        });
        Self { kind: system.kind, length, beyond: terms.acceleration_beyond_ends(length), columns, cubic, drive }
    }

    /// x, δ and v after the piece, from those at its start, the demand and the force of the drive.
    #[inline(always)]
    pub(super) fn drive(&self, [pole, position, rate]: [f64; 3], demand: Ramp, force: Ramp) -> [f64; 3] {
        let before = [pole, position, rate, demand.value, demand.slope, force.value, force.slope];
        let mut sums = [0.0; DRIVE_ROWS];
        for (row, sum) in sums.iter_mut().enumerate() {
            for (column, value) in self.drive.iter().zip(before) {
                *sum += column[row] * value;
            }
        }
        [sums[0], sums[1], sums[2]]
    }

    /// The states after the piece: those of the drive or all of them; `None` if the iteration for the cubic spring does not converge.
    #[inline]
    pub(super) fn after(&self, before: &[f64; SIZE], cubic: f64, is_of_drive: bool) -> Option<[f64; ROWS]> {
        let mut after = [0.0; ROWS];
        if is_of_drive {
            after[..DRIVE_ROWS].copy_from_slice(&self.apply::<DRIVE_ROWS>(before, cubic)?);
        } else {
            after = self.apply(before, cubic)?;
        }
        Some(after)
    }

    /// The first `N` of them.
    fn apply<const N: usize>(&self, before: &[f64; SIZE], cubic: f64) -> Option<[f64; N]> {
        let mut sums = [0.0; N];
        add(&mut sums, self.columns.iter().map(|(place, column)| (before[*place], column)));
        let springs = self.cubic.as_ref();
        springs.is_none_or(|spring| spring.add_to(&mut sums, before, cubic, self.length)).then_some(sums)
    }
}
