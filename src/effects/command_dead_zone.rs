//! Dead zone of the command.
//!
//! ```text
//!        out │    ╱
//!            │  ╱
//!   ─────┬───┼──┬── in      half_width each side
//!      ╱     │
//! ```
//!
//! 0 inside ± half_width, the command less half_width outside. Describing function: Gelb and Vander Velde (1968), table B.1, item 8.

use super::effect::{Act, Effect, Family, Parameter, UNLIMITED};
use crate::{operator::{CommandOperator, Piece, EventCondition}, series::Range};

pub(super) static EFFECT: Effect = Effect {
    name: "command_dead_zone",
    family: Family::Play,
    summary: "small commands are not heard",
    parameters: &[Parameter { name: "half_width", unit: "deg", neutral: 0.0, min: 0.0, max: UNLIMITED, nominal: 0.1, decides: true, meaning: "half width of the dead zone of the command" }],
    act: Act::Command(&DeadZone),
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| [1.0, 2.0, 4.0].map(|share| vec![share * observed.residual_rms]).to_vec(),
};

struct DeadZone;

fn dead_zone(value: f64, half_width: f64) -> f64 {
    value - value.clamp(-half_width, half_width)
}

impl CommandOperator for DeadZone {
    fn start(&self, parameters: &[f64], _memory: &mut [f64], rest: f64) -> f64 {
        dead_zone(rest, parameters[0])
    }

    fn holding(&self, parameters: &[f64], output: f64) -> Option<f64> {
        Some(if output == 0.0 { 0.0 } else { output + output.signum() * parameters[0] })
    }

    fn piece(&self, parameters: &[f64], _memory: &[f64], input: Piece) -> Piece {
        let half_width = parameters[0];
        let Piece { value, slope, .. } = input;
        if input.is_above(half_width) {
            Piece { value: value - half_width, ..input }.limited_to(input.time_until(half_width))
        } else if input.is_below(-half_width) {
            Piece { value: value + half_width, ..input }.limited_to(input.time_until(-half_width))
        } else {
            let edge = if slope > 0.0 { half_width } else { -half_width };
            Piece { value: 0.0, slope: 0.0, ..input }.limited_to(input.time_until(edge))
        }
    }

    fn event_condition(&self, parameters: &[f64], _memory: &[f64], input: Piece) -> EventCondition {
        let half_width = parameters[0];
        EventCondition::Input(if input.is_above(half_width) {
            Range::above(half_width)
        } else if input.is_below(-half_width) {
            Range::below(-half_width)
        } else {
            Range { low: -half_width, high: half_width }
        })
    }
}
