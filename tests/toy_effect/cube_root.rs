//! A toy: a nonlinear measurement. Used in the test that adding an effect requires one file and one word.

use super::effect::{Act, Effect, Family, Parameter};

pub(super) static EFFECT: Effect = Effect {
    name: "cube_root",
    family: Family::Sensor,
    summary: "the measurement is bent",
    parameters: &[Parameter {
        name: "share",
        unit: "1",
        neutral: 0.0,
        min: 0.0,
        max: 1.0,
        nominal: 0.1,
        decides: true,
        meaning: "share of the cube root in the measurement",
    }],
    act: Act::Reading { value: |values, _, value| value + values[0] * (value.cbrt() - value), slope: |_, _| 0.0 },
    memory: 0,
    constraint: None,
    plausible: &[],
    start_values: |_| vec![vec![0.1]],
};
