//! Stops.
//!
//! ```text
//!          δ │     ┌──── max
//!            │   ╱
//!   ─────────┼─╱────
//!   min ────┐╱
//! ```
//!
//! At a stop the rate becomes zero without rebound; the surface leaves the stop when the sum of the other forces exceeds friction in that
//! direction.

use super::effect::{Act, Constraint, Effect, Family, Observed, Parameter, UNLIMITED};

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
    start_values,
};

/// At the extremes of the motion and, if these differ, symmetrically at the larger one: a side that is not reached keeps that value.
fn start_values(observed: &Observed) -> Vec<Vec<f64>> {
    const SHARES: [f64; 5] = [1.0, 0.98, 0.96, 0.93, 0.87];
    const ALIKE: f64 = 0.1;
    let (low, high) = observed.position_range;
    let farthest = high.abs().max(low.abs());
    let is_alike = (high + low).abs() < ALIKE * farthest;
    let even = SHARES.map(|share| vec![-share * farthest, share * farthest]).into_iter().filter(|_| !is_alike);
    even.chain(SHARES.map(|share| vec![share * low, share * high])).collect()
}
