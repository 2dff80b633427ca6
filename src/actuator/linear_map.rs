//! A piece of the command that one mode holds through, as one linear map: for approximate simulations in a search, most of whose steps are
//! alike.
//!
//! ```text
//! ż = A z,   z = (x, δ, v; memory of the output effects; their outputs; demand and its derivatives; force and its derivatives)
//! z(t) = e^(A t) z(0)
//! ```
//!
//! A follows from the mode of the drive and from the conditions of the output effects, which are linear between two events. The cubic spring
//! is a force beside it: the polynomial through its values at five instants of the piece, the nodes of Lobatto's quadrature.

use super::{constants::Actuator, exponential::exponential, integration::FIRST_INTEGRATED, state::State};
use crate::{
    effects::{INTEGRATED, MEMORY, OUTPUT_EFFECTS},
    motion::{DriveMode, DriveState, Ends, LONGEST_BETWEEN_ENDS},
    operator::{EventCondition, Piece, Signal},
    parameters::Order,
    series::FACTORIAL,
    transition::Ramp,
};

/// What a map gives: x, δ, v and the memory.
const STATES: usize = 3 + INTEGRATED;
/// Rows of a map, with and without output effects: numbers that a processor takes together.
const ALL_ROWS: usize = 8;
const DRIVE_ROWS: usize = 4;
const _: () = assert!(STATES <= ALL_ROWS);
// Places in z.
const POLE: usize = 0;
const POSITION: usize = 1;
const RATE: usize = 2;
const REMEMBERED: usize = 3;
const OUTPUT: usize = STATES;
const DEMAND: usize = OUTPUT + OUTPUT_EFFECTS;
const FORCE: usize = DEMAND + 3;
const SIZE: usize = FORCE + NODES;

/// Instants at which the cubic spring is evaluated, by the length of the piece.
const NODES: usize = 5;
const NODE: [f64; NODES] = [0.0, 0.172_673_164_646_011_4, 0.5, 0.827_326_835_353_988_6, 1.0];

/// By the node, the coefficients of the polynomial in τ that is 1 there and 0 at the others.
const POLYNOMIALS: [[f64; NODES]; NODES] = polynomials();

/// Longest part of a piece under a cubic spring, in time constants of the fastest pole of the drive.
const LONGEST_CUBIC: f64 = 1.2;

/// Most parts of a piece.
const MOST_PARTS: f64 = 4.0;

/// Positions under a cubic spring are repeated until they change by less than this share, so often at most.
const CHANGE_OF_POSITION: f64 = 1e-8;
const MOST_REPETITIONS: usize = 8;

/// Lengths of pieces are the same within this share, above what they differ by in the last bits.
const SAME_LENGTH: f64 = 1e-9;

/// Most maps of an actuator: steps and parts of them, each in some modes.
const MOST_MAPS: usize = 16;

/// Lengths without a map that are remembered: a map is made when one comes again.
const REMEMBERED_LENGTHS: usize = 4;

/// What tells one map from another: what a mode is but for the constants of its force.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kind {
    /// Gain of the servo; none where the rate is held.
    gain: Option<f64>,
    /// True where an output effect goes with its input.
    follows: [bool; OUTPUT_EFFECTS],
}

/// A linear map over a piece.
#[derive(Debug, Clone)]
struct LinearMap {
    kind: Kind,
    /// [s]
    length: f64,
    /// By which share the acceleration goes beyond those at its ends.
    beyond: f64,
    /// By place in z, what it adds to the states, where it adds something.
    columns: Vec<(usize, [f64; ALL_ROWS])>,
    cubic: Option<CubicSpring>,
}

/// What the force at the nodes adds.
#[derive(Debug, Clone)]
struct CubicSpring {
    /// By place in z, to the positions at the nodes but the first.
    columns: Vec<(usize, [f64; NODES - 1])>,
    /// By the node, to these positions.
    positions: [[f64; NODES - 1]; NODES],
    /// By the node, to the states at the end.
    states: [[f64; ALL_ROWS]; NODES],
}

/// The maps of an actuator.
#[derive(Debug, Clone, Default)]
pub(super) struct LinearMaps {
    maps: Vec<LinearMap>,
    /// The latest lengths without a map, and where the next one is written.
    missed: [f64; REMEMBERED_LENGTHS],
    next: usize,
}

