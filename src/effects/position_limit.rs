//! Stops.
//!
//! ```text
//!          δ │     ┌──── max
//!            │   ╱
//!   ─────────┼─╱────
//!   min ────┐╱
//! ```
//!
//! On reaching a stop the rate becomes zero without rebound; the surface leaves the stop when the sum of the other forces exceeds
//! friction in that direction.

use super::effect::{Act, Constraint, Effect, Family, Parameter, UNLIMITED};

pub(super) static EFFECT: Effect = Effect {
    name: "position_limit",
    family: Family::Limit,
    summary: "stops without rebound",
    parameters: &[
        Parameter { name: "min", unit: "deg", neutral: -UNLIMITED, min: -UNLIMITED, max: UNLIMITED, nominal: 10.0, decides: true, meaning: "least position" },
        Parameter { name: "max", unit: "deg", neutral: UNLIMITED, min: -UNLIMITED, max: UNLIMITED, nominal: 10.0, decides: true, meaning: "greatest position" },
    ],
    act: Act::Loop(|values, terms| (terms.min, terms.max) = (values[0], values[1])),
    memory: 0,
    constraint: Some(Constraint { holds: |values| values[0] < values[1], words: "min below max" }),
    plausible: &[],
    start_values: |observed| [1.0, 0.95, 0.87].map(|share| vec![share * observed.position_range.0, share * observed.position_range.1]).to_vec(),
};
