//! The constants of an actuator: its equation with everything that its effects change in it.

use super::{signals::Outputs, state::State};
use crate::{
    command::{CommandSide, History, MOST_EFFECTS},
    effects::{Act, COMMAND_EFFECTS, Effects, MEMORY, UNLIMITED},
    motion::LoopTerms,
    operator::{FAST_POLE_RATIO, OutputOperator},
    parameters::{Base, Order},
    series::Accuracy,
    transition::Transition,
};

const _: () = assert!(COMMAND_EFFECTS <= MOST_EFFECTS, "make room for all effects on the command");

/// An effect on the motion or, with dynamics, on its measurement.
pub(super) struct OutputEffect {
    pub operator: &'static dyn OutputOperator,
    pub parameters: Vec<f64>,
    /// Index of its first entry in the memory.
    pub memory: usize,
    /// Index among the effects with event conditions.
    pub condition_index: usize,
    /// True for an effect on the measurement, which leaves the deflection of the surface unchanged.
    pub is_sensor: bool,
}

/// A static effect on the measurement.
pub(super) struct MeasurementEffect {
    pub value: fn(&[f64], f64, f64) -> f64,
    pub slope: fn(&[f64], f64) -> f64,
    pub parameters: Vec<f64>,
}

/// The constants of an actuator.
pub struct Actuator {
    pub(super) base: Base,
    pub(super) order: Order,
    /// No effect is active: a step is one transition.
    pub(super) is_linear: bool,
    /// An effect acts between the drive and the measurement.
    acts_behind_drive: bool,
    /// No effect acts on the motion or its measurement: where the command is linear, a transition is exact.
    pub(super) is_linear_behind_command: bool,
    /// One rate-independent effect acts behind a linear drive.
    pub(super) is_led_by_turns: bool,
    pub(super) command: CommandSide,
    pub(super) terms: LoopTerms,
    pub(super) output_effects: Vec<OutputEffect>,
    pub(super) measurement_effects: Vec<MeasurementEffect>,
    /// Largest magnitude of the poles represented by Taylor series [1/s].
    pub(super) largest_pole: f64,
    pub(super) accuracy: &'static Accuracy,
    /// Command pieces may be advanced by linear maps.
    pub(super) has_maps: bool,
    /// With maps and without a delay: a step without a change of mode is one map.
    pub(super) has_whole_steps: bool,
    /// Of the drive [1/s].
    pub(super) natural_frequency: f64,
    /// Length of the shortest map for parts of pieces [s], if there are such maps.
    pub(super) shortest_part: Option<f64>,
    /// The motion may have events, so that no mode is certain to hold.
    pub(super) has_events_of_motion: bool,
}

