//! The FMU: variables, memory, steps.
//!
//! Inputs are held at the value that they were set to, or move linearly from it once their derivative was set. Outputs are
//! those at the end of the last step and do not depend on inputs that were set since.
//!
//! `prediction` is for hosts that step both sides of the loop in parallel with held values (Jacobi scheme), which adds a delay of one
//! communication step H to the loop: with `prediction` = H the command is extrapolated by H with the inputs at the end of the last
//! step, and the delay is compensated up to terms of (ωH)².

use std::sync::LazyLock;

use fmi_export::{Causality, Error, Kind, Model, Phase, Request, Result, Value, Variability, Variable, Variables};
use nalgebra::SVector;
use serde::{Deserialize, Serialize};

use crate::{
    equations::{Condition, INPUTS, PITCH, PLUNGE, STATES, System},
    transition::Transition,
};

/// To be changed with the variables.
pub(crate) const GUID: &str = "{5c1f0d7e-27c9-4f5e-9c1b-b1a6206270e1}";

/// Maximum step: hundreds of periods. The matrix exponential of a longer one loses accuracy or does not terminate.
const LONGEST_STEP_S: f64 = 100.0;

/// Which quantity a variable is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// One of the inputs.
    Input(usize),
    /// Output `pitch`.
    Pitch,
    /// Output `plunge`.
    Plunge,
    /// Output `command`.
    Command,
    /// Parameter.
    Pressure,
    /// Parameter.
    Speed,
    /// Parameter.
    Gain,
    /// Parameter.
    Prediction,
    /// Parameter.
    InitialPlunge,
    /// Parameter.
    InitialPitch,
}

/// Everything that changes during a simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    condition: Condition,
    prediction_s: f64,
    initial_plunge_ft: f64,
    initial_pitch_deg: f64,
    states: [f64; STATES],
    inputs: [f64; INPUTS],
    slopes: [f64; INPUTS],
    /// Inputs at the end of the last step.
    inputs_at_step_end: [f64; INPUTS],
}

impl Default for Memory {
    fn default() -> Self {
        Self {
            condition: Condition { pressure_psf: 160.0, speed_ft_s: 385.0, gain: 1.0 },
            prediction_s: 0.0,
            initial_plunge_ft: 0.0,
            initial_pitch_deg: 0.0,
            states: [0.0; STATES],
            inputs: [0.0; INPUTS],
            slopes: [0.0; INPUTS],
            inputs_at_step_end: [0.0; INPUTS],
        }
    }
}

impl Memory {
    /// States at the start.
    fn start(&mut self) {
        self.states = [0.0; STATES];
        self.states[PLUNGE] = self.initial_plunge_ft;
        self.states[PITCH] = self.initial_pitch_deg.to_radians();
    }

    fn system(&self) -> Result<System> {
        self.condition.system().ok_or_else(|| {
            Error::new("wing", format!("no inertia with {:?}", self.condition), "flows that leave the wing its mass")
        })
    }
}

/// The wing as an FMU.
pub struct BactWing {
    memory: Memory,
    /// What follows from the memory.
    derived: Option<Derived>,
}

/// Linear system and transitions, which follow from condition, prediction and step size.
struct Derived {
    from: (Condition, f64),
    system: System,
    predicted: Transition,
    step: Option<(f64, Transition)>,
}

impl Derived {
    fn new(memory: &Memory) -> Result<Self> {
        let system = memory.system()?;
        let predicted = Transition::new(&system, memory.prediction_s);
        Ok(Self { from: (memory.condition, memory.prediction_s), system, predicted, step: None })
    }

    fn command(&self, memory: &Memory) -> f64 {
        let predicted =
            self.predicted.apply(&memory.states.into(), &memory.inputs_at_step_end.into(), &SVector::zeros());
        (self.system.command * predicted)[0]
    }
}

