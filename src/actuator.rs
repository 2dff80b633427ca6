//! The actuator: constants in [`Actuator`], memory in [`State`], and the step from one communication point to the next.
//!
//! With all effects neutral a step is one linear [`transition`](crate::transition). Otherwise it is cut where the command side bends. Each
//! piece is a transition where nothing acts behind the command; else it is cut into segments that series can follow, then at events.

mod path;
mod rates;

use nalgebra::Vector3;
pub(crate) use rates::FIRST_INTEGRATED;
pub use rates::{Modes, Rates, Surroundings};
use serde::{Deserialize, Serialize};

use crate::{
    command::{CommandSide, Knot},
    effects::{Act, Effects, MEMORY, UNLIMITED},
    error::{Error, Result},
    motion::LoopTerms,
    operator::{FAR_ABOVE, OutputOperator, Piece},
    parameters::{Base, Order},
    transition::{Ramp, Transition},
};

/// A failure of the drive.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Failure {
    /// None.
    #[default]
    None,
    /// The drive is off: the surface floats, with its damping and loads.
    Passive,
    /// It stays where it is.
    Stuck,
    /// It is driven to the upper stop, through its limits.
    HardoverPositive,
    /// It is driven to the lower stop.
    HardoverNegative,
}

impl Failure {
    /// All of them, in their order.
    pub const ALL: &'static [Self] =
        &[Self::None, Self::Passive, Self::Stuck, Self::HardoverPositive, Self::HardoverNegative];
    /// Their names.
    pub const NAMES: &'static [&'static str] = &["none", "passive", "stuck", "hardover_positive", "hardover_negative"];
}

/// What comes in during a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// Command [deg].
    pub command: Ramp,
    /// Hinge load [deg].
    pub load: Ramp,
    /// Failure.
    pub failure: Failure,
}

impl Inputs {
    /// A command alone.
    #[must_use]
    pub fn command(command: Ramp) -> Self {
        Self { command, ..Self::default() }
    }
}

/// What goes out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// Measured position [deg].
    pub position: f64,
    /// Deflection of the surface [deg].
    pub deflection: f64,
    /// Rate of the drive [deg/s].
    pub rate: f64,
    /// A limit of rate, acceleration or position is active.
    pub saturated: bool,
}

/// What changes while it moves: plain data, to be cloned, saved and compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Since the start [s].
    pub time: f64,
    /// Pole state x [deg]; k c for order 2.
    pub pole: f64,
    /// Position δ of the drive [deg].
    pub position: f64,
    /// Rate δ̇ of the drive [deg/s].
    pub rate: f64,
    /// A limit was active at the end of the last step.
    pub saturated: bool,
    /// Memory of the effects, in the order of the chain.
    pub memory: [f64; MEMORY],
    /// Past command, as far as the delay reaches.
    pub history: Vec<Knot>,
}

impl State {
    /// Along a straight command, under a steady load that shifts the position by as much.
    fn glide(&mut self, transition: &Transition, command: Ramp, load: f64) {
        let before = Vector3::new(self.pole, self.position - load, self.rate);
        let after = transition.apply(before, command);
        (self.pole, self.position, self.rate) = (after.x, after.y + load, after.z);
        self.saturated = false;
    }
}

/// What a step leaves for the next one to use again: nothing that a result depends on.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    /// Transitions of the step sizes met lately. Masters repeat one, or a few that differ in the last bits.
    recent: Vec<Transition>,
    oldest: usize,
    pieces: Vec<Piece>,
    course: path::Course,
}

impl Workspace {
    const KEPT: usize = 4;

    fn transition(&mut self, actuator: &Actuator, duration: f64) -> &Transition {
        let known = self.recent.iter().position(|transition| transition.duration() == duration);
        let index = known.unwrap_or_else(|| {
            let made = Transition::new(actuator.base, actuator.order, duration);
            if self.recent.len() < Self::KEPT {
                self.recent.push(made);
                return self.recent.len() - 1;
            }
            let index = self.oldest;
            self.oldest = (index + 1) % Self::KEPT;
            self.recent[index] = made;
            index
        });
        &self.recent[index]
    }