impl LinearMaps {
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// True for the length of a map, or of a piece not long ago; else it is remembered.
    fn have_seen(&mut self, length: f64) -> bool {
        let is_same = |other: f64| (length - other).abs() <= SAME_LENGTH * length;
        if self.maps.iter().any(|map| is_same(map.length)) || self.missed.iter().any(|missed| is_same(*missed)) {
            return true;
        }
        self.missed[self.next] = length;
        self.next = (self.next + 1) % REMEMBERED_LENGTHS;
        false
    }

    /// The map of this kind over this length; none where there are too many.
    fn get(
        &mut self,
        actuator: &Actuator,
        kind: Kind,
        conditions: &[EventCondition],
        length: f64,
    ) -> Option<&LinearMap> {
        let is_wanted = |map: &LinearMap| (length - map.length).abs() <= SAME_LENGTH * length && map.kind == kind;
        if let Some(index) = self.maps.iter().position(is_wanted) {
            return Some(&self.maps[index]);
        }
        if self.maps.len() == MOST_MAPS {
            return None;
        }
        self.maps.push(LinearMap::new(actuator, kind, conditions, length));
        self.maps.last()
    }
}

impl LinearMap {
    fn new(actuator: &Actuator, kind: Kind, conditions: &[EventCondition], length: f64) -> Self {
        let after = actuator.exponential(kind, conditions, length);
        let columns = columns(&after, |column| std::array::from_fn(|row| if row < STATES { column[row] } else { 0.0 }));
        let has_spring = actuator.cubic() != 0.0 && kind.gain.is_some();
        let cubic = has_spring.then(|| CubicSpring::new(actuator, kind, conditions, length, &after));
        Self { kind, length, beyond: actuator.terms.acceleration_beyond_ends(length), columns, cubic }
    }

    /// Writes the first states after the piece; false where the motion under a cubic spring does not converge.
    fn apply<const ROWS: usize>(&self, before: &[f64; SIZE], cubic: f64, after: &mut [f64; ALL_ROWS]) -> bool {
        let mut sums = [0.0; ROWS];
        add(&mut sums, &self.columns, before);
        if let Some(spring) = &self.cubic {
            let Some(forces) = spring.forces(before, cubic, self.length) else { return false };
            add_all(&mut sums, &spring.states, &forces);
        }
        after[..ROWS].copy_from_slice(&sums);
        true
    }
}

impl CubicSpring {
    fn new(
        actuator: &Actuator,
        kind: Kind,
        conditions: &[EventCondition],
        length: f64,
        after: &[[f64; SIZE]; SIZE],
    ) -> Self {
        let inner: [_; NODES - 2] =
            std::array::from_fn(|node| actuator.exponential(kind, conditions, NODE[node + 1] * length));
        let at_nodes = |column: usize| -> [f64; NODES - 1] {
            std::array::from_fn(|node| inner.get(node).unwrap_or(after)[column][POSITION])
        };
        // A force of τ^n is the derivative n of its chain times n! / length^n at the start.
        let factors = std::array::from_fn::<f64, NODES, _>(|n| FACTORIAL[n] / length.powi(n as i32));
        let by_node = |polynomial: [f64; NODES], adds: &dyn Fn(usize) -> f64| -> f64 {
            (0..NODES).map(|n| polynomial[n] * factors[n] * adds(FORCE + n)).sum()
        };
        Self {
            columns: (0..SIZE)
                .map(|place| (place, at_nodes(place)))
                .filter(|(_, adds)| *adds != [0.0; NODES - 1])
                .collect(),
            positions: POLYNOMIALS
                .map(|polynomial| std::array::from_fn(|node| by_node(polynomial, &|place| at_nodes(place)[node]))),
            states: POLYNOMIALS.map(|polynomial| {
                std::array::from_fn(|state| {
                    if state < STATES { by_node(polynomial, &|place| after[place][state]) } else { 0.0 }
                })
            }),
        }
    }

