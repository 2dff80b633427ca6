//! Another gain for negative commands.
//!
//! ```text
//!       out │   ╱
//!           │ ╱
//!   ────────┼────── in
//!       ··'╱│          below zero: slope `ratio`
//! ```

use super::effect::{Act, Effect, Family, Parameter};
use crate::{operator::{CommandOperator, Piece, EventCondition}, series::Range};

pub(super) static EFFECT: Effect = Effect {
    name: "asymmetric_gain",
    family: Family::Gain,
    summary: "negative commands have another gain",
    parameters: &[Parameter { name: "ratio", unit: "1", neutral: 1.0, min: 0.0, max: 100.0, nominal: 1.0, decides: true, meaning: "gain of negative commands by that of positive ones" }],
    act: Act::Command(&AsymmetricGain),
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |_| vec![vec![0.9], vec![1.1]],
};

struct AsymmetricGain;

impl CommandOperator for AsymmetricGain {
    fn start(&self, parameters: &[f64], _memory: &mut [f64], rest: f64) -> f64 {
        if rest < 0.0 { parameters[0] * rest } else { rest }
    }

    fn holding(&self, parameters: &[f64], output: f64) -> Option<f64> {
        if output >= 0.0 { Some(output) } else { (parameters[0] > 0.0).then(|| output / parameters[0]) }
    }

    fn nearest_output(&self, parameters: &[f64], output: f64) -> f64 {
        if parameters[0] > 0.0 { output } else { output.max(0.0) }
    }

    fn piece(&self, parameters: &[f64], _memory: &[f64], input: Piece) -> Piece {
        let Piece { value, slope, .. } = input;
        if input.is_below(0.0) {
            let ratio = parameters[0];
            Piece { value: ratio * value, slope: ratio * slope, ..input }.limited_to(input.time_until(0.0))
        } else {
            input.limited_to(input.time_until(0.0))
        }
    }

    fn event_condition(&self, _parameters: &[f64], _memory: &[f64], input: Piece) -> EventCondition {
        EventCondition::Input(if input.is_below(0.0) { Range::below(0.0) } else { Range::above(0.0) })
    }
}
