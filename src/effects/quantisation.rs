//! Quantisation of the measurement: an encoder, or a converter with few bits.
//!
//! ```text
//!    out │      ┌──
//!        │   ┌──┘
//!   ─────┼┌──┘───── in      rounded to the nearest multiple of step
//!      ──┘│
//! ```

use super::effect::{Act, Effect, Family, Parameter, UNLIMITED};

pub(super) static EFFECT: Effect = Effect {
    name: "quantisation",
    family: Family::Sensor,
    summary: "the measurement comes in steps",
    parameters: &[Parameter { name: "step", unit: "deg", neutral: 0.0, min: 0.0, max: UNLIMITED, nominal: 0.01, decides: true, meaning: "step of the measurement" }],
    act: Act::Reading { value: |values, _, value| values[0] * (value / values[0]).round(), slope: |_, _| 0.0 },
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| vec![vec![observed.position_step]],
};
