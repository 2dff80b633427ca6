//! Interfaces of the effects that map a signal onto a signal: [`CommandOperator`] for the piecewise linear command,
//! [`OutputOperator`] for the motion, which is given as series.

use serde::{Deserialize, Serialize};

use crate::series::{Range, Series};

/// One linear piece of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Value at its start \[deg\].
    pub value: f64,
    /// [deg/s]
    pub slope: f64,
    /// Duration \[s\].
    pub length: f64,
    /// Instants closer than this are equal \[s\].
    pub time_resolution: f64,
}

impl Piece {
    /// The value after a time \[s\].
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        self.value + self.slope * time
    }

    /// Maximum difference from a level that is attributed to rounding: eight roundings of value, level and change over the piece, and four
    /// times the time resolution. A crossing of that size would take no time, and events would accumulate.
    fn rounding(&self, level: f64) -> f64 {
        const ROUNDINGS: f64 = 8.0 * f64::EPSILON;
        const INSTANTS: f64 = 4.0;
        let moved = (self.slope * self.length).abs();
        ROUNDINGS * (self.value.abs() + level.abs() + moved) + INSTANTS * (self.slope * self.time_resolution).abs()
    }

    /// True if it equals the level within rounding.
    #[must_use]
    pub fn is_at(&self, level: f64) -> bool {
        (self.value - level).abs() <= self.rounding(level)
    }

    /// Above the level, or at it and rising.
    #[must_use]
    pub fn is_above(&self, level: f64) -> bool {
        if self.is_at(level) { self.slope > 0.0 } else { self.value > level }
    }

    /// Below the level, or at it and falling.
    #[must_use]
    pub fn is_below(&self, level: f64) -> bool {
        if self.is_at(level) { self.slope < 0.0 } else { self.value < level }
    }

    /// The time \[s\] until it reaches a level, or its length where it does not.
    #[must_use]
    pub fn time_until(&self, level: f64) -> f64 {
        let time = (level - self.value) / self.slope;
        if time > 0.0 && !self.is_at(level) { time.min(self.length) } else { self.length }
    }

    /// As above, limited to this length \[s\].
    #[must_use]
    pub fn limited_to(self, length: f64) -> Self {
        Self { length: self.length.min(length), ..self }
    }
}

/// The condition of the current mode of an effect, for ODE solvers: selected at events, constant between them. The next event is where it
/// ceases to hold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum EventCondition {
    /// No condition.
    None,
    /// The input is in this range \[deg\].
    Input(Range),
    /// The slope of the input is in this range [deg/s].
    Slope(Range),
    /// Input minus output is in this range \[deg\].
    Difference(Range),
}

impl EventCondition {
    /// Distances of the quantity from both ends of its range: negative outside.
    #[must_use]
    pub fn event_indicators(&self, input: Signal, output: f64) -> [f64; 2] {
        match self {
            Self::None => [1.0; 2],
            Self::Input(range) => range.distances(input.value, 1.0),
            Self::Slope(range) => range.distances(input.slope, 1.0),
            Self::Difference(range) => range.distances(input.value - output, 1.0),
        }
    }
}

/// A signal at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signal {
    /// \[deg\]
    pub value: f64,
    /// [deg/s]
    pub slope: f64,
}

/// An effect on the command. It maps linear pieces onto linear pieces, so that it is exact.
pub trait CommandOperator: Sync {
    /// Initializes the memory for a constant command; returns the output.
    fn start(&self, parameters: &[f64], memory: &mut [f64], rest: f64) -> f64;

    /// The constant command that results in this output, if there is one.
    fn holding(&self, _parameters: &[f64], output: f64) -> Option<f64> {
        Some(output)
    }

    /// The nearest output that a constant input can hold.
    fn nearest_output(&self, _parameters: &[f64], output: f64) -> f64 {
        output
    }

    /// The first linear piece of the output for this input.
    fn piece(&self, parameters: &[f64], memory: &[f64], input: Piece) -> Piece;

    /// Advances the memory by `time` \[s\], which is at most the length of the output piece.
    fn advance(&self, _parameters: &[f64], _memory: &mut [f64], _input: Piece, _time: f64) {}

    /// The start of the output, if one piece of it lasts as long as the input. As [`Self::piece`], for steps in large numbers: values
    /// written one by one are not read back as one wide value.
    fn whole_piece(
        &self,
        parameters: &[f64],
        memory: &[f64],
        input: Signal,
        length: f64,
        resolution: f64,
    ) -> Option<Signal> {
        let Signal { value, slope } = input;
        let output = self.piece(parameters, memory, Piece { value, slope, length, time_resolution: resolution });
        (output.length >= length).then_some(Signal { value: output.value, slope: output.slope })
    }