static VARIABLES: LazyLock<Variables<Slot>> = LazyLock::new(|| {
    use {
        Causality::{Input, Output, Parameter},
        Variability::{Continuous, Fixed},
    };
    let input = |name, description, unit, slot| Variable::real(name, description, Input, Continuous, unit, slot);
    let output = |name, description, unit, slot| Variable::real(name, description, Output, Continuous, unit, slot);
    let parameter = |name, description, unit, slot| Variable::real(name, description, Parameter, Fixed, unit, slot);
    Variables::new(vec![
        input("deflection", "deflection of the control surface, trailing edge down", "deg", Slot::Input(0)),
        input("gust", "vertical gust, positive up", "ft/s", Slot::Input(1)),
        input("force", "disturbing force on the wing, positive down", "lbf", Slot::Input(2)),
        output("pitch", "pitch, positive nose up", "deg", Slot::Pitch),
        output("plunge", "plunge of the elastic axis, positive down", "ft", Slot::Plunge),
        output("command", "command of the control law to the actuator", "deg", Slot::Command),
        parameter("dynamic_pressure", "dynamic pressure", "psf", Slot::Pressure).within(0.0, 1000.0),
        parameter("speed", "speed of the flow", "ft/s", Slot::Speed).within(1.0, 5000.0),
        parameter("gain", "factor on the command: 0 opens the loop", "1", Slot::Gain).within(-100.0, 100.0),
        parameter("prediction", "the command is given as it will be so much later if the inputs stay as they were in the last step; the communication step where a host steps all units at once", "s", Slot::Prediction).within(0.0, 0.1),
        parameter("initial_plunge", "plunge at the start, at rest", "ft", Slot::InitialPlunge),
        parameter("initial_pitch", "pitch at the start, at rest", "deg", Slot::InitialPitch),
    ])
});

impl Model for BactWing {
    type Start = ();
    type Slot = Slot;
    type Memory = Memory;

    const IDENTIFIER: &'static str = "BactWing";

    fn start(request: &Request) -> Result<()> {
        request.expect_guid(&Self::guid(&()))
    }

    fn guid((): &()) -> String {
        GUID.into()
    }

    fn new((): &(), _kind: Kind) -> Self {
        Self { memory: Memory::default(), derived: None }
    }

