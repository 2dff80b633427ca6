//! The command side: delay, then the effects on the command, exact for piecewise linear commands.

mod history;

pub use history::{Change, History, Knot};

use history::Past;

use crate::operator::{CommandOperator, EventCondition, Piece, Signal};

/// Capacity for effects on the command, above their number.
pub const MOST_EFFECTS: usize = 8;

/// The inputs of the effects on the command, in their order.
#[derive(Debug, Clone, Copy)]
pub struct EffectInputs {
    pieces: [Piece; MOST_EFFECTS],
    count: usize,
}

impl Default for EffectInputs {
    fn default() -> Self {
        let none = Piece { value: 0.0, slope: 0.0, length: 0.0, time_resolution: 0.0 };
        Self { pieces: [none; MOST_EFFECTS], count: 0 }
    }
}

impl EffectInputs {
    fn push(&mut self, piece: Piece) {
        self.pieces[self.count] = piece;
        self.count += 1;
    }

    fn iter(&self) -> impl Iterator<Item = &Piece> {
        self.pieces[..self.count].iter()
    }
}

/// An effect on the command.
struct CommandEffect {
    operator: &'static dyn CommandOperator,
    parameters: Vec<f64>,
    /// Index of its first entry in the memory.
    memory: usize,
    /// Index among the effects with event conditions.
    condition_index: usize,
}

/// Everything between the command and the servo.
pub struct CommandSide {
    /// Transport delay \[s\].
    pub delay: f64,
    /// Relative change of the gain [1/s].
    pub drift: f64,
    gain: f64,
    effects: Vec<CommandEffect>,
}

impl CommandSide {
    /// The gain k without effects.
    #[must_use]
    pub fn new(gain: f64) -> Self {
        Self { delay: 0.0, drift: 0.0, gain, effects: Vec::new() }
    }

    /// Appends an effect.
    pub fn add(
        &mut self,
        operator: &'static dyn CommandOperator,
        parameters: Vec<f64>,
        memory: usize,
        condition_index: usize,
    ) {
        self.effects.push(CommandEffect { operator, parameters, memory, condition_index });
    }

    /// Initializes the memory for a constant command; returns the output.
    pub fn start(&self, memory: &mut [f64], rest: f64) -> f64 {
        self.effects
            .iter()
            .fold(rest, |rest, effect| effect.operator.start(&effect.parameters, &mut memory[effect.memory..], rest))
    }

    /// Initializes the memory of the effects that another command side does not have.
    pub fn start_new(&self, memory: &mut [f64], before: &Self, command: f64) {
        self.effects.iter().fold(command, |value, effect| {
            if before.effects.iter().any(|other| other.memory == effect.memory) {
                let now = Piece { value, slope: 0.0, length: 0.0, time_resolution: 0.0 };
                effect.operator.piece(&effect.parameters, &memory[effect.memory..], now).value
            } else {
                effect.operator.start(&effect.parameters, &mut memory[effect.memory..], value)
            }
        });
    }

    /// The constant command that results in this output, if there is one.
    #[must_use]
    pub fn holding(&self, output: f64) -> Option<f64> {
        self.effects.iter().rev().try_fold(output, |output, effect| effect.operator.holding(&effect.parameters, output))
    }

    /// The constant command whose output is nearest to this one.
    #[must_use]
    pub fn holding_nearest(&self, output: f64) -> Option<f64> {
        self.effects.iter().rev().try_fold(output, |output, effect| {
            effect.operator.holding(&effect.parameters, effect.operator.nearest_output(&effect.parameters, output))
        })
    }

    /// Initializes the history for a constant command.
    pub fn start_history(&self, history: &mut History, rest: f64) {
        if self.delay > 0.0 { history.start(rest) } else { history.clear() }
    }

    /// Records the command from `time` on.
    pub fn record(&self, history: &mut History, time: f64, command: Piece) -> Change {
        if self.delay == 0.0 {
            return Change::None;
        }
        let change = history.change(time, command);
        history.apply(change);
        change
    }

    /// Removes history older than the delay at `time`: after a step, since a failed step must change nothing.
    pub fn forget(&self, history: &mut History, time: f64) {
        if self.delay > 0.0 {
            history.forget_before(time - self.delay);
        }
    }

    /// The piece behind all effects (the shortest) at `time` \[s\]; `now` is the command itself. Writes the inputs of the effects.
    pub fn pieces(&self, past: Past<'_>, memory: &[f64], time: f64, now: Piece, inputs: &mut EffectInputs) -> Piece {
        inputs.count = 0;
        if self.delay == 0.0 && self.effects.is_empty() {
            return now;
        }
        let delayed = if self.delay == 0.0 { None } else { past.piece(time - self.delay, now) };
        self.effects.iter().fold(delayed.unwrap_or(now), |piece, effect| {
            inputs.push(piece);
            effect.operator.piece(&effect.parameters, &memory[effect.memory..], piece)
        })
    }