    /// Advances the memory over such an input.
    fn advance_whole(&self, parameters: &[f64], memory: &mut [f64], input: Signal, length: f64, resolution: f64) {
        let Signal { value, slope } = input;
        self.advance(parameters, memory, Piece { value, slope, length, time_resolution: resolution }, length);
    }

    /// The condition of the current branch of the characteristic, for ODE solvers.
    fn event_condition(&self, _parameters: &[f64], _memory: &[f64], _input: Piece) -> EventCondition {
        EventCondition::None
    }
}

/// One segment of a motion.
#[derive(Debug, Clone, Copy)]
pub struct Segment {
    /// Its length \[s\].
    pub length: f64,
    /// Largest magnitude of the poles represented by Taylor series [1/s]; faster poles are represented by decays.
    pub largest_pole: f64,
    /// Number of coefficients these poles need.
    pub terms: usize,
    /// A coefficient below this fraction of the largest is not computed.
    pub negligible: f64,
    /// Differences of positions below this are rounding errors \[deg\].
    pub tolerance: f64,
    /// τ of the first event known so far, 1 if there is none: later ones do not matter.
    pub until: f64,
}

/// Ratio to all poles of the series from which a pole is represented by a decay instead of a Taylor series.
pub const FAST_POLE_RATIO: f64 = 4.0;

/// Response of an effect over a segment.
#[derive(Debug, Clone, Copy)]
pub struct SegmentResponse {
    /// Output.
    pub output: Series,
    /// τ of the first event within the segment, after which the response is not valid.
    pub valid_until: Option<f64>,
}

impl From<Series> for SegmentResponse {
    /// Valid to the end of the segment.
    fn from(output: Series) -> Self {
        Self { output, valid_until: None }
    }
}

/// Description of a continuous state of an effect, for ODE solvers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateVariable {
    /// Name after that of the effect.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Typical magnitude, for solvers that scale.
    pub nominal: f64,
    /// What it is.
    pub meaning: &'static str,
}

/// An effect on the motion or on its measurement.
pub trait OutputOperator: Sync {
    /// Initializes the memory for a constant input; returns the output.
    fn start(&self, parameters: &[f64], memory: &mut [f64], rest: f64) -> f64;

    /// Output for this input at the current memory.
    fn value(&self, parameters: &[f64], memory: &[f64], input: f64) -> f64;

    /// Its largest pole represented by Taylor series [1/s].
    fn pole(&self, _parameters: &[f64]) -> f64 {
        0.0
    }

    /// Its pole represented by a decay if much faster than the others [1/s].
    fn fast_pole(&self, _parameters: &[f64]) -> f64 {
        0.0
    }

    /// Response to the input over a segment.
    fn segment_response(&self, parameters: &[f64], memory: &[f64], input: &Series, segment: Segment)
    -> SegmentResponse;

    /// Advances the memory to τ of the segment.
    fn advance(
        &self,
        parameters: &[f64],
        memory: &mut [f64],
        input: &Series,
        output: &Series,
        segment: Segment,
        tau: f64,
    );

    /// True if its output depends only on the sequence of input values, at any rate: [`Self::follow`].
    fn is_rate_independent(&self) -> bool {
        false
    }

    /// Advances the memory for an input that moves monotonically to this value.
    fn follow(&self, _parameters: &[f64], _memory: &mut [f64], _input: f64) {}

    /// Describes one entry of its memory.
    fn state_variable(&self, index: usize) -> StateVariable {
        const NAMES: [&str; 4] = ["first", "second", "third", "fourth"];
        StateVariable { name: NAMES[index.min(3)], unit: "1", nominal: 1.0, meaning: "memory" }
    }

    /// True if it switches between modes, in each of which it is linear.
    fn has_events(&self) -> bool {
        false
    }

    /// Selects the mode for an ODE solver and returns its condition; projects the memory onto the mode.
    fn event_condition(&self, _parameters: &[f64], _memory: &mut [f64], _input: Signal) -> EventCondition {
        EventCondition::None
    }

    /// Derivatives of its memory [1/s]; zero by default.
    fn memory_derivatives(
        &self,
        _parameters: &[f64],
        _memory: &[f64],
        _input: Signal,
        _condition: EventCondition,
        _into: &mut [f64],
    ) {
    }

    /// Derivative of the output [deg/s].
    fn slope(&self, _parameters: &[f64], _memory: &[f64], input: Signal, _condition: EventCondition) -> f64 {
        input.slope
    }
}
