//! A piece of the command, or a part of it, by one linear map where one mode holds through it.

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

/// Longest part of a piece under a cubic spring, times the natural frequency of the drive.
const LONGEST_CUBIC: f64 = 1.2;

/// Most parts of a piece, but where each saves so many segments: those of a heavily damped drive are as short as its fast pole asks for.
const MOST_PARTS: f64 = 4.0;
const SEGMENTS_IN_PART: f64 = 4.0;

/// Segments that a map over a part of a piece replaces at least, where none of the whole one serves. There is one for this number times each power of two:
/// a few do for any length, up to any event.
const FEWEST_SEGMENTS: f64 = 2.0;

impl Actuator {
    /// Advances the state over the piece of the command, or over a part of it, if one mode holds through it; returns its length [s]. Else
    /// nothing changes. Where maps serve parts of any length, that of the rest of a piece says nothing of those of pieces.
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

    /// Writes what the effects behind the drive put out and remember; their conditions, of which only the first may have one, or there is none.
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

    /// The length of the piece [s], or of one of the equal parts into which events and a cubic spring divide it; none where these are too many.
    pub(super) fn length_of_map(&self, position: f64, length: f64) -> Option<f64> {
        let (pole, longest) = if self.terms.cubic != 0.0 {
            (self.terms.natural_frequency(position), LONGEST_CUBIC)
        } else if self.has_events_of_motion {
            (self.natural_frequency, LONGEST_BETWEEN_ENDS)
        } else {
            return Some(length);
        };
        let share = pole * length / longest;
        if share <= 1.0 {
            return Some(length);
        }
        let segments = self.largest_pole * length / self.accuracy.longest;
        (share <= MOST_PARTS.max(segments / SEGMENTS_IN_PART)).then(|| length / share.ceil())
    }

    /// The length [s] of the part of a piece behind which maps are tried again, where none serves from its start.
    pub(super) fn part_without_map(&self, position: f64, length: f64) -> f64 {
        let part = self.shortest_part.or_else(|| self.length_of_map(position, length));
        part.map_or(length, |part| part.min(length))
    }

    /// The length [s] of the longest map that is no longer than this and serves pieces of any length, where the drive has such.
    fn length_of_part(&self, length: f64) -> Option<f64> {
        let shortest = self.shortest_part?;
        (length >= shortest).then(|| shortest * (length / shortest).log2().floor().exp2())
    }

    /// The length [s] of the shortest of these maps, where the fast pole of the drive is so far above its natural frequency that it is no longer than
    /// a part through which the ends tell whether a mode holds.
    pub(super) fn shortest_part(natural_frequency: f64, largest_pole: f64, accuracy: &Accuracy) -> Option<f64> {
        let shortest = FEWEST_SEGMENTS * accuracy.longest / largest_pole;
        (shortest <= LONGEST_BETWEEN_ENDS / natural_frequency).then_some(shortest)
    }

    /// Whether maps are tried on a step.
    pub(super) fn tries_maps(&self, maps: &LinearMaps) -> bool {
        maps.are_worth_it() || self.shortest_part.is_some()
    }

    /// How far x may be from the straight line between its ends; none where the demand is held.
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

    /// Maps that some steps of these lengths [s] have made.
    fn maps_of(lengths: impl Iterator<Item = f64>) -> usize {
        let effects = Effects::default().with(find("gain_drift").unwrap(), &[0.001]).unwrap();
        maps_after(lengths, table()[0].base, &effects)
    }

    /// The same of another base and other effects.
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
        // A row was dropped now and then.
        assert_eq!(maps_of((0..400).map(|n| if n % 9 == 8 { 0.01 } else { 0.005 })), 2);
        // Written to a microsecond, a length comes again by chance.
        let uneven = |n: u32| 0.005 + 1e-6 * f64::from(n.wrapping_mul(2_654_435_761) >> 22);
        assert_eq!(maps_of((0..400).map(uneven)), 0);
    }

    /// As fits end where the actuator is of first order: a pole far above the sampling.
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
        // Before and after the delayed change of each step, and parts of the first of both, which had not been seen.
        assert_eq!(maps_after((0..400).map(|_| 0.002), fast, &effects), 4);
    }
}
