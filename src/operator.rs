//! What an effect on a signal has to say for itself: on the command, which is made of straight pieces, and on the motion, which
//! is made of series.

use serde::{Deserialize, Serialize};

use crate::series::{Range, Series};

/// A signal that moves linearly for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// At its start [deg].
    pub value: f64,
    /// [deg/s]
    pub slope: f64,
    /// For how long this holds [s].
    pub length: f64,
    /// Two instants nearer to each other than this are one [s].
    pub instant: f64,
}

impl Piece {
    /// The value after a time [s].
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        self.value + self.slope * time
    }

    /// Differences from a level that are rounding: it would take no time to cross them, and they would be crossed for ever.
    fn rounding(&self, level: f64) -> f64 {
        const ROUNDINGS: f64 = 8.0 * f64::EPSILON;
        const INSTANTS: f64 = 4.0;
        let moved = (self.slope * self.length).abs();
        ROUNDINGS * (self.value.abs() + level.abs() + moved) + INSTANTS * (self.slope * self.instant).abs()
    }

    /// True where it is at the level, but for a rounding.
    #[must_use]
    pub fn is_at(&self, level: f64) -> bool {
        (self.value - level).abs() <= self.rounding(level)
    }

    /// Above the level, or at it and on its way up.
    #[must_use]
    pub fn is_above(&self, level: f64) -> bool {
        if self.is_at(level) { self.slope > 0.0 } else { self.value > level }
    }

    /// Below the level, or at it and on its way down.
    #[must_use]
    pub fn is_below(&self, level: f64) -> bool {
        if self.is_at(level) { self.slope < 0.0 } else { self.value < level }
    }

    /// The time [s] until it reaches a level towards which it moves, or its length if it does not get there.
    #[must_use]
    pub fn until(&self, level: f64) -> f64 {
        let time = (level - self.value) / self.slope;
        if time > 0.0 && !self.is_at(level) { time.min(self.length) } else { self.length }
    }

    /// The same for a shorter while.
    #[must_use]
    pub fn for_at_most(self, length: f64) -> Self {
        Self { length: self.length.min(length), ..self }
    }
}

/// What an effect waits for where a solver integrates: chosen at events, kept between them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Watch {
    /// Nothing.
    Nothing,
    /// Its input leaves this range [deg].
    Input(Range),
    /// The slope of its input leaves this range [deg/s].
    Slope(Range),
    /// Its input less its output leaves this range [deg].
    Gap(Range),
}

impl Watch {
    /// How far the watched quantity is inside its range, from both ends: negative where it has left.
    #[must_use]
    pub fn margins(&self, input: Signal, output: f64) -> [f64; 2] {
        match self {
            Self::Nothing => [1.0; 2],
            Self::Input(range) => range.margins(input.value),
            Self::Slope(range) => range.margins(input.slope),
            Self::Gap(range) => range.margins(input.value - output),
        }
    }
}

/// A signal at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signal {
    /// [deg]
    pub value: f64,
    /// [deg/s]
    pub slope: f64,
}

/// An effect on the command. Straight pieces stay straight pieces, so that it is exact.
pub trait CommandOperator: Sync {
    /// Fills the memory for a command that has always been at rest; returns what comes out.
    fn start(&self, parameters: &[f64], memory: &mut [f64], rest: f64) -> f64;

    /// What comes out while `input` lasts, or the first piece of it.
    fn piece(&self, parameters: &[f64], memory: &[f64], input: Piece) -> Piece;

    /// Takes the memory forward by `time` [s], which is at most the length of the piece that came out.
    fn advance(&self, _parameters: &[f64], _memory: &mut [f64], _input: Piece, _time: f64) {}

    /// Where a solver integrates: the bend of the characteristic that it should stop at.
    fn watch(&self, _parameters: &[f64], _memory: &[f64], _input: Piece) -> Watch {
        Watch::Nothing
    }
}

/// One segment of a motion.
#[derive(Debug, Clone, Copy)]
pub struct Segment {
    /// Its length [s].
    pub length: f64,
    /// Largest of the poles that series follow [1/s]; a pole far above it makes a decay.
    pub fastest: f64,
    /// Coefficients that series of these poles need.
    pub terms: usize,
    /// Differences of positions below this are rounding [deg].
    pub tolerance: f64,
}

/// A pole is followed by decays, not by series, when it is this many times larger than all that series follow.
pub const FAR_ABOVE: f64 = 4.0;

/// What an effect makes of a segment.
#[derive(Debug, Clone, Copy)]
pub struct Answer {
    /// What comes out.
    pub output: Series,
    /// The instant τ at which this ceases to hold, if that is within the segment.
    pub until: Option<f64>,
}

impl From<Series> for Answer {
    /// Holds to the end of the segment.
    fn from(output: Series) -> Self {
        Self { output, until: None }
    }
}

/// A number that an effect on the motion remembers, where a solver integrates it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remembered {
    /// Name behind that of the effect.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Size of a usual value, for solvers that scale.
    pub nominal: f64,
    /// What it is.
    pub meaning: &'static str,
}

/// An effect on the motion or on its measurement.
pub trait OutputOperator: Sync {
    /// Fills the memory for a motion that has always been at rest; returns what comes out.
    fn start(&self, parameters: &[f64], memory: &mut [f64], rest: f64) -> f64;

    /// What comes out now, while `input` comes in.
    fn value(&self, parameters: &[f64], memory: &[f64], input: f64) -> f64;

    /// Its largest pole that series must follow [1/s].
    fn pole(&self, _parameters: &[f64]) -> f64 {
        0.0
    }

    /// Its pole that decays follow where it is far above the others [1/s].
    fn far_pole(&self, _parameters: &[f64]) -> f64 {
        0.0
    }

    /// What it makes of the input over a segment.
    fn answer(&self, parameters: &[f64], memory: &[f64], input: &Series, segment: Segment) -> Answer;

    /// Takes the memory forward to τ of the segment.
    fn advance(
        &self,
        parameters: &[f64],
        memory: &mut [f64],
        input: &Series,
        output: &Series,
        segment: Segment,
        tau: f64,
    );

    /// What a number of its memory is.
    fn remembered(&self, index: usize) -> Remembered {
        const NAMES: [&str; 4] = ["first", "second", "third", "fourth"];
        Remembered { name: NAMES[index.min(3)], unit: "1", nominal: 1.0, meaning: "memory" }
    }

    /// Where a solver integrates: what it should stop at from here on. The memory is put right where it has to be.
    fn watch(&self, _parameters: &[f64], _memory: &mut [f64], _input: Signal) -> Watch {
        Watch::Nothing
    }

    /// Rates of its memory, per second; they stay zero where nothing is said.
    fn rates(&self, _parameters: &[f64], _memory: &[f64], _input: Signal, _watch: Watch, _into: &mut [f64]) {}

    /// Slope of what comes out.
    fn slope(&self, _parameters: &[f64], _memory: &[f64], input: Signal, _watch: Watch) -> f64 {
        input.slope
    }
}