    /// The force of the spring over ω² at the nodes, at positions that it leads to; none where that does not converge.
    fn forces(&self, before: &[f64; SIZE], cubic: f64, length: f64) -> Option<[f64; NODES]> {
        let (start, rate) = (before[POSITION], before[RATE]);
        let force = |position: f64| -cubic * position * position * position;
        let slope = -3.0 * cubic * start * start * rate * length;
        let mut forces = NODE.map(|node| force(start) + slope * node);
        let mut without = [0.0; NODES - 1];
        add(&mut without, &self.columns, before);
        let mut last = [f64::INFINITY; NODES - 1];
        for _ in 0..MOST_REPETITIONS {
            let mut positions = without;
            add_all(&mut positions, &self.positions, &forces);
            let (mut change, mut size) = (0.0_f64, start.abs());
            for (node, position) in positions.iter().enumerate() {
                forces[node + 1] = force(*position);
                change = change.max((position - last[node]).abs());
                size = size.max(position.abs());
            }
            if change <= CHANGE_OF_POSITION * size {
                return Some(forces);
            }
            last = positions;
        }
        None
    }
}

/// The columns of an exponential that add something, by their place.
fn columns<const N: usize>(
    after: &[[f64; SIZE]; SIZE],
    rows: impl Fn(&[f64; SIZE]) -> [f64; N],
) -> Vec<(usize, [f64; N])> {
    after.iter().map(rows).enumerate().filter(|(_, adds)| *adds != [0.0; N]).collect()
}

fn add<const N: usize, const M: usize>(sums: &mut [f64; N], columns: &[(usize, [f64; M])], before: &[f64; SIZE]) {
    for (place, column) in columns {
        let value = before[*place];
        for (sum, factor) in sums.iter_mut().zip(column) {
            *sum += factor * value;
        }
    }
}

fn add_all<const N: usize, const M: usize>(sums: &mut [f64; N], columns: &[[f64; M]; NODES], values: &[f64; NODES]) {
    for (column, value) in columns.iter().zip(values) {
        for (sum, factor) in sums.iter_mut().zip(column) {
            *sum += factor * value;
        }
    }
}

impl Actuator {
    /// Advances the state over the piece of the command, or over a part of it, if one mode holds through it; returns its length [s]. Else
    /// nothing changes.
    pub(super) fn advance_by_map(
        &self,
        state: &mut State,
        maps: &mut LinearMaps,
        command: &Piece,
        load: Ramp,
        time: f64,
    ) -> Option<f64> {
        let length = self.length_of_map(state.position, command.length)?;
        if !maps.have_seen(length) {
            return None;
        }
        let [demand, slope, bend] = self.command.demand(*command, time, 1.0);
        let pole = if self.order == Order::Second { demand } else { state.pole };
        let mut from = self.terms.clamped_to_limits(DriveState { position: state.position, rate: state.rate });
        let mode = self.terms.active_mode(from, pole, load.value);
        from.rate = mode.rate_or_held(from.rate);
        let force = mode.linear_force(&self.terms);

        let mut z = [0.0; SIZE];
        (z[POLE], z[POSITION], z[RATE]) = (pole, from.position, from.rate);
        let mut conditions = [EventCondition::None; OUTPUT_EFFECTS];
        if !self.output_effects.is_empty() {
            let mut signal = Signal { value: from.position, slope: from.rate };
            let mut memory = state.memory;
            for (index, effect) in self.output_effects.iter().enumerate() {
                let of_effect = &mut memory[effect.memory..];
                conditions[index] = effect.operator.event_condition(&effect.parameters, of_effect, signal);
                if index > 0 && conditions[index] != EventCondition::None {
                    return None;
                }
                signal.value = effect.operator.value(&effect.parameters, of_effect, signal.value);
                z[OUTPUT + index] = signal.value;
            }
            z[REMEMBERED..STATES].copy_from_slice(&memory[FIRST_INTEGRATED..]);
        }
        (z[DEMAND], z[DEMAND + 1], z[DEMAND + 2]) = (demand, slope, 2.0 * bend);
        if let Some((_, constant)) = force {
            (z[FORCE], z[FORCE + 1]) = (constant + load.value, load.slope);
        }

        let kind = Kind {
            gain: force.map(|(gain, _)| gain),
            follows: conditions.map(|condition| matches!(condition, EventCondition::Slope(_))),
        };
        let map = maps.get(self, kind, &conditions, length)?;
        let mut after = [0.0; ALL_ROWS];
        let is_found = if self.output_effects.is_empty() {
            map.apply::<DRIVE_ROWS>(&z, self.cubic(), &mut after)
        } else {
            map.apply::<ALL_ROWS>(&z, self.cubic(), &mut after)
        };
        if !is_found {
            return None;
        }
        let to = DriveState { position: after[POSITION], rate: after[RATE] };
        if self.has_events_of_motion {
            let target = [pole, after[POLE]];
            let target_bend = self.bend_of_target(pole, [demand, slope, bend], length);
            let ends = Ends { target, target_bend, load: [load.value, load.at(length)], drive: [from, to] };
            if !self.holds(mode, conditions[0], &ends, map) {
                return None;
            }
        }
        (state.pole, state.position, state.rate) = (after[POLE], to.position, to.rate);
        state.saturated = mode.is_saturated();
        if !self.output_effects.is_empty() {
            state.memory[FIRST_INTEGRATED..].copy_from_slice(&after[REMEMBERED..STATES]);
        }
        Some(length)
    }

