//! Hinge moment: a steady or varying load, and the aerodynamic spring.
//!
//! ```text
//! δ̈ → δ̈ + ω² (load + bias - stiffness δ)
//! ```
//!
//! `load` is the input of the FMU, as the static deflection that it causes without `stiffness`. With it the static deflection is
//! (k c + load + bias) / (1 + stiffness).

use super::effect::{Act, Effect, Family, Parameter, UNLIMITED};

pub(super) static EFFECT: Effect = Effect {
    name: "hinge_load",
    family: Family::Gain,
    summary: "hinge moment: aerodynamic spring and steady load",
    parameters: &[
        Parameter { name: "stiffness", unit: "1", neutral: 0.0, min: -0.99, max: 1e3, nominal: 0.1, decides: true, meaning: "aerodynamic stiffness over the actuator's own" },
        Parameter { name: "bias", unit: "deg", neutral: 0.0, min: -UNLIMITED, max: UNLIMITED, nominal: 0.1, decides: true, meaning: "steady hinge load, as the static deflection it causes without stiffness" },
    ],
    act: Act::Loop(|values, terms| (terms.stiffness, terms.bias) = (values[0], values[1])),
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| vec![vec![0.05, observed.residual_mean]],
};