    /// The output behind all effects through a step without a delay; `None` if it is not one piece.
    #[inline]
    pub fn whole_step(&self, memory: &[f64], command: Signal, length: f64, resolution: f64) -> Option<Signal> {
        let mut output = command;
        for CommandEffect { operator, parameters, memory: place, .. } in &self.effects {
            output = operator.whole_piece(parameters, &memory[*place..], output, length, resolution)?;
        }
        Some(output)
    }

    /// Advances the memory through such a step.
    #[inline]
    pub fn advance_whole_step(&self, memory: &mut [f64], command: Signal, length: f64, resolution: f64) {
        let mut input = command;
        for (index, CommandEffect { operator, parameters, memory: place, .. }) in self.effects.iter().enumerate() {
            let memory = &mut memory[*place..];
            let is_last = index + 1 == self.effects.len();
            let output =
                if is_last { None } else { operator.whole_piece(parameters, memory, input, length, resolution) };
            operator.advance_whole(parameters, memory, input, length, resolution);
            input = output.unwrap_or(input);
        }
    }

    /// Advances the memory by `time` \[s\], with the inputs that [`CommandSide::pieces`] has written.
    pub fn advance(&self, memory: &mut [f64], inputs: &EffectInputs, time: f64) {
        for (effect, piece) in self.effects.iter().zip(inputs.iter()) {
            effect.operator.advance(&effect.parameters, &mut memory[effect.memory..], *piece, time);
        }
    }

    /// Coefficients in τ of k (1 + drift t) c over a segment that starts at `time` \[s\].
    #[must_use]
    pub fn demand(&self, piece: Piece, time: f64, length: f64) -> [f64; 3] {
        self.demand_of(Signal { value: piece.value, slope: piece.slope }, time, length)
    }

    /// As above for a linear command.
    #[must_use]
    #[inline]
    pub fn demand_of(&self, Signal { value, slope }: Signal, time: f64, length: f64) -> [f64; 3] {
        let (gain, growth) = (self.gain * (1.0 + self.drift * time), self.gain * self.drift);
        [gain * value, (gain * slope + growth * value) * length, growth * slope * length * length]
    }

    /// Evaluates the command side at the end of a linear command piece that starts at `from` \[s\], with history knots before `until` \[s\];
    /// advances the memory and writes the inputs of the effects at the end. The history is unchanged.
    pub fn evaluate(
        &self,
        history: &History,
        memory: &mut [f64],
        (from, until): (f64, f64),
        command: Piece,
        inputs: &mut EffectInputs,
    ) -> Piece {
        let past = history.with(if self.delay == 0.0 { Change::None } else { history.change(from, command) });
        let past = past.before(until);
        let mut done = 0.0;
        for segment in 0_usize.. {
            let rest = command.length - done;
            let now = Piece { value: command.at(done), length: rest, ..command };
            let piece = self.pieces(past, memory, from + done, now, inputs);
            let is_last = segment >= MAX_SEGMENTS || piece.length >= rest;
            let elapsed = if is_last { rest } else { piece.length.max(command.time_resolution).min(rest) };
            if elapsed > 0.0 {
                self.advance(memory, inputs, elapsed);
            }
            done += elapsed;
            if elapsed >= rest {
                inputs.pieces.iter_mut().for_each(|piece| piece.value = piece.at(elapsed));
                return Piece { value: piece.at(elapsed), ..piece };
            }
        }
        command
    }

    /// Writes the condition of each effect; the inputs are those of [`CommandSide::evaluate`].
    pub fn event_conditions(&self, memory: &[f64], inputs: &EffectInputs, into: &mut [EventCondition]) {
        for (effect, piece) in self.effects.iter().zip(inputs.iter()) {
            into[effect.condition_index] =
                effect.operator.event_condition(&effect.parameters, &memory[effect.memory..], *piece);
        }
    }

    /// Indices of the conditions of its effects.
    pub fn condition_indices(&self) -> impl Iterator<Item = usize> {
        self.effects.iter().map(|effect| effect.condition_index)
    }

    /// Writes the two event indicators of each effect.
    pub fn event_indicators(
        &self,
        conditions: &[EventCondition],
        inputs: &EffectInputs,
        output: f64,
        into: &mut [f64],
    ) {
        let outputs = inputs.iter().skip(1).map(|piece| piece.value).chain([output]);
        for ((effect, piece), output) in self.effects.iter().zip(inputs.iter()).zip(outputs) {
            let input = Signal { value: piece.value, slope: piece.slope };
            into[2 * effect.condition_index..][..2]
                .copy_from_slice(&conditions[effect.condition_index].event_indicators(input, output));
        }
    }

    /// k (1 + drift t) c at `time` \[s\].
    #[must_use]
    pub fn demand_at(&self, command: f64, time: f64) -> f64 {
        self.gain * (1.0 + self.drift * time) * command
    }
}

/// Maximum number of segments in one command piece, far above what any effect produces; the remainder is taken as one segment.
const MAX_SEGMENTS: usize = 10_000;
