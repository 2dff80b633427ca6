//! Rate limit of the command, ahead of the servo.
//!
//! ```text
//!    in ┌──────      out   ╱────
//!       │                ╱ up
//!    ───┘            ───╱
//! ```
//!
//! The output r has ṙ = ċ within [-down, up], and approaches c at those rates when they differ. Simulink (Rate Limiter), JSBSim
//! (rate_limit). A sine of amplitude A and frequency f reaches the limit above f = R / (2πA).

use super::effect::{Act, Effect, Family, SMALLEST_LIMIT, Parameter, UNLIMITED};
use crate::{operator::{CommandOperator, Piece, EventCondition}, series::Range};

pub(super) static EFFECT: Effect = Effect {
    name: "command_rate_limit",
    family: Family::Limit,
    summary: "the command moves no faster than this",
    parameters: &[
        Parameter { name: "up", unit: "deg/s", neutral: UNLIMITED, min: SMALLEST_LIMIT, max: UNLIMITED, nominal: 100.0, decides: true, meaning: "greatest rate upwards" },
        Parameter { name: "down", unit: "deg/s", neutral: UNLIMITED, min: SMALLEST_LIMIT, max: UNLIMITED, nominal: 100.0, decides: true, meaning: "greatest rate downwards" },
    ],
    act: Act::Command(&RateLimit),
    memory: 1,
    constraint: None,
    plausible: &[],
    start_values: |observed| [4.0, 2.5, 1.5, 1.1, 0.8, 0.5, 0.3, 0.18].map(|share| vec![share * observed.rate_peak; 2]).to_vec(),
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
        let approaching = |rate: f64| {
            // The difference vanishes if the command changes more slowly than the output.
            let closing = (value - now) / (rate - slope);
            let length = if closing > 0.0 { closing.min(length) } else { length };
            Piece { value: now, slope: rate, length, ..input }
        };
        // The memory equals the command within rounding once the difference has vanished.
        if input.is_at(now) {
            let rate = slope.clamp(-down, up);
            if rate == slope { input } else { Piece { value: now, slope: rate, ..input } }
        } else {
            approaching(if value > now { up } else { -down })
        }
    }

    fn advance(&self, parameters: &[f64], memory: &mut [f64], input: Piece, time: f64) {
        let output = self.piece(parameters, memory, input);
        let (next, target) = (output.at(time), input.at(time));
        // No overshoot: once the difference has vanished the output is exactly the command.
        let has_arrived = time >= output.length && output.length < input.length || output == input;
        let passed = !input.is_at(memory[0]) && (memory[0] - input.value) * (next - target) < 0.0;
        memory[0] = if has_arrived || passed { target } else { next };
    }

    /// While output and command are equal the mode ends with the slope of the command, which the host does not announce: it is detected
    /// when a step is completed.
    fn event_condition(&self, _parameters: &[f64], memory: &[f64], input: Piece) -> EventCondition {
        if input.is_at(memory[0]) {
            EventCondition::None
        } else {
            EventCondition::Difference(if input.value > memory[0] { Range::above(0.0) } else { Range::below(0.0) })
        }
    }
}
