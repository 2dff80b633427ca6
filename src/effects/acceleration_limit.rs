//! Limit of the drive: supply pressure, motor current.
//!
//! ```text
//!     drive │    ┌──── value
//!           │  ╱
//!   ────────┼╱───── ω² (error)
//!  -value ──┘
//! ```
//!
//! The drive part of δ̈ saturates; damping and loads do not.

use super::effect::{Act, Effect, Family, SMALLEST_LIMIT, Parameter, UNLIMITED};

pub(super) static EFFECT: Effect = Effect {
    name: "acceleration_limit",
    family: Family::Limit,
    summary: "the drive can accelerate no more than this",
    parameters: &[Parameter { name: "value", unit: "deg/s2", neutral: UNLIMITED, min: SMALLEST_LIMIT, max: UNLIMITED, nominal: 1e4, decides: true, meaning: "greatest acceleration by the drive" }],
    act: Act::Loop(|values, terms| terms.acceleration = values[0]),
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| [0.97, 0.9, 0.8, 0.65, 0.5, 0.35, 0.25, 0.18, 0.12].map(|share| vec![share * observed.acceleration_peak]).to_vec(),
};