    /// To be called when the parameters change.
    pub fn forget(&mut self) {
        self.recent.clear();
        self.oldest = 0;
    }
}

/// An effect on the motion with its parameters and where its memory starts.
struct Stage {
    operator: &'static dyn OutputOperator,
    parameters: Vec<f64>,
    memory: usize,
    /// Among the effects that watch something.
    place: usize,
    /// Behind this stage the deflection is no longer touched.
    is_sensor: bool,
}

/// An effect on the reading with its parameters.
struct Reading {
    value: fn(&[f64], f64, f64) -> f64,
    slope: fn(&[f64], f64) -> f64,
    parameters: Vec<f64>,
}

/// What does not change while it moves.
pub struct Actuator {
    base: Base,
    order: Order,
    /// No effect is active: one transition is the whole step.
    is_linear: bool,
    /// No effect acts on the motion or behind it: where the command is straight, a transition is exact.
    is_linear_behind_command: bool,
    command: CommandSide,
    terms: LoopTerms,
    stages: Vec<Stage>,
    readings: Vec<Reading>,
    /// Largest of the poles that series follow [1/s].
    fastest: f64,
}

impl Actuator {
    /// Eq. (1) or eq. (6) with these parameters and effects.
    #[must_use]
    pub fn new(base: Base, order: Order, effects: &Effects) -> Self {
        let mut terms = LoopTerms::linear(base.omega(), base.zeta());
        let (mut stages, mut readings) = (Vec::new(), Vec::new());
        let mut command = CommandSide::new(base.k());
        let (mut memory, mut place) = (0, 0);
        for (effect, values) in effects.iter() {
            if !effect.is_neutral(values) {
                let parameters = values.to_vec();
                match &effect.act {
                    Act::Delay => command.delay = values[0],
                    Act::Command(operator) => command.add(*operator, parameters, memory, place),
                    Act::GainDrift(rate) => command.drift = rate(values),
                    Act::Loop(change) => change(values, &mut terms),
                    Act::Surface(operator) => {
                        stages.push(Stage { operator: *operator, parameters, memory, place, is_sensor: false })
                    }
                    Act::Sensor(operator) => {
                        stages.push(Stage { operator: *operator, parameters, memory, place, is_sensor: true })
                    }
                    Act::Reading { value, slope } => {
                        readings.push(Reading { value: *value, slope: *slope, parameters })
                    }
                }
            }
            memory += effect.memory;
            place += usize::from(effect.act.watches());
        }
        // Neutral limits are large numbers in files and in the FMU; here they are none.
        for limit in [&mut terms.up, &mut terms.down, &mut terms.max, &mut terms.acceleration] {
            *limit = if *limit >= UNLIMITED { f64::INFINITY } else { *limit };
        }
        terms.min = if terms.min <= -UNLIMITED { f64::NEG_INFINITY } else { terms.min };
        let poles = stages.iter().map(|stage| stage.operator.pole(&stage.parameters));
        let followed = poles.fold(terms.pole(0.0), f64::max);
        let mut far: Vec<f64> = stages.iter().map(|stage| stage.operator.far_pole(&stage.parameters)).collect();
        far.push(if order == Order::Third { base.p() } else { 0.0 });
        far.sort_by(f64::total_cmp);
        let fastest = far
            .into_iter()
            .fold(followed, |fastest, pole| if pole > FAR_ABOVE * fastest { fastest } else { fastest.max(pole) });
        let is_linear = effects.active().next().is_none();
        let is_linear_behind_command = stages.is_empty()
            && command.drift == 0.0
            && terms == LoopTerms { bias: terms.bias, ..LoopTerms::linear(base.omega(), base.zeta()) };
        Self { base, order, is_linear, is_linear_behind_command, command, terms, stages, readings, fastest }
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

    /// Least and greatest position [deg].
    #[must_use]
    pub fn stops(&self) -> (f64, f64) {
        (self.terms.min, self.terms.max)
    }

    /// ∂(position, deflection) at rest by the position at rest: 1, but 0 where the measurement comes in steps.
    #[must_use]
    pub fn by_initial_position(&self, position: f64) -> [f64; 2] {
        let difference = 1e-6 * position.abs().max(1.0);
        let at = |position: f64| self.outputs(&self.at_rest(position));
        let (above, below) = (at(position + difference), at(position - difference));
        [above.position - below.position, above.deflection - below.deflection].map(|change| change / (2.0 * difference))
    }

    /// At rest at a position [deg], under the command that holds it there.
    #[must_use]
    pub fn at_rest(&self, position: f64) -> State {
        let mut state = State {
            time: 0.0,
            pole: position,
            position,
            rate: 0.0,
            saturated: position <= self.terms.min || position >= self.terms.max,
            memory: [0.0; MEMORY],
            history: Vec::new(),
        };
        let rest = if self.base.k() == 0.0 { 0.0 } else { position / self.base.k() };
        self.command.start(&mut state.memory, rest);
        self.command.begin_history(&mut state.history, rest);
        self.start_stages(&mut state, |_| true);
        state
    }

    fn start_stages(&self, state: &mut State, wanted: impl Fn(&Stage) -> bool) {
        let mut value = state.position;
        for stage in &self.stages {
            let memory = &mut state.memory[stage.memory..];
            value = if wanted(stage) {
                stage.operator.start(&stage.parameters, memory, value)
            } else {
                stage.operator.value(&stage.parameters, memory, value)
            };
        }
    }

    /// Takes over a state from an actuator whose parameters were others: effects that are new start from what they meet.
    pub fn adopt(&self, state: &mut State, before: &Self, command: f64) {
        if self.command.delay > 0.0 && before.command.delay == 0.0 {
            self.command.begin_history(&mut state.history, command);
        } else if self.command.delay == 0.0 {
            state.history.clear();
        }
        self.command.start_new(&mut state.memory, &before.command, command);
        self.start_stages(state, |stage| !before.stages.iter().any(|other| other.memory == stage.memory));
    }

    /// Moves the state through `duration` [s] > 0.
    ///
    /// # Errors
    /// A motion that leaves the range of numbers.
    pub fn step(&self, state: &mut State, workspace: &mut Workspace, inputs: Inputs, duration: f64) -> Result<()> {
        let unloaded = inputs.load == Ramp::default() && inputs.failure == Failure::None;
        if self.is_linear && unloaded {
            state.glide(workspace.transition(self, duration), inputs.command, 0.0);
            state.time += duration;
        } else {
            self.follow(state, workspace, inputs, duration)?;
        }
        if [state.pole, state.position, state.rate].iter().chain(&state.memory).all(|number| number.is_finite()) {
            return Ok(());
        }
        Err(Error::new(
            "motion in this step",
            format!("{} deg at {} deg/s", state.position, state.rate),
            "finite numbers",
        ))
    }

    /// What goes out now.
    #[must_use]
    pub fn outputs(&self, state: &State) -> Outputs {
        let (mut deflection, mut position) = (state.position, state.position);
        for stage in &self.stages {
            position = stage.operator.value(&stage.parameters, &state.memory[stage.memory..], position);
            if !stage.is_sensor {
                deflection = position;
            }
        }
        for reading in &self.readings {
            position = (reading.value)(&reading.parameters, state.time, position);
        }
        Outputs { position, deflection, rate: state.rate, saturated: state.saturated }
    }

    /// True where no effect acts: a step is then one transition.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        self.is_linear
    }

    /// ∂(position, rate) at the end of a step of this duration by the command held through it, without effects.
    #[must_use]
    pub fn by_command(&self, duration: f64) -> (f64, f64) {
        let change = Transition::new(self.base, self.order, duration).by_command();
        (change.y, change.z)
    }
}
