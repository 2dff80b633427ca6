//! Advances over a command piece, or a part of one, by one linear map if the mode does not change within it.

use super::{
    constants::Actuator,
    integration::FIRST_INTEGRATED,
    linear_map::LinearMap,
    linear_maps::LinearMaps,
    linear_system::{DEMAND, FORCE, Kind, LinearSystem, OUTPUT, POLE, POSITION, RATE, REMEMBERED, SIZE, STATES},
    state::State,
};
use crate::{
    effects::OUTPUT_EFFECTS,
    motion::{DriveMode, DriveState, Ends, LONGEST_BETWEEN_ENDS},
    operator::{EventCondition, Piece, Signal},
    parameters::Order,
    series::Accuracy,
    transition::Ramp,
};

/// Maximum length of a part of a piece under a cubic spring, times the natural frequency of the drive.
const LONGEST_CUBIC: f64 = 1.2;

/// Maximum number of parts of a piece, unless each part saves this many segments: a heavily damped drive needs segments as short as its
/// fast pole requires.
const MOST_PARTS: f64 = 4.0;
const SEGMENTS_IN_PART: f64 = 4.0;

/// Minimum number of segments that a map over a part of a piece must replace. Lengths are this number times powers of two: a few maps cover
/// any length up to any event.
const FEWEST_SEGMENTS: f64 = 2.0;

impl Actuator {
    /// Advances the state over the command piece, or a part of it, if the mode does not change; returns the length [s] advanced. Otherwise
    /// nothing changes. Where maps for parts exist, the remainder of a piece is not counted in the statistics of piece lengths.
    pub(super) fn advance_by_map(
        &self,
        state: &mut State,
        maps: &mut LinearMaps,
        (command, is_rest): (&Piece, bool),
        load: Ramp,
        time: f64,
    ) -> Option<f64> {
        let whole = self.length_of_map(state.position, command.length)?;
        let is_odd = is_rest && self.shortest_part.is_some();
        let comes_again = if is_odd { maps.have(whole) } else { maps.have_seen(whole) && maps.come_again() };
        let mut length = if comes_again { whole } else { self.length_of_part(whole)? };
        let [demand, slope, bend] = self.command.demand(*command, time, 1.0);
        let pole = if self.order == Order::Second { demand } else { state.pole };
        let mut from = self.terms.clamped_to_limits(DriveState { position: state.position, rate: state.rate });
        let mode = self.terms.active_mode(&from, pole, load.value);
        from.rate = mode.rate_or_held(from.rate);
        let force = mode.linear_force(&self.terms);

        let mut z = [0.0; SIZE];
        (z[POLE], z[POSITION], z[RATE]) = (pole, from.position, from.rate);
        let conditions = self.behind_drive(state, &from, &mut z)?;
        (z[DEMAND], z[DEMAND + 1], z[DEMAND + 2]) = (demand, slope, 2.0 * bend);
        if let Some((_, constant)) = force {
            (z[FORCE], z[FORCE + 1]) = (constant + load.value, load.slope);
        }

        let kind = Kind::new(force, &conditions);
        let system = LinearSystem { actuator: self, kind, conditions: &conditions };
        let (after, to) = loop {
            let map = maps.get(&system, length)?;
            let after = map.after(&z, self.terms.cubic, self.output_effects.is_empty())?;
            let to = DriveState { position: after[POSITION], rate: after[RATE] };
            let target_bend = self.bend_of_target(pole, [demand, slope, bend], length);
            let (target, load) = ([pole, after[POLE]], [load.value, load.at(length)]);
            let ends = Ends { target, target_bend, load, drive: [from, to] };
            if !self.has_events_of_motion || self.holds(&mode, conditions[0], &ends, map) {
                break (after, to);
            }
            length = self.length_of_part(0.5 * length)?;
        };
        (state.pole, state.position, state.rate) = (after[POLE], to.position, to.rate);
        state.saturated = mode.is_saturated();
        if !self.output_effects.is_empty() {
            state.memory[FIRST_INTEGRATED..].copy_from_slice(&after[REMEMBERED..STATES]);
        }
        Some(length)
    }

