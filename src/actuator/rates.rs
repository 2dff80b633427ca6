//! The actuator as a system of differential equations that switches, for a solver that integrates it.
//!
//! ```text
//! states      x, δ, δ̇, and what the effects behind the drive remember
//! ẋ = p (k_t c - x)      (order 2: x = k_t c, and the state stands still)
//! δ̇, δ̈                   of the drive in its mode (motion/mode.rs)
//! ```
//!
//! Modes are chosen by [`Actuator::settle`] at events and kept between them. A margin is positive while what holds in a mode does;
//! it becomes negative where the mode ends.

use serde::{Deserialize, Serialize};

use super::{Actuator, Failure, State};
use crate::{
    command::Knot,
    effects::{INTEGRATED, MEMORY, UNLIMITED, WATCHING},
    motion::{Acting, LoopTerms, Mode, Point, Power},
    operator::{Piece, Signal, Watch},
    parameters::Order,
    transition::Ramp,
};

/// Modes of everything that switches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Modes {
    drive: Mode,
    failure: Failure,
    /// Of every effect that may wait for something, active or not.
    watches: Vec<Watch>,
}

/// What comes in at an instant.
#[derive(Debug, Clone)]
pub struct Surroundings {
    /// What comes out of the command side [deg].
    command: f64,
    /// Its slope, where it is known [deg/s].
    slope: f64,
    /// What its effects get.
    pieces: Vec<Piece>,
    /// Their memories.
    memory: [f64; MEMORY],
    /// The past command.
    history: Vec<Knot>,
    /// Hinge load [deg], and its slope where it is known.
    load: Ramp,
}

/// Rates of the states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// ẋ [deg/s]
    pub pole: f64,
    /// [deg/s]
    pub position: f64,
    /// [deg/s²]
    pub rate: f64,
    /// Of the memory of the effects behind the drive.
    pub memory: [f64; INTEGRATED],
}

/// Where the memory of the effects behind the drive begins.
pub(crate) const FIRST_INTEGRATED: usize = MEMORY - INTEGRATED;

impl Actuator {
    /// Numbers that [`Actuator::margins`] gives.
    pub const MARGINS: usize = LoopTerms::MARGINS + 2 * WATCHING;

    /// The command side, followed along a straight piece that started at `from` [s], for a state in which it was known until then.
    /// The past is taken as far as knots before `until` [s] say.
    #[must_use]
    pub fn surroundings(&self, state: &State, (from, until): (f64, f64), command: Piece, load: Ramp) -> Surroundings {
        let (mut memory, mut history, mut pieces) = (state.memory, state.history.clone(), Vec::new());
        let reached = self.command.follow(&mut history, &mut memory, (from, until), command, &mut pieces);
        Surroundings { command: reached.value, slope: reached.slope, pieces, memory, history, load }
    }

    /// Takes over what the surroundings know of the command's past.
    pub fn remember(&self, state: &mut State, surroundings: &Surroundings) {
        state.memory[..FIRST_INTEGRATED].copy_from_slice(&surroundings.memory[..FIRST_INTEGRATED]);
        state.history.clone_from(&surroundings.history);
    }

    /// Delay of the command [s].
    #[must_use]
    pub fn delay(&self) -> f64 {
        self.command.delay
    }

    fn acting(&self, state: &State, failure: Failure, around: &Surroundings) -> Acting {
        let terms = &self.terms;
        let demand = self.command.demand_at(around.command, state.time);
        let (followed, slope) = match self.order {
            Order::Third => (state.pole, self.base.p() * (demand - state.pole)),
            Order::Second => (demand, self.command.demand_at(around.slope, state.time)),
        };
        let Ramp { value: load, slope: pull } = around.load;
        let on = |target: f64, slope: f64| Acting { target, load, slopes: [slope, pull], power: Power::On };
        match failure {
            Failure::None => on(followed, slope),
            Failure::Passive => Acting { power: Power::Off, ..on(followed, slope) },
            Failure::Stuck => Acting { power: Power::Stuck, ..on(followed, slope) },
            Failure::HardoverPositive => on(terms.max.min(UNLIMITED), 0.0),
            Failure::HardoverNegative => on(terms.min.max(-UNLIMITED), 0.0),
        }
    }