    /// The length of the piece [s], or of one of the equal parts into which events and a cubic spring divide it; none where these are too many.
    fn length_of_map(&self, position: f64, length: f64) -> Option<f64> {
        let (pole, longest) = if self.cubic() != 0.0 {
            (self.terms.pole(position), LONGEST_CUBIC)
        } else if self.has_events_of_motion {
            (self.natural_frequency, LONGEST_BETWEEN_ENDS)
        } else {
            return Some(length);
        };
        let share = pole * length / longest;
        if share <= 1.0 { Some(length) } else { (share <= MOST_PARTS).then(|| length / share.ceil()) }
    }

    /// How far x may be from the straight line between its ends; none where the demand is held.
    ///
    /// ```text
    /// x = d(t) - d'/p - (d(0) - d'/p - x(0)) e^(-p t)
    /// ```
    fn bend_of_target(&self, pole: f64, [demand, slope, bend]: [f64; 3], length: f64) -> Option<f64> {
        if slope == 0.0 && bend == 0.0 {
            return None;
        }
        let of_demand = 0.25 * bend.abs() * length * length;
        if self.order == Order::Second {
            return Some(of_demand);
        }
        let p = self.base.p();
        Some(of_demand + (demand - slope / p - pole).abs() * (0.125 * (p * length).powi(2)).min(1.0))
    }

    /// True where the mode of the drive and the condition of the first output effect hold between these ends.
    fn holds(&self, mode: DriveMode, condition: EventCondition, ends: &Ends, map: &LinearMap) -> bool {
        let Some([position, rate]) = self.terms.reach(mode, ends, map.length, map.beyond) else { return false };
        match condition {
            EventCondition::None => true,
            EventCondition::Input(range) => range.holds(position),
            EventCondition::Slope(range) => range.holds(rate),
            EventCondition::Difference(_) => false,
        }
    }

    fn cubic(&self) -> f64 {
        self.terms.cubic
    }

    /// By the place in z before it, z after this length [s].
    fn exponential(&self, kind: Kind, conditions: &[EventCondition], length: f64) -> [[f64; SIZE]; SIZE] {
        exponential(std::array::from_fn(|place| {
            let mut unit = [0.0; SIZE];
            unit[place] = length;
            self.derivative(kind, conditions, &unit)
        }))
    }

    /// ż, which is linear in z, without a cubic spring.
    fn derivative(&self, kind: Kind, conditions: &[EventCondition], z: &[f64; SIZE]) -> [f64; SIZE] {
        let mut rates = [0.0; SIZE];
        rates[POLE] = match self.order {
            Order::Second => z[DEMAND + 1],
            Order::Third => self.base.p() * (z[DEMAND] - z[POLE]),
        };
        rates[POSITION] = z[RATE];
        if let Some(gain) = kind.gain {
            let force = gain * (z[POLE] - z[POSITION]) + z[FORCE] - self.terms.stiffness * z[POSITION];
            rates[RATE] = self.terms.omega2 * force - self.terms.damping * z[RATE];
        }
        rates[DEMAND..DEMAND + 2].copy_from_slice(&z[DEMAND + 1..DEMAND + 3]);
        rates[FORCE..FORCE + NODES - 1].copy_from_slice(&z[FORCE + 1..FORCE + NODES]);
        let (mut memory, mut changes) = ([0.0; MEMORY], [0.0; MEMORY]);
        memory[FIRST_INTEGRATED..].copy_from_slice(&z[REMEMBERED..STATES]);
        let mut signal = Signal { value: z[POSITION], slope: z[RATE] };
        for (index, (effect, condition)) in self.output_effects.iter().zip(conditions).enumerate() {
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
