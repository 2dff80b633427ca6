//! The actuator in one mode as a linear system: its inputs and memory in one vector.
//!
//! ```text
//! ż = A z,   z = (x, δ, v; memory of the output effects; their outputs; demand and its derivatives; force and its derivatives)
//! z(t) = e^(A t) z(0)
//! ```
//!
//! A follows from the mode of the drive and from the conditions of the output effects, which are linear between two events.

use super::{constants::Actuator, integration::FIRST_INTEGRATED};
use crate::{
    effects::{INTEGRATED, MEMORY, OUTPUT_EFFECTS},
    exponential::{Terms, exponential},
    operator::{EventCondition, Signal},
    parameters::Order,
};

/// x, δ, v and the memory.
pub(super) const STATES: usize = 3 + INTEGRATED;
/// Rows of a map onto the states, padded to the width of SIMD registers.
pub(super) const ROWS: usize = 8;
const _: () = assert!(STATES <= ROWS);
// Places in z.
pub(super) const POLE: usize = 0;
pub(super) const POSITION: usize = 1;
pub(super) const RATE: usize = 2;
pub(super) const REMEMBERED: usize = 3;
pub(super) const OUTPUT: usize = STATES;
pub(super) const DEMAND: usize = OUTPUT + OUTPUT_EFFECTS;
pub(super) const FORCE: usize = DEMAND + 3;
/// Coefficients of the force.
pub(super) const FORCES: usize = 5;
pub(super) const SIZE: usize = FORCE + FORCES;

/// A matrix as its columns.
pub(super) type Columns = [[f64; SIZE]; SIZE];

/// What distinguishes systems: the properties of a mode other than the constants of its force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Kind {
    /// Gain of the servo; `None` if the rate is held.
    pub gain: Option<f64>,
    /// True if an output effect follows its input.
    pub follows: [bool; OUTPUT_EFFECTS],
}

impl Kind {
    /// From the force of the drive in a mode, if any, and the conditions of the effects behind it.
    #[inline]
    pub fn new(force: Option<(f64, f64)>, conditions: &[EventCondition; OUTPUT_EFFECTS]) -> Self {
        let follows = |condition: &EventCondition| matches!(condition, EventCondition::Slope(_));
        Self { gain: force.map(|(gain, _)| gain), follows: conditions.each_ref().map(follows) }
    }
}

/// The mode of an actuator between two events.
#[derive(Clone, Copy)]
pub(super) struct LinearSystem<'a> {
    pub actuator: &'a Actuator,
    pub kind: Kind,
    /// Of the output effects.
    pub conditions: &'a [EventCondition; OUTPUT_EFFECTS],
}

/// The states among the rows of a column.
pub(super) fn states(column: &[f64; SIZE]) -> [f64; ROWS] {
    std::array::from_fn(|row| if row < STATES { column[row] } else { 0.0 })
}

/// Adds a linear combination of columns.
pub(super) fn add<'a, const N: usize, const M: usize>(
    sums: &mut [f64; N],
    columns: impl IntoIterator<Item = (f64, &'a [f64; M])>,
) {
    for (value, column) in columns {
        sums.iter_mut().zip(column).for_each(|(sum, factor)| *sum += factor * value);
    }
}

impl LinearSystem<'_> {
    /// The columns of e^(A t) for this length [s].
    pub fn after(&self, length: f64) -> Columns {
        let columns = std::array::from_fn(|place| {
            let mut unit = [0.0; SIZE];
            unit[place] = length;
            self.derivative(&unit)
        });
        exponential(columns, Terms::Ten)
    }

    /// ż, which is linear in z, without a cubic spring.
    fn derivative(&self, z: &[f64; SIZE]) -> [f64; SIZE] {
        let Actuator { base, order, terms, output_effects, .. } = self.actuator;
        let mut rates = [0.0; SIZE];
        rates[POLE] = match order {
            Order::Second => z[DEMAND + 1],
            Order::Third => base.p() * (z[DEMAND] - z[POLE]),
        };
        rates[POSITION] = z[RATE];
        if let Some(gain) = self.kind.gain {
            let force = gain * (z[POLE] - z[POSITION]) + z[FORCE] - terms.stiffness * z[POSITION];
            rates[RATE] = terms.omega2 * force - terms.damping * z[RATE];
        }
        rates[DEMAND..DEMAND + 2].copy_from_slice(&z[DEMAND + 1..DEMAND + 3]);
        rates[FORCE..FORCE + FORCES - 1].copy_from_slice(&z[FORCE + 1..FORCE + FORCES]);
        let (mut memory, mut changes) = ([0.0; MEMORY], [0.0; MEMORY]);
        memory[FIRST_INTEGRATED..].copy_from_slice(&z[REMEMBERED..STATES]);
        let mut signal = Signal { value: z[POSITION], slope: z[RATE] };
        for (index, (effect, condition)) in output_effects.iter().zip(self.conditions).enumerate() {
            let (parameters, place) = (&effect.parameters, effect.memory);
            let into = &mut changes[place..];
            effect.operator.memory_derivatives(parameters, &memory[place..], signal, *condition, into);
            let slope = effect.operator.slope(parameters, &memory[place..], signal, *condition);
            rates[OUTPUT + index] = slope;
            signal = Signal { value: z[OUTPUT + index], slope };
        }
        rates[REMEMBERED..STATES].copy_from_slice(&changes[FIRST_INTEGRATED..]);
        rates
    }
}
