//! Chatter: an oscillation not driven by the command.
//!
//! ```text
//! measured → measured + amplitude sin(2π frequency t + phase)
//! ```

use std::f64::consts::TAU;

use super::effect::{Act, Effect, Family, Parameter, UNLIMITED};

pub(super) static EFFECT: Effect = Effect {
    name: "chatter",
    family: Family::Sensor,
    summary: "an oscillation that the command does not drive",
    parameters: &[
        Parameter { name: "amplitude", unit: "deg", neutral: 0.0, min: 0.0, max: UNLIMITED, nominal: 0.1, decides: true, meaning: "amplitude of the oscillation" },
        Parameter { name: "frequency", unit: "Hz", neutral: 15.0, min: 0.0, max: 1e6, nominal: 10.0, decides: false, meaning: "frequency of the oscillation" },
        Parameter { name: "phase", unit: "rad", neutral: 0.0, min: -TAU, max: TAU, nominal: 1.0, decides: false, meaning: "phase of the oscillation at the start" },
    ],
    act: Act::Reading {
        value: |values, time, value| value + values[0] * (TAU * values[1] * time + values[2]).sin(),
        slope: |values, time| values[0] * TAU * values[1] * (TAU * values[1] * time + values[2]).cos(),
    },
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| {
        let amplitude = std::f64::consts::SQRT_2 * observed.residual_rms;
        [0.0, 0.5 * std::f64::consts::PI].map(|phase| vec![amplitude, observed.residual_frequency_hz, phase]).to_vec()
    },
};