    fn variables() -> &'static Variables<Slot> {
        &VARIABLES
    }

    fn get(&self, slot: Slot, now: Phase) -> Result<Value> {
        let started;
        let memory = if now.is_initialized() {
            &self.memory
        } else {
            started = {
                let mut memory = self.memory.clone();
                memory.start();
                memory
            };
            &started
        };
        Ok(Value::Real(match slot {
            Slot::Input(index) => memory.inputs[index],
            Slot::Pitch => memory.states[PITCH].to_degrees(),
            Slot::Plunge => memory.states[PLUNGE],
            Slot::Command => match &self.derived {
                Some(derived) if now.is_initialized() => derived.command(memory),
                _ => Derived::new(memory)?.command(memory),
            },
            Slot::Pressure => memory.condition.pressure_psf,
            Slot::Speed => memory.condition.speed_ft_s,
            Slot::Gain => memory.condition.gain,
            Slot::Prediction => memory.prediction_s,
            Slot::InitialPlunge => memory.initial_plunge_ft,
            Slot::InitialPitch => memory.initial_pitch_deg,
        }))
    }

    fn set(&mut self, slot: Slot, value: Value) {
        let Some(value) = value.real() else { return };
        let memory = &mut self.memory;
        match slot {
            Slot::Input(index) => (memory.inputs[index], memory.slopes[index]) = (value, 0.0),
            Slot::Pressure => memory.condition.pressure_psf = value,
            Slot::Speed => memory.condition.speed_ft_s = value,
            Slot::Gain => memory.condition.gain = value,
            Slot::Prediction => memory.prediction_s = value,
            Slot::InitialPlunge => memory.initial_plunge_ft = value,
            Slot::InitialPitch => memory.initial_pitch_deg = value,
            Slot::Pitch | Slot::Plunge | Slot::Command => {}
        }
    }

    fn memory(&self) -> &Memory {
        &self.memory
    }

    fn restore(&mut self, memory: Memory, now: Phase) -> Result<()> {
        if now.is_initialized() {
            let unchanged = (memory.condition, memory.prediction_s);
            if self.derived.as_ref().is_none_or(|derived| derived.from != unchanged) {
                self.derived = Some(Derived::new(&memory)?);
            }
        }
        self.memory = memory;
        Ok(())
    }

    fn initialize(&mut self, _time: f64) -> Result<()> {
        self.derived = Some(Derived::new(&self.memory)?);
        self.memory.start();
        Ok(())
    }

    fn step(&mut self, _time: f64, duration: f64) -> Result<()> {
        let memory = &mut self.memory;
        let Some(derived) = &mut self.derived else { return Err(not_initialized()) };
        if duration > LONGEST_STEP_S {
            return Err(Error::new("step", format!("{duration} s"), format!("up to {LONGEST_STEP_S} s")));
        }
        let transition = match &mut derived.step {
            Some((unchanged, transition)) if *unchanged == duration => transition,
            step => &mut step.insert((duration, Transition::new(&derived.system, duration))).1,
        };
        let (inputs, slopes) = (SVector::from(memory.inputs), SVector::from(memory.slopes));
        let moved = transition.apply(&memory.states.into(), &inputs, &slopes);
        if !moved.iter().all(|value| value.is_finite()) {
            return Err(Error::new("motion", "beyond all numbers", "shorter steps").remedy("is the loop stable?"));
        }
        memory.states = moved.into();
        memory.inputs = (inputs + slopes * duration).into();
        memory.inputs_at_step_end = memory.inputs;
        Ok(())
    }

    fn set_input_derivatives(&mut self, items: &[(&'static Variable<Slot>, i32, f64)]) -> Result<()> {
        for (variable, order, _) in items {
            if !matches!(variable.slot, Slot::Input(_)) {
                return Err(Error::new("input", format!("`{}`", variable.name), "deflection, gust, force"));
            }
            if *order != 1 {
                return Err(Error::new("order of an input derivative", order, 1));
            }
        }
        for (variable, _, value) in items {
            if let Slot::Input(index) = variable.slot {
                self.memory.slopes[index] = *value;
            }
        }
        Ok(())
    }

    fn output_derivative(&self, variable: &'static Variable<Slot>, order: i32) -> Result<f64> {
        let Some(derived) = &self.derived else { return Err(not_initialized()) };
        if order != 1 {
            return Err(Error::new("order of an output derivative", order, 1));
        }
        let memory = &self.memory;
        let rate = |states: SVector<f64, STATES>| {
            derived.system.states * states + derived.system.inputs * SVector::from(memory.inputs_at_step_end)
        };
        let now = SVector::from(memory.states);
        match variable.slot {
            Slot::Pitch => Ok(rate(now)[PITCH].to_degrees()),
            Slot::Plunge => Ok(rate(now)[PLUNGE]),
            Slot::Command => {
                let predicted = derived.predicted.apply(&now, &memory.inputs_at_step_end.into(), &SVector::zeros());
                Ok((derived.system.command * rate(predicted))[0])
            }
            _ => Err(Error::new("output", format!("`{}`", variable.name), "pitch, plunge, command")),
        }
    }
}

fn not_initialized() -> Error {
    Error::new("wing", "not initialized", "steps after initialization mode")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fluttering() -> BactWing {
        let mut wing = BactWing::new(&(), Kind::CoSimulation);
        wing.set(Slot::Pressure, Value::Real(1000.0));
        wing.set(Slot::InitialPlunge, Value::Real(0.1));
        wing.initialize(0.0).unwrap();
        wing
    }

    #[test]
    fn a_step_that_is_too_long_is_refused_and_leaves_the_wing_where_it_was() {
        for duration_s in [1e300, f64::INFINITY] {
            let mut wing = fluttering();
            let before = wing.memory.clone();
            assert!(wing.step(0.0, duration_s).is_err(), "{duration_s} s");
            assert_eq!(wing.memory, before);
        }
    }

    #[test]
    fn flutter_ends_in_a_refused_step_and_not_in_infinity() {
        let mut wing = fluttering();
        assert!((0..1000).any(|_| wing.step(0.0, 10.0).is_err()));
        assert!(wing.memory.states.iter().all(|value| value.is_finite()));
    }
}
