//! Constant error and drift of the measurement.
//!
//! ```text
//! measured → measured + offset + drift t
//! ```

use super::effect::{Act, Effect, Family, Parameter, UNLIMITED};

pub(super) static EFFECT: Effect = Effect {
    name: "sensor_bias",
    family: Family::Sensor,
    summary: "the measurement is off, and drifts",
    parameters: &[
        Parameter { name: "offset", unit: "deg", neutral: 0.0, min: -UNLIMITED, max: UNLIMITED, nominal: 0.1, decides: true, meaning: "error of the measurement at the start" },
        Parameter { name: "drift", unit: "deg/s", neutral: 0.0, min: -UNLIMITED, max: UNLIMITED, nominal: 0.01, decides: true, meaning: "change of that error per second" },
    ],
    act: Act::Reading { value: |values, time, value| value + values[0] + values[1] * time, slope: |values, _| values[1] },
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| vec![vec![observed.residual_mean, 0.0]],
};
