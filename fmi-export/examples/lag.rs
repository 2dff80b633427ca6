//! The model of the README, as the shared library of an FMU.
#![allow(missing_docs)]

use fmi_export::{Causality, Model, Phase, Request, Result, Value, Variability, Variable};

/// `time_constant ẏ = u - y`
#[derive(Clone, serde::Serialize, serde::Deserialize)]
pub struct Lag {
    input: f64,
    output: f64,
}

const TIME_CONSTANT_S: f64 = 0.5;

impl Model for Lag {
    type Start = ();
    type Slot = usize;
    type Memory = Self;
    const IDENTIFIER: &'static str = "Lag";

    fn start(request: &Request) -> Result<()> {
        request.expect_guid("{lag}")
    }
    fn guid((): &()) -> String {
        "{lag}".into()
    }
    fn new((): &(), _kind: fmi_export::Kind) -> Self {
        Self { input: 0.0, output: 0.0 }
    }

    fn variables() -> &'static [Variable<usize>] {
        static ALL: std::sync::OnceLock<Vec<Variable<usize>>> = std::sync::OnceLock::new();
        ALL.get_or_init(|| {
            vec![
                Variable::real("u", "input", Causality::Input, Variability::Continuous, "1", 0),
                Variable::real("y", "output", Causality::Output, Variability::Continuous, "1", 1),
            ]
        })
    }
    fn get(&self, slot: usize, _now: Phase) -> Result<Value> {
        Ok(Value::Real([self.input, self.output][slot]))
    }
    fn set(&mut self, _slot: usize, value: Value) {
        self.input = value.real().unwrap_or(self.input);
    }
    fn memory(&self) -> &Self {
        self
    }
    fn restore(&mut self, memory: Self, _now: Phase) -> Result<()> {
        *self = memory;
        Ok(())
    }

    fn step(&mut self, _time: f64, duration: f64) -> Result<()> {
        self.output = self.input + (self.output - self.input) * (-duration / TIME_CONSTANT_S).exp();
        Ok(())
    }
}

fmi_export::export!(Lag);
