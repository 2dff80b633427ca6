//! Dead zone of the servo: a valve with overlap does not respond to small errors.
//!
//! ```text
//!      drive │    ╱
//!            │  ╱
//!   ─────┬───┼──┬──── error x - δ
//!      ╱     │
//! ```
//!
//! No correction inside ± half_width, the error less half_width outside (Merritt 1967, section 5.3: overlapped valves).

use super::effect::{Act, Effect, Family, Parameter, UNLIMITED};

pub(super) static EFFECT: Effect = Effect {
    name: "dead_zone",
    family: Family::Play,
    summary: "the servo does not correct small errors",
    parameters: &[Parameter { name: "half_width", unit: "deg", neutral: 0.0, min: 0.0, max: UNLIMITED, nominal: 0.1, decides: true, meaning: "half width of the dead zone of the servo error" }],
    act: Act::Loop(|values, terms| terms.dead_zone = values[0]),
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| [1.0, 2.0, 4.0].map(|share| vec![share * observed.residual_rms]).to_vec(),
};
