//! The command side: delay, then the effects on the command, exact for piecewise linear commands.

use serde::{Deserialize, Serialize};

use crate::operator::{CommandOperator, EventCondition, Piece, Signal};

/// Knot of a piecewise linear command: it is linear from this time to the next knot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Knot {
    /// [s]
    pub time: f64,
    /// [deg]
    pub value: f64,
    /// [deg/s]
    pub slope: f64,
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
    /// Transport delay [s].
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

    /// Initializes the memory for a constant command.
    pub fn start(&self, memory: &mut [f64], rest: f64) {
        self.effects
            .iter()
            .fold(rest, |rest, effect| effect.operator.start(&effect.parameters, &mut memory[effect.memory..], rest));
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

    /// Initializes the history for a constant command.
    pub fn start_history(&self, history: &mut Vec<Knot>, rest: f64) {
        history.clear();
        if self.delay > 0.0 {
            history.push(Knot { time: f64::MIN, value: rest, slope: 0.0 });
        }
    }

    /// Appends the command from `time` on, and removes what is older than the delay.
    pub fn record(&self, history: &mut Vec<Knot>, time: f64, command: Piece) {
        if self.delay == 0.0 {
            return;
        }
        let reached = history.iter().rposition(|knot| knot.time <= time - self.delay).unwrap_or(0);
        history.drain(..reached);
        let Piece { value, slope, .. } = command;
        match history.last_mut() {
            // Held further: the last knot applies.
            Some(last) if last.slope == 0.0 && slope == 0.0 && last.value == value => {}
            // The same instant, after a step of zero length.
            Some(last) if last.time >= time => *last = Knot { time: last.time, value, slope },
            _ => history.push(Knot { time, value, slope }),
        }
    }

    /// The delayed command at `time` [s], up to its next knot; `now` is the command itself.
    fn delayed(&self, history: &[Knot], time: f64, now: Piece) -> Piece {
        if self.delay == 0.0 {
            return now;
        }
        let past = time - self.delay;
        // A knot within the time resolution is reached.
        let index = history.iter().rposition(|knot| knot.time <= past + now.time_resolution).unwrap_or(0);
        let Some(knot) = history.get(index) else { return now };
        let value = if knot.slope == 0.0 { knot.value } else { knot.value + knot.slope * (past - knot.time) };
        let next = history.get(index + 1).map_or(f64::INFINITY, |next| next.time - past);
        Piece { value, slope: knot.slope, length: now.length.min(next), ..now }
    }

    /// The piece behind all effects, which is the shortest; writes the inputs of the effects to `pieces`.
    pub fn pieces(&self, history: &[Knot], memory: &[f64], time: f64, now: Piece, pieces: &mut Vec<Piece>) -> Piece {
        pieces.clear();
        let mut piece = self.delayed(history, time, now);
        for effect in &self.effects {
            pieces.push(piece);
            piece = effect.operator.piece(&effect.parameters, &memory[effect.memory..], piece);
        }
        piece
    }

    /// Advances the memory by `time` [s], with the inputs written by [`CommandSide::pieces`].
    pub fn advance(&self, memory: &mut [f64], pieces: &[Piece], time: f64) {
        for (effect, piece) in self.effects.iter().zip(pieces) {
            effect.operator.advance(&effect.parameters, &mut memory[effect.memory..], *piece, time);
        }
    }

    /// Coefficients in τ of k (1 + drift t) c over a segment that starts at `time` [s].
    #[must_use]
    pub fn demand(&self, piece: Piece, time: f64, length: f64) -> [f64; 3] {
        let Piece { value, slope, .. } = piece;
        let (gain, growth) = (self.gain * (1.0 + self.drift * time), self.gain * self.drift);
        [gain * value, (gain * slope + growth * value) * length, growth * slope * length * length]
    }

    /// Evaluates the command side at the end of a linear piece of the command that starts at `from` [s], with the knots of the history
    /// before `until` [s]; advances the memory and writes the inputs of the effects at the end to `pieces`.
    pub fn evaluate(
        &self,
        history: &mut Vec<Knot>,
        memory: &mut [f64],
        (from, until): (f64, f64),
        command: Piece,
        pieces: &mut Vec<Piece>,
    ) -> Piece {
        self.record(history, from, command);
        let known = history.iter().rposition(|knot| knot.time < until).map_or(history.len(), |index| index + 1);
        let mut done = 0.0;
        for segment in 0_usize.. {
            let rest = command.length - done;
            let now = Piece { value: command.at(done), length: rest, ..command };
            let piece = self.pieces(&history[..known], memory, from + done, now, pieces);
            let is_last = segment >= MAX_SEGMENTS || piece.length >= rest;
            let elapsed = if is_last { rest } else { piece.length.max(command.time_resolution).min(rest) };
            if elapsed > 0.0 {
                self.advance(memory, pieces, elapsed);
            }
            done += elapsed;
            if elapsed >= rest {
                pieces.iter_mut().for_each(|piece| piece.value = piece.at(elapsed));
                return Piece { value: piece.at(elapsed), ..piece };
            }
        }
        command
    }

    /// Writes the condition of each effect; `pieces` are those of [`CommandSide::evaluate`].
    pub fn event_conditions(&self, memory: &[f64], pieces: &[Piece], into: &mut [EventCondition]) {
        for (effect, piece) in self.effects.iter().zip(pieces) {
            into[effect.condition_index] =
                effect.operator.event_condition(&effect.parameters, &memory[effect.memory..], *piece);
        }
    }

    /// Indices of the conditions of its effects.
    pub fn condition_indices(&self) -> impl Iterator<Item = usize> {
        self.effects.iter().map(|effect| effect.condition_index)
    }

    /// Writes the two event indicators of each effect.
    pub fn event_indicators(&self, conditions: &[EventCondition], pieces: &[Piece], output: f64, into: &mut [f64]) {
        let outputs = pieces.iter().skip(1).map(|piece| piece.value).chain([output]);
        for ((effect, piece), output) in self.effects.iter().zip(pieces).zip(outputs) {
            let input = Signal { value: piece.value, slope: piece.slope };
            into[2 * effect.condition_index..][..2]
                .copy_from_slice(&conditions[effect.condition_index].event_indicators(input, output));
        }
    }

    /// k (1 + drift t) c at `time` [s].
    #[must_use]
    pub fn demand_at(&self, command: f64, time: f64) -> f64 {
        self.gain * (1.0 + self.drift * time) * command
    }
}

/// Maximum number of segments in one piece of the command, far above what any effect produces; the rest is taken as one segment.
const MAX_SEGMENTS: usize = 10_000;