    /// The modes from here on; states are put right where they have reached a limit.
    #[must_use]
    pub fn settle(&self, state: &mut State, before: Option<&Modes>, failure: Failure, around: &Surroundings) -> Modes {
        let acting = self.acting(state, failure, around);
        let from = Point { position: state.position, rate: state.rate };
        let (point, drive) = self.terms.settle(before.map(|modes| modes.drive), from, acting);
        (state.position, state.rate, state.saturated) = (point.position, point.rate, drive.is_saturated());
        let mut watches = vec![Watch::Nothing; WATCHING];
        self.command.watch(&around.memory, &around.pieces, &mut watches);
        let [slope, _] = self.terms.rates(drive, point, acting);
        let mut signal = Signal { value: state.position, slope };
        for stage in &self.stages {
            let memory = &mut state.memory[stage.memory..];
            let watch = stage.operator.watch(&stage.parameters, memory, signal);
            let slope = stage.operator.slope(&stage.parameters, memory, signal, watch);
            signal = Signal { value: stage.operator.value(&stage.parameters, memory, signal.value), slope };
            watches[stage.place] = watch;
        }
        Modes { drive, failure, watches }
    }

    /// Rates of the states in these modes.
    #[must_use]
    pub fn rates(&self, state: &State, modes: &Modes, around: &Surroundings) -> Rates {
        let pole = match self.order {
            Order::Third => self.base.p() * (self.command.demand_at(around.command, state.time) - state.pole),
            Order::Second => 0.0,
        };
        let mut memory = [0.0; MEMORY];
        let [position, rate] = self.walk(state, modes, around, |stage, input, _, watch| {
            let into = &mut memory[stage.memory..];
            stage.operator.rates(&stage.parameters, &state.memory[stage.memory..], input, watch, into);
        });
        let mut rates = Rates { pole, position, rate, memory: [0.0; INTEGRATED] };
        rates.memory.copy_from_slice(&memory[FIRST_INTEGRATED..]);
        rates
    }

    /// How far everything is inside what holds in these modes.
    #[must_use]
    pub fn margins(&self, state: &State, modes: &Modes, around: &Surroundings) -> [f64; Self::MARGINS] {
        let mut margins = [1.0; Self::MARGINS];
        let (drive, effects) = margins.split_at_mut(LoopTerms::MARGINS);
        let point = Point { position: state.position, rate: state.rate };
        drive.copy_from_slice(&self.terms.margins(modes.drive, point, self.acting(state, modes.failure, around)));
        self.command.margins(&modes.watches, &around.pieces, around.command, effects);
        self.walk(state, modes, around, |stage, input, output, watch| {
            effects[2 * stage.place..][..2].copy_from_slice(&watch.margins(input, output));
        });
        margins
    }

    /// Goes from the drive through the effects behind it, with what each gets, gives and waits for; rates of the drive.
    fn walk(
        &self,
        state: &State,
        modes: &Modes,
        around: &Surroundings,
        mut visit: impl FnMut(&super::Stage, Signal, f64, Watch),
    ) -> [f64; 2] {
        let point = Point { position: state.position, rate: state.rate };
        let rates = self.terms.rates(modes.drive, point, self.acting(state, modes.failure, around));
        let mut signal = Signal { value: state.position, slope: rates[0] };
        for stage in &self.stages {
            let (memory, watch) = (&state.memory[stage.memory..], modes.watches[stage.place]);
            let value = stage.operator.value(&stage.parameters, memory, signal.value);
            visit(stage, signal, value, watch);
            signal = Signal { value, slope: stage.operator.slope(&stage.parameters, memory, signal, watch) };
        }
        rates
    }

    /// True where a command effect waits for something else now than it did: a turn that no margin shows.
    #[must_use]
    pub fn has_turned(&self, modes: &Modes, around: &Surroundings) -> bool {
        let mut watches = vec![Watch::Nothing; WATCHING];
        self.command.watch(&around.memory, &around.pieces, &mut watches);
        let is_idle = |watch: &Watch| *watch == Watch::Nothing;
        self.command.places().any(|place| is_idle(&watches[place]) != is_idle(&modes.watches[place]))
    }
}

impl Modes {
    /// False where they cannot be those of any actuator.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.watches.len() == WATCHING
    }
}
