//! Dry friction of seals and bearings.
//!
//! ```text
//!    force │   ┌──────  ω² level
//!          │   │
//!   ───────┼───┼────── δ̇       at rest: the opposite of the other forces, up to ω² level
//!     ─────┘   │
//! ```
//!
//! Opposes δ̇ during motion; at rest it sticks, with δ̇ exactly zero, until the other forces exceed ω² level (Armstrong-Hélouvry, Dupont
//! and Canudas de Wit 1994, section 2).

use super::effect::{Act, Effect, Family, Parameter, UNLIMITED};

pub(super) static EFFECT: Effect = Effect {
    name: "coulomb_friction",
    family: Family::Play,
    summary: "dry friction: it sticks at rest",
    parameters: &[Parameter { name: "level", unit: "deg", neutral: 0.0, min: 0.0, max: UNLIMITED, nominal: 0.1, decides: true, meaning: "friction, as the servo error it takes to overcome it" }],
    act: Act::Loop(|values, terms| terms.friction = values[0]),
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| [1.0, 2.0, 4.0].map(|share| vec![share * observed.residual_rms]).to_vec(),
};
