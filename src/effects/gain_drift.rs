//! Drift of the gain: temperature, supply, a potentiometer.
//!
//! ```text
//! k → k (1 + rate t),   t since the start of the record or simulation
//! ```

use super::effect::{Act, Effect, Family, Parameter};

pub(super) static EFFECT: Effect = Effect {
    name: "gain_drift",
    family: Family::Gain,
    summary: "the gain drifts with time",
    parameters: &[Parameter { name: "rate", unit: "1/s", neutral: 0.0, min: -1.0, max: 1.0, nominal: 1e-3, decides: true, meaning: "relative change of the gain per second" }],
    act: Act::GainDrift(|values| values[0]),
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| vec![vec![0.05 / observed.duration_s], vec![-0.05 / observed.duration_s]],
};
