//! Backlash in the command path, for instance in a linkage ahead of the servo valve.
//!
//! ```text
//!      out │    ╱╱
//!          │  ╱ ╱
//!   ───────┼╱─╱──── in      total width: gap
//!        ╱ ╱
//! ```
//!
//! Play operator: the output r moves only in contact, |c - r| <= gap / 2 (Krasnosel'skii and Pokrovskii 1989). Describing
//! function: Gelb and Vander Velde (1968), section 2.3.

use super::effect::{Act, Effect, Family, Parameter, UNLIMITED};
use crate::{operator::{CommandOperator, Piece, EventCondition}, series::Range};

pub(super) static EFFECT: Effect = Effect {
    name: "command_backlash",
    family: Family::Play,
    summary: "the command has free play",
    parameters: &[Parameter { name: "gap", unit: "deg", neutral: 0.0, min: 0.0, max: UNLIMITED, nominal: 0.1, decides: true, meaning: "total free play of the command" }],
    act: Act::Command(&Backlash),
    memory: 1,
    constraint: None,
    plausible: &[],
    start_values: |observed| [2.0, 4.0, 8.0].map(|share| vec![share * observed.residual_rms]).to_vec(),
};

struct Backlash;

/// Admissible range of the output.
fn play(input: f64, half: f64) -> Range {
    Range { low: input - half, high: input + half }
}

impl CommandOperator for Backlash {
    fn start(&self, _parameters: &[f64], memory: &mut [f64], rest: f64) -> f64 {
        memory[0] = rest;
        rest
    }

    fn piece(&self, parameters: &[f64], memory: &[f64], input: Piece) -> Piece {
        let (half, rest) = (0.5 * parameters[0], memory[0]);
        let Piece { value, slope, .. } = input;
        // After a step of the command the output is immediately at the edge of the play.
        let now = play(value, half).nearest(rest);
        if input.is_above(now + half) || input.is_below(now - half) {
            return Piece { value: now, ..input };
        }
        let edge = if slope > 0.0 { now + half } else { now - half };
        Piece { value: now, slope: 0.0, ..input }.limited_to(input.time_until(edge))
    }

    fn advance(&self, parameters: &[f64], memory: &mut [f64], input: Piece, time: f64) {
        let half = 0.5 * parameters[0];
        let (before, after) = (input.value, input.at(time));
        memory[0] = play(after, half).nearest(play(before, half).nearest(memory[0]));
    }

    /// In contact the mode ends at a reversal of the command, which the host does not announce: it is detected on completion of a step.
    fn event_condition(&self, parameters: &[f64], memory: &[f64], input: Piece) -> EventCondition {
        let half = 0.5 * parameters[0];
        let now = play(input.value, half).nearest(memory[0]);
        if input.is_above(now + half) || input.is_below(now - half) {
            EventCondition::None
        } else {
            EventCondition::Input(Range { low: now - half, high: now + half })
        }
    }
}