    /// Writes outputs and memory of the effects behind the drive to z; returns their conditions. `None` if an effect other than the first has
    /// one.
    pub(super) fn behind_drive(
        &self,
        state: &State,
        from: &DriveState,
        z: &mut [f64; SIZE],
    ) -> Option<[EventCondition; OUTPUT_EFFECTS]> {
        let mut conditions = [EventCondition::None; OUTPUT_EFFECTS];
        if self.output_effects.is_empty() {
            return Some(conditions);
        }
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
        Some(conditions)
    }

    /// Length [s] of the piece, or of the equal parts into which events and a cubic spring divide it; `None` if there are too many parts.
    pub(super) fn length_of_map(&self, position: f64, length: f64) -> Option<f64> {
        let (pole, longest) = if self.terms.cubic != 0.0 {
            (self.terms.natural_frequency(position), LONGEST_CUBIC)
        } else if self.has_events_of_motion {
            (self.natural_frequency, LONGEST_BETWEEN_ENDS)
        } else {
            return Some(length);
        };
        if pole * length <= longest {
            return Some(length);
        }
        let share = pole * length / longest;
        let segments = self.largest_pole * length / self.accuracy.longest;
        (share <= MOST_PARTS.max(segments / SEGMENTS_IN_PART)).then(|| length / share.ceil())
    }

    /// Length [s] of the part to solve by segments before maps are tried again, after no map applied at its start.
    pub(super) fn part_without_map(&self, position: f64, length: f64) -> f64 {
        let part = self.shortest_part.or_else(|| self.length_of_map(position, length));
        part.map_or(length, |part| part.min(length))
    }

    /// Length [s] of the longest map for parts that is not longer than `length`; `None` if the drive has no maps for parts.
    fn length_of_part(&self, length: f64) -> Option<f64> {
        let shortest = self.shortest_part?;
        (length >= shortest).then(|| shortest * (length / shortest).log2().floor().exp2())
    }

    /// Length [s] of the shortest map for parts, if the fast pole of the drive is so far above its natural frequency that the ends of a
    /// part of this length determine whether a mode holds.
    pub(super) fn shortest_part(natural_frequency: f64, largest_pole: f64, accuracy: &Accuracy) -> Option<f64> {
        let shortest = FEWEST_SEGMENTS * accuracy.longest / largest_pole;
        (shortest <= LONGEST_BETWEEN_ENDS / natural_frequency).then_some(shortest)
    }

    /// Whether maps are tried on a step.
    pub(super) fn tries_maps(&self, maps: &LinearMaps) -> bool {
        maps.are_worth_it() || self.shortest_part.is_some()
    }

