//! The model of the README, as the shared library of an FMU.
#![allow(missing_docs)]

use std::sync::LazyLock;

use fmi_export::{Causality, Kind, Model, Phase, Request, Result, Value, Variability::Continuous, Variable, Variables};

/// `0.5 s ẏ = u - y`, with u and y.
pub struct Lag([f64; 2]);

static VARIABLES: LazyLock<Variables<usize>> = LazyLock::new(|| {
    Variables::new(vec![
        Variable::real("u", "input", Causality::Input, Continuous, "1", 0),
        Variable::real("y", "output", Causality::Output, Continuous, "1", 1),
    ])
});

impl Model for Lag {
    type Start = ();
    type Slot = usize;
    type Memory = [f64; 2];
    const IDENTIFIER: &'static str = "Lag";

    fn start(request: &Request) -> Result<()> {
        request.expect_guid("{lag}")
    }
    fn guid((): &()) -> String {
        "{lag}".into()
    }
    fn new((): &(), _kind: Kind) -> Self {
        Self([0.0; 2])
    }
    fn variables() -> &'static Variables<usize> {
        &VARIABLES
    }
    fn get(&self, slot: usize, _now: Phase) -> Result<Value> {
        Ok(Value::Real(self.0[slot]))
    }
    fn set(&mut self, slot: usize, value: Value) {
        self.0[slot] = value.real().unwrap_or(self.0[slot]);
    }
    fn memory(&self) -> &[f64; 2] {
        &self.0
    }
    fn restore(&mut self, memory: [f64; 2], _now: Phase) -> Result<()> {
        self.0 = memory;
        Ok(())
    }
    fn step(&mut self, _time: f64, duration: f64) -> Result<()> {
        let [u, y] = self.0;
        self.0[1] = u + (y - u) * (-duration / 0.5).exp();
        Ok(())
    }
}

fmi_export::export!(Lag);
