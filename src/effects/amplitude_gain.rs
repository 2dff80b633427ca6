//! A gain that depends on the amplitude: a stiffness that increases or decreases with the deflection.
//!
//! ```text
//! δ̈ → δ̈ - ω² cubic δ³        static: δ + cubic δ³ = x
//! ```
//!
//! Duffing's spring; describing function of δ³: (3/4) A² (Gelb and Vander Velde 1968, table B.1). A negative value softens the spring;
//! beyond |δ| = 1 / √(-3 cubic) there is no equilibrium, and a divergent motion is refused.

use super::effect::{Act, Effect, Family, Parameter, UNLIMITED};

pub(super) static EFFECT: Effect = Effect {
    name: "amplitude_gain",
    family: Family::Gain,
    summary: "the gain changes with the amplitude",
    parameters: &[Parameter { name: "cubic", unit: "1/deg2", neutral: 0.0, min: -UNLIMITED, max: UNLIMITED, nominal: 1e-3, decides: true, meaning: "cubic stiffness over linear stiffness" }],
    act: Act::Loop(|values, terms| terms.cubic = values[0]),
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |observed| {
        let peak = observed.position_range.0.abs().max(observed.position_range.1.abs());
        vec![vec![0.05 / (peak * peak)], vec![-0.05 / (peak * peak)]]
    },
};
