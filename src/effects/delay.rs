//! Transport delay of the command: bus, computer, sampling.
//!
//! ```text
//! c(t) → c(t - time)
//!
//!      in ┌────      out     ┌────
//!      ───┘          ────────┘
//!                       time
//! ```
//!
//! The history of the command is piecewise linear, so that the delay is exact for any step size. Before the start the command is
//! constant (`initial_position / k`). JSBSim (FGActuator, delay_time) and Modelica (Blocks.Nonlinear.FixedDelay) have the same.

use super::effect::{Act, Effect, Family, Parameter};

pub(super) static EFFECT: Effect = Effect {
    name: "delay",
    family: Family::Lag,
    summary: "the command comes later",
    parameters: &[Parameter {
        name: "time",
        unit: "s",
        neutral: 0.0,
        min: 0.0,
        max: 10.0,
        nominal: 0.01,
        decides: true,
        meaning: "transport delay of the command",
    }],
    act: Act::Delay,
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| [0.5, 2.0, 5.0].map(|share| vec![share * observed.sample_time_s]).to_vec(),
};