    /// Maximum distance of x from the straight line between its ends; `None` for a held demand.
    ///
    /// ```text
    /// x = d(t) - d'/p - (d(0) - d'/p - x(0)) e^(-p t)
    /// ```
    #[inline(always)]
    pub(super) fn bend_of_target(&self, pole: f64, [demand, slope, bend]: [f64; 3], length: f64) -> Option<f64> {
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
    #[inline(always)]
    pub(super) fn holds(&self, mode: &DriveMode, condition: EventCondition, ends: &Ends, map: &LinearMap) -> bool {
        let Some([position, rate]) = self.terms.reach(mode, ends, map.length, map.beyond) else { return false };
        match condition {
            EventCondition::None => true,
            EventCondition::Input(range) => range.holds(position),
            EventCondition::Slope(range) => range.holds(rate),
            EventCondition::Difference(_) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        actuator::{linear_maps::MOST_MAPS, signals::Inputs, workspace::Workspace},
        effects::{Effects, find},
        parameters::{Base, table},
    };

    /// Number of maps made by steps of these lengths [s].
    fn maps_of(lengths: impl Iterator<Item = f64>) -> usize {
        let effects = Effects::default().with(find("gain_drift").unwrap(), &[0.001]).unwrap();
        maps_after(lengths, table()[0].base, &effects)
    }

    /// As above, for other base parameters and effects.
    fn maps_after(lengths: impl Iterator<Item = f64>, base: Base, effects: &Effects) -> usize {
        let actuator = Actuator::new(base, Order::Third, effects).approximate();
        let (mut state, mut workspace) = (actuator.at_rest(0.0), Workspace::default());
        for (index, length) in lengths.enumerate() {
            let command = Ramp { value: f64::from(u8::from(index % 2 == 1)), slope: 0.0 };
            actuator.step(&mut state, &mut workspace, Inputs::command(command), length).unwrap();
        }
        workspace.maps.maps.len()
    }

    #[test]
    fn a_clock_has_maps_where_its_steps_are_alike() {
        assert_eq!(maps_of((0..400).map(|_| 0.005)), 1);
        // Rows dropped now and then.
        assert_eq!(maps_of((0..400).map(|n| if n % 9 == 8 { 0.01 } else { 0.005 })), 2);
        // Times rounded to microseconds: lengths repeat by chance.
        let uneven = |n: u32| 0.005 + 1e-6 * f64::from(n.wrapping_mul(2_654_435_761) >> 22);
        assert_eq!(maps_of((0..400).map(uneven)), 0);
    }

    /// Typical end of a fit to a first-order actuator: a pole far above the sampling frequency.
    #[test]
    fn few_maps_serve_a_heavily_damped_drive_under_an_uneven_clock_up_to_its_events() {
        let base = Base::new(1.0, 1e4, 630.0, 16.0).unwrap();
        for (name, values) in
            [("coulomb_friction", &[0.3][..]), ("rate_limit", &[20.0, 20.0]), ("gain_drift", &[0.001])]
        {
            for delay_s in [0.0, 0.0037] {
                let with = |effects: Effects, name: &str, values: &[f64]| effects.with(find(name).unwrap(), values);
                let effects = with(Effects::default(), name, values).unwrap();
                let effects = if delay_s > 0.0 { with(effects, "delay", &[delay_s]).unwrap() } else { effects };
                let exact = Actuator::new(base, Order::Second, &effects);
                let approximate = Actuator::new(base, Order::Second, &effects).approximate();
                let mut runs =
                    [exact, approximate].map(|actuator| (actuator.at_rest(0.0), Workspace::default(), actuator));
                for n in 0..400_u32 {
                    let length = 0.01 + 1e-6 * f64::from(n.wrapping_mul(2_654_435_761) >> 22);
                    let command = Ramp { value: (0.13 * f64::from(n)).sin(), slope: 0.0 };
                    let positions = runs.each_mut().map(|(state, workspace, actuator)| {
                        actuator.step(state, workspace, Inputs::command(command), length).unwrap();
                        state.position
                    });
                    let error = (positions[0] - positions[1]).abs();
                    assert!(error < 1e-6, "{name}, delay {delay_s} s, sample {n}: {positions:?}");
                }
                let maps = runs[1].1.maps.maps.len();
                assert!((1..MOST_MAPS).contains(&maps), "{name}, delay {delay_s} s: {maps}");
            }
        }
    }

    #[test]
    fn parts_of_a_delayed_command_have_maps_under_a_base_whose_segments_are_shorter() {
        let fast = Base::new(1.0, 1.2e5, 1656.0, 3.5).unwrap();
        let with = |effects: Effects, name: &str, value: f64| effects.with(find(name).unwrap(), &[value]).unwrap();
        let effects = with(with(Effects::default(), "delay", 0.0013), "sensor_lag", 0.003);
        // Before and after the delayed change of each step, and the first parts of both, whose lengths were new.
        assert_eq!(maps_after((0..400).map(|_| 0.002), fast, &effects), 4);
    }
}
