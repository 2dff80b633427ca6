//! Rate limit of the command, ahead of the servo.
//!
//! ```text
//!    in ┌──────      out   ╱────
//!       │                ╱ up
//!    ───┘            ───╱
//! ```
//!
//! ṙ follows ċ within [-down, up] and catches up with c at those rates. Simulink (Rate Limiter), JSBSim (rate_limit).
//! A sine of amplitude A and frequency f meets it above f = R / (2πA).

use super::{Act, Effect, Family, LEAST, Parameter, UNLIMITED};
use crate::{operator::{CommandOperator, Piece, Watch}, series::Range};

pub(super) static EFFECT: Effect = Effect {
    name: "command_rate_limit",
    family: Family::Limit,
    summary: "the command moves no faster than this",
    parameters: &[
        Parameter { name: "up", unit: "deg/s", neutral: UNLIMITED, min: LEAST, max: UNLIMITED, nominal: 100.0, decides: true, meaning: "greatest rate upwards" },
        Parameter { name: "down", unit: "deg/s", neutral: UNLIMITED, min: LEAST, max: UNLIMITED, nominal: 100.0, decides: true, meaning: "greatest rate downwards" },
    ],
    act: Act::Command(&RateLimit),
    memory: 1,
    constraint: None,
    plausible: &[],
    guess: |observed| [4.0, 2.5, 1.5, 1.1, 0.8, 0.5].map(|share| vec![share * observed.rate_peak; 2]).to_vec(),
};

struct RateLimit;

impl CommandOperator for RateLimit {
    fn start(&self, _parameters: &[f64], memory: &mut [f64], rest: f64) -> f64 {
        memory[0] = rest;
        rest
    }

    fn piece(&self, parameters: &[f64], memory: &[f64], input: Piece) -> Piece {
        let (up, down, now) = (parameters[0], parameters[1], memory[0]);
        let Piece { value, slope, length, .. } = input;
        let catching_up = |rate: f64| {
            // The gap closes when the command does not run away faster than the output follows.
            let closing = (value - now) / (rate - slope);
            let length = if closing > 0.0 { closing.min(length) } else { length };
            Piece { value: now, slope: rate, length, ..input }
        };
        // The memory is where the command was when they met: a rounding beside where it is now.
        if input.is_at(now) {
            let rate = slope.clamp(-down, up);
            if rate == slope { input } else { Piece { value: now, slope: rate, ..input } }
        } else {
            catching_up(if value > now { up } else { -down })
        }
    }

    fn advance(&self, parameters: &[f64], memory: &mut [f64], input: Piece, time: f64) {
        let output = self.piece(parameters, memory, input);
        let (next, target) = (output.at(time), input.at(time));
        // It does not overtake: where it has caught up, it is the command itself and not a rounding beside it.
        let caught_up = time >= output.length && output.length < input.length || output == input;
        let passed = !input.is_at(memory[0]) && (memory[0] - input.value) * (next - target) < 0.0;
        memory[0] = if caught_up || passed { target } else { next };
    }

    /// While it follows, what it waits for is the slope of the command, which no host tells: it is noticed when a step is done.
    fn watch(&self, _parameters: &[f64], memory: &[f64], input: Piece) -> Watch {
        if input.is_at(memory[0]) {
            Watch::Nothing
        } else {
            Watch::Gap(if input.value > memory[0] { Range::above(0.0) } else { Range::below(0.0) })
        }
    }
}
