//! Limits of the command.
//!
//! ```text
//!          out │     ┌──── max
//!              │   ╱
//!        ──────┼─╱────── in
//!   min ────┐╱ │
//! ```
//!
//! out = min(max(c, min), max). Simulink (Saturation), JSBSim (clipto).

use super::effect::{Act, Constraint, Effect, Family, Parameter, UNLIMITED};
use crate::{operator::{CommandOperator, Piece, EventCondition}, series::Range};

pub(super) static EFFECT: Effect = Effect {
    name: "command_limit",
    family: Family::Limit,
    summary: "the command is held between two limits",
    parameters: &[
        Parameter { name: "min", unit: "deg", neutral: -UNLIMITED, min: -UNLIMITED, max: UNLIMITED, nominal: 10.0, decides: true, meaning: "least command" },
        Parameter { name: "max", unit: "deg", neutral: UNLIMITED, min: -UNLIMITED, max: UNLIMITED, nominal: 10.0, decides: true, meaning: "greatest command" },
    ],
    act: Act::Command(&Limit),
    memory: 0,
    constraint: Some(Constraint { holds: |values| values[0] < values[1], words: "min below max" }),
    plausible: &[],
    start_values: |observed| [0.97, 0.9, 0.8, 0.6, 0.4].map(|share| vec![-share * observed.command_peak, share * observed.command_peak]).to_vec(),
};

struct Limit;

impl CommandOperator for Limit {
    fn start(&self, parameters: &[f64], _memory: &mut [f64], rest: f64) -> f64 {
        rest.clamp(parameters[0], parameters[1])
    }

    fn holding(&self, parameters: &[f64], output: f64) -> Option<f64> {
        (parameters[0]..=parameters[1]).contains(&output).then_some(output)
    }

    fn nearest_output(&self, parameters: &[f64], output: f64) -> f64 {
        output.clamp(parameters[0], parameters[1])
    }

    fn piece(&self, parameters: &[f64], _memory: &[f64], input: Piece) -> Piece {
        let (min, max) = (parameters[0], parameters[1]);
        let held = |level: f64| Piece { value: level, slope: 0.0, ..input };
        if input.is_above(max) {
            held(max).limited_to(input.time_until(max))
        } else if input.is_below(min) {
            held(min).limited_to(input.time_until(min))
        } else {
            input.limited_to(if input.slope > 0.0 { input.time_until(max) } else { input.time_until(min) })
        }
    }

    fn event_condition(&self, parameters: &[f64], _memory: &[f64], input: Piece) -> EventCondition {
        let (min, max) = (parameters[0], parameters[1]);
        EventCondition::Input(if input.is_above(max) {
            Range::above(max)
        } else if input.is_below(min) {
            Range::below(min)
        } else {
            Range { low: min, high: max }
        })
    }
}
