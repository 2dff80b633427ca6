//! Limit of the drive's rate: the maximum flow of the valve.
//!
//! ```text
//!        δ̇ │     ┌──── up
//!          │   ╱
//!   ───────┼─╱────
//! -down ───┘
//! ```
//!
//! δ̇ is limited to [-down, up]: at the limit it equals the limit exactly until the acceleration changes sign. A sine of amplitude A
//! reaches it above the frequency R / (2πA) (Duda 1995: onset of rate limiting).

use super::effect::{Act, Effect, Family, SMALLEST_LIMIT, Parameter, UNLIMITED};

pub(super) static EFFECT: Effect = Effect {
    name: "rate_limit",
    family: Family::Limit,
    summary: "the drive moves no faster than this",
    parameters: &[
        Parameter { name: "up", unit: "deg/s", neutral: UNLIMITED, min: SMALLEST_LIMIT, max: UNLIMITED, nominal: 100.0, decides: true, meaning: "greatest rate upwards" },
        Parameter { name: "down", unit: "deg/s", neutral: UNLIMITED, min: SMALLEST_LIMIT, max: UNLIMITED, nominal: 100.0, decides: true, meaning: "greatest rate downwards" },
    ],
    act: Act::Loop(|values, terms| (terms.up, terms.down) = (values[0], values[1])),
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| [0.97, 0.9, 0.8, 0.65, 0.5, 0.35, 0.25, 0.18].map(|share| vec![share * observed.rate_peak; 2]).to_vec(),
};