impl Actuator {
    /// Eq. (1) or eq. (6) with these parameters and effects.
    #[must_use]
    pub fn new(base: Base, order: Order, effects: &Effects) -> Self {
        let mut terms = LoopTerms::linear(base.omega(), base.zeta());
        let (mut output_effects, mut measurement_effects) = (Vec::new(), Vec::new());
        let mut command = CommandSide::new(base.k());
        let (mut memory, mut condition_index) = (0, 0);
        for (effect, values) in effects.iter() {
            if !effect.is_neutral(values) {
                let parameters = values.to_vec();
                match &effect.act {
                    Act::Delay => command.delay = values[0],
                    Act::Command(operator) => command.add(*operator, parameters, memory, condition_index),
                    Act::GainDrift(rate) => command.drift = rate(values),
                    Act::Loop(change) => change(values, &mut terms),
                    Act::Surface(operator) => output_effects.push(OutputEffect {
                        operator: *operator,
                        parameters,
                        memory,
                        condition_index,
                        is_sensor: false,
                    }),
                    Act::Sensor(operator) => output_effects.push(OutputEffect {
                        operator: *operator,
                        parameters,
                        memory,
                        condition_index,
                        is_sensor: true,
                    }),
                    Act::Reading { value, slope } => {
                        measurement_effects.push(MeasurementEffect { value: *value, slope: *slope, parameters })
                    }
                }
            }
            memory += effect.memory;
            condition_index += usize::from(effect.act.has_events());
        }
        // Neutral limits are large finite numbers in files and in the FMU, here infinity.
        for limit in [&mut terms.up, &mut terms.down, &mut terms.max, &mut terms.acceleration] {
            *limit = if *limit >= UNLIMITED { f64::INFINITY } else { *limit };
        }
        terms.min = if terms.min <= -UNLIMITED { f64::NEG_INFINITY } else { terms.min };
        let poles = output_effects.iter().map(|effect| effect.operator.pole(&effect.parameters));
        let slow = poles.fold(terms.pole(0.0), f64::max);
        let mut fast: Vec<f64> =
            output_effects.iter().map(|effect| effect.operator.fast_pole(&effect.parameters)).collect();
        fast.push(if order == Order::Third { base.p() } else { 0.0 });
        fast.sort_by(f64::total_cmp);
        let largest_pole = fast.into_iter().fold(slow, |largest_pole, pole| {
            if pole > FAST_POLE_RATIO * largest_pole { largest_pole } else { largest_pole.max(pole) }
        });
        let has_events_of_motion =
            terms.has_events() || output_effects.iter().any(|effect| effect.operator.has_events());
        let is_linear = effects.active().next().is_none();
        let has_linear_drive = command.drift == 0.0
            && terms == LoopTerms { bias: terms.bias, ..LoopTerms::linear(base.omega(), base.zeta()) };
        let is_linear_behind_command = output_effects.is_empty() && has_linear_drive;
        let is_led_by_turns =
            has_linear_drive && matches!(output_effects.as_slice(), [effect] if effect.operator.is_rate_independent());
        Self {
            base,
            order,
            is_linear,
            acts_behind_drive: !(output_effects.is_empty() && measurement_effects.is_empty()),
            is_linear_behind_command,
            is_led_by_turns,
            command,
            terms,
            output_effects,
            measurement_effects,
            largest_pole,
            accuracy: &Accuracy::EXACT,
            has_maps: false,
            has_whole_steps: false,
            natural_frequency: terms.natural_frequency(0.0),
            shortest_part: None,
            has_events_of_motion,
        }
    }

    /// As above, accurate to about 1e-6 of the motion and faster where effects act.
    #[must_use]
    pub fn approximate(self) -> Self {
        let has_whole_steps = self.command.delay == 0.0;
        let accuracy = &Accuracy::APPROXIMATE;
        let shortest_part = Self::shortest_part(self.natural_frequency, self.largest_pole, accuracy);
        Self { accuracy, has_maps: true, has_whole_steps, shortest_part, ..self }
    }

    /// Its parameters.
    #[must_use]
    pub fn base(&self) -> &Base {
        &self.base
    }

    /// Second or third order.
    #[must_use]
    pub fn order(&self) -> Order {
        self.order
    }

    /// Minimum and maximum position \[deg\].
    #[must_use]
    pub fn stops(&self) -> (f64, f64) {
        (self.terms.min, self.terms.max)
    }

    /// ∂(position, deflection)/∂(initial position) at rest: 1, but 0 where the measurement is quantised. Central difference.
    #[must_use]
    pub fn by_initial_position(&self, position: f64) -> [f64; 2] {
        let difference = 1e-6 * position.abs().max(1.0);
        let at = |position: f64| self.outputs(&self.at_rest(position));
        let (above, below) = (at(position + difference), at(position - difference));
        [above.position - below.position, above.deflection - below.deflection].map(|change| change / (2.0 * difference))
    }

    /// The equilibrium state at this position \[deg\], with the corresponding command.
    #[must_use]
    pub fn at_rest(&self, position: f64) -> State {
        let mut state = State {
            time: 0.0,
            pole: position,
            position,
            rate: 0.0,
            saturated: position <= self.terms.min || position >= self.terms.max,
            memory: [0.0; MEMORY],
            history: History::default(),
        };
        let rest = self.command_at_rest(position);
        self.command.start(&mut state.memory, rest);
        self.command.start_history(&mut state.history, rest);
        self.start_output_effects(&mut state, |_| true);
        state
    }

