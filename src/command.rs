//! The command side: delay, then the effects on the command, all on pieces of straight line.

use serde::{Deserialize, Serialize};

use crate::operator::{CommandOperator, Piece, Signal, Watch};

/// From this time on the command moves linearly, until the next knot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Knot {
    /// [s]
    pub time: f64,
    /// [deg]
    pub value: f64,
    /// [deg/s]
    pub slope: f64,
}

struct Stage {
    operator: &'static dyn CommandOperator,
    parameters: Vec<f64>,
    memory: usize,
    /// Among the effects that watch something.
    place: usize,
}

/// Everything ahead of the servo.
pub struct CommandSide {
    /// Transport delay [s].
    pub delay: f64,
    /// Relative change of the gain per second.
    pub drift: f64,
    gain: f64,
    stages: Vec<Stage>,
}

impl CommandSide {
    /// Nothing but the gain k.
    #[must_use]
    pub fn new(gain: f64) -> Self {
        Self { delay: 0.0, drift: 0.0, gain, stages: Vec::new() }
    }

    /// Adds an effect behind those there are.
    pub fn add(&mut self, operator: &'static dyn CommandOperator, parameters: Vec<f64>, memory: usize, place: usize) {
        self.stages.push(Stage { operator, parameters, memory, place });
    }

    /// Memories for a command that has always been at rest.
    pub fn start(&self, memory: &mut [f64], rest: f64) {
        self.stages
            .iter()
            .fold(rest, |rest, stage| stage.operator.start(&stage.parameters, &mut memory[stage.memory..], rest));
    }

    /// Memories of effects that another command side did not have.
    pub fn start_new(&self, memory: &mut [f64], before: &Self, command: f64) {
        self.stages.iter().fold(command, |value, stage| {
            if before.stages.iter().any(|other| other.memory == stage.memory) {
                let now = Piece { value, slope: 0.0, length: 0.0, instant: 0.0 };
                stage.operator.piece(&stage.parameters, &memory[stage.memory..], now).value
            } else {
                stage.operator.start(&stage.parameters, &mut memory[stage.memory..], value)
            }
        });
    }

    /// A past in which the command has always been this.
    pub fn begin_history(&self, history: &mut Vec<Knot>, rest: f64) {
        history.clear();
        if self.delay > 0.0 {
            history.push(Knot { time: f64::MIN, value: rest, slope: 0.0 });
        }
    }

    /// Adds what the command does from `time` on, and forgets what the delay no longer reaches.
    pub fn record(&self, history: &mut Vec<Knot>, time: f64, command: Piece) {
        if self.delay == 0.0 {
            return;
        }
        let reached = history.iter().rposition(|knot| knot.time <= time - self.delay).unwrap_or(0);
        history.drain(..reached);
        let Piece { value, slope, .. } = command;
        match history.last_mut() {
            // Held on: the knot before says so already.
            Some(last) if last.slope == 0.0 && slope == 0.0 && last.value == value => {}
            // The same instant again, after a step of no length.
            Some(last) if last.time >= time => *last = Knot { time: last.time, value, slope },
            _ => history.push(Knot { time, value, slope }),
        }
    }

    /// The command behind the delay at `time`, and for how long that holds; `now` is the command itself.
    fn delayed(&self, history: &[Knot], time: f64, now: Piece) -> Piece {
        if self.delay == 0.0 {
            return now;
        }
        let past = time - self.delay;
        // A knot less than an instant ahead is reached.
        let index = history.iter().rposition(|knot| knot.time <= past + now.instant).unwrap_or(0);
        let Some(knot) = history.get(index) else { return now };
        let value = if knot.slope == 0.0 { knot.value } else { knot.value + knot.slope * (past - knot.time) };
        let next = history.get(index + 1).map_or(f64::INFINITY, |next| next.time - past);
        Piece { value, slope: knot.slope, length: now.length.min(next), ..now }
    }

    /// The pieces between the effects, from the delay to the servo, the last one first to end.
    pub fn pieces(&self, history: &[Knot], memory: &[f64], time: f64, now: Piece, pieces: &mut Vec<Piece>) -> Piece {
        pieces.clear();
        let mut piece = self.delayed(history, time, now);
        for stage in &self.stages {
            pieces.push(piece);
            piece = stage.operator.piece(&stage.parameters, &memory[stage.memory..], piece);
        }
        piece
    }

    /// Takes the memories forward, with the pieces that [`CommandSide::pieces`] left.
    pub fn advance(&self, memory: &mut [f64], pieces: &[Piece], time: f64) {
        for (stage, piece) in self.stages.iter().zip(pieces) {
            stage.operator.advance(&stage.parameters, &mut memory[stage.memory..], *piece, time);
        }
    }

    /// Coefficients of k (1 + drift t) c over a segment that starts at `time` [s], by its share τ.
    #[must_use]
    pub fn demand(&self, piece: Piece, time: f64, length: f64) -> [f64; 3] {
        let Piece { value, slope, .. } = piece;
        let (gain, growth) = (self.gain * (1.0 + self.drift * time), self.gain * self.drift);
        [gain * value, (gain * slope + growth * value) * length, growth * slope * length * length]
    }

    /// Follows a straight piece of the command from `from` [s] to its end, as far as the past is known `until` [s]; what comes out
    /// there. The pieces between the effects are left as they are there.
    pub fn follow(
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
            let enough = segment >= MOST_SEGMENTS || piece.length >= rest;
            let elapsed = if enough { rest } else { piece.length.max(command.instant).min(rest) };
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

    /// What each effect waits for, at its place; the pieces are those that [`CommandSide::follow`] left.
    pub fn watch(&self, memory: &[f64], pieces: &[Piece], into: &mut [Watch]) {
        for (stage, piece) in self.stages.iter().zip(pieces) {
            into[stage.place] = stage.operator.watch(&stage.parameters, &memory[stage.memory..], *piece);
        }
    }

    /// Places of the effects there are.
    pub fn places(&self) -> impl Iterator<Item = usize> {
        self.stages.iter().map(|stage| stage.place)
    }

    /// How far each effect is inside what it watches, at its place.
    pub fn margins(&self, watches: &[Watch], pieces: &[Piece], output: f64, into: &mut [f64]) {
        let outputs = pieces.iter().skip(1).map(|piece| piece.value).chain([output]);
        for ((stage, piece), output) in self.stages.iter().zip(pieces).zip(outputs) {
            let input = Signal { value: piece.value, slope: piece.slope };
            into[2 * stage.place..][..2].copy_from_slice(&watches[stage.place].margins(input, output));
        }
    }

    /// k (1 + drift t) c at an instant.
    #[must_use]
    pub fn demand_at(&self, command: f64, time: f64) -> f64 {
        self.gain * (1.0 + self.drift * time) * command
    }
}

/// Bends in one piece of the command, beyond which the rest is taken as it comes: more than any effect makes.
const MOST_SEGMENTS: usize = 10_000;