    /// The constant command before a start at rest at this position; if none holds it, the one that would without effects on the command.
    #[must_use]
    pub fn command_at_rest(&self, position: f64) -> f64 {
        self.holding_command(position).unwrap_or_else(|| self.undisturbed_command(position))
    }

    /// The constant command that holds this position through the effects on the command, if there is one.
    #[must_use]
    pub fn holding_command(&self, position: f64) -> Option<f64> {
        self.command.holding(self.undisturbed_command(position))
    }

    /// The position \[deg\] nearest to this one, between the stops, that a constant command can hold.
    #[must_use]
    pub fn nearest_held(&self, position: f64) -> f64 {
        let within = position.clamp(self.terms.min, self.terms.max);
        if self.holding_command(within).is_some() {
            return within;
        }
        let command = self.command.holding_nearest(self.undisturbed_command(within));
        let held = command.map_or(within, |command| self.base.k() * self.command.start(&mut [0.0; MEMORY], command));
        held.clamp(self.terms.min, self.terms.max)
    }

    fn undisturbed_command(&self, position: f64) -> f64 {
        if self.base.k() == 0.0 { 0.0 } else { position / self.base.k() }
    }

    /// Initializes the memory of the selected output effects.
    fn start_output_effects(&self, state: &mut State, is_selected: impl Fn(&OutputEffect) -> bool) {
        let mut value = state.position;
        for effect in &self.output_effects {
            let memory = &mut state.memory[effect.memory..];
            value = if is_selected(effect) {
                effect.operator.start(&effect.parameters, memory, value)
            } else {
                effect.operator.value(&effect.parameters, memory, value)
            };
        }
    }

    /// Adapts the state of an actuator with other parameters: the memory of effects that were neutral is initialized.
    pub fn transfer_state(&self, state: &mut State, before: &Self, command: f64) {
        if self.command.delay > 0.0 && before.command.delay == 0.0 {
            self.command.start_history(&mut state.history, command);
        } else if self.command.delay == 0.0 {
            state.history.clear();
        }
        self.command.start_new(&mut state.memory, &before.command, command);
        self.start_output_effects(state, |effect| {
            !before.output_effects.iter().any(|other| other.memory == effect.memory)
        });
    }

    /// Outputs in this state.
    #[must_use]
    pub fn outputs(&self, state: &State) -> Outputs {
        let (mut deflection, mut position) = (state.position, state.position);
        for effect in &self.output_effects {
            position = effect.operator.value(&effect.parameters, &state.memory[effect.memory..], position);
            if !effect.is_sensor {
                deflection = position;
            }
        }
        for effect in &self.measurement_effects {
            position = (effect.value)(&effect.parameters, state.time, position);
        }
        Outputs { position, deflection, rate: state.rate, saturated: state.saturated }
    }

    /// True where an effect acts between the drive and the measurement.
    #[must_use]
    #[inline]
    pub fn acts_behind_drive(&self) -> bool {
        self.acts_behind_drive
    }

    /// True where all effects are neutral: a step is then one transition.
    #[must_use]
    #[inline]
    pub fn is_linear(&self) -> bool {
        self.is_linear
    }

    /// ∂(position, rate) at the end of a step of this duration by the command held during it, without effects.
    #[must_use]
    pub fn by_command(&self, duration: f64) -> (f64, f64) {
        let change = Transition::new(self.base, self.order, duration).by_command();
        (change.y, change.z)
    }

    /// With one more effect behind the drive.
    #[cfg(test)]
    pub(crate) fn with_output_effect(mut self, operator: &'static dyn OutputOperator) -> Self {
        let effect = OutputEffect { operator, parameters: Vec::new(), memory: 0, condition_index: 0, is_sensor: false };
        self.output_effects.push(effect);
        (self.is_linear, self.is_linear_behind_command, self.acts_behind_drive) = (false, false, true);
        self
    }
}
