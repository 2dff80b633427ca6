//! A model that has nothing to do with actuators, as an FMU: a first-order lag, `time ẏ = u - y`. Driven through its C functions, for
//! co-simulation and for model exchange.
#![allow(missing_docs, clippy::unwrap_used, unsafe_code)]

use std::{
    cell::RefCell,
    ffi::{CStr, CString, c_char, c_double, c_int, c_void},
    ptr::null_mut,
};

use fmi_export::description::{Capabilities, Dependencies, Describe, Header, Unit, xml};
use fmi_export::{
    Causality, Error, Instance, Kind, Model, Phase, Request, Result, Value, Variability, Variable, Variables,
    abi::Component,
};
use serde::{Deserialize, Serialize};

const GUID: &str = "{lag}";

#[derive(Debug, Clone, Copy, PartialEq)]
enum Slot {
    Input,
    Output,
    Slope,
    Time,
}

#[derive(Clone, Serialize, Deserialize)]
struct Memory {
    input: f64,
    output: f64,
    time: f64,
}

struct Lag(Memory);

impl Model for Lag {
    type Start = ();
    type Slot = Slot;
    type Memory = Memory;

    const IDENTIFIER: &'static str = "Lag";
    const KINDS: &'static [Kind] = &[Kind::CoSimulation, Kind::ModelExchange];
    const STATES: usize = 1;

    fn start(request: &Request) -> Result<()> {
        assert!(request.name != "panics", "a name that panics");
        request.expect_guid(GUID)
    }

    fn guid((): &()) -> String {
        GUID.into()
    }

    fn new((): &(), _kind: Kind) -> Self {
        Self(Memory { input: 0.0, output: 0.0, time: 1.0 })
    }

    fn variables() -> &'static Variables<Slot> {
        use {Causality::*, Variability::*};
        static ALL: std::sync::OnceLock<Variables<Slot>> = std::sync::OnceLock::new();
        ALL.get_or_init(|| {
            Variables::new(vec![
                Variable::real("u", "input", Input, Continuous, "1", Slot::Input),
                Variable::real("y", "output", Output, Continuous, "1", Slot::Output),
                Variable::real("der(y)", "its derivative", Local, Continuous, "1/s", Slot::Slope),
                Variable::real("time_constant", "time constant", Parameter, Fixed, "s", Slot::Time).within(1e-3, 1e3),
            ])
        })
    }

    fn get(&self, slot: Slot, _now: Phase) -> Result<Value> {
        let Memory { input, output, time } = self.0;
        Ok(Value::Real(match slot {
            Slot::Input => input,
            Slot::Output => output,
            Slot::Slope => (input - output) / time,
            Slot::Time => time,
        }))
    }

    fn set(&mut self, slot: Slot, value: Value) {
        let Some(value) = value.real() else { return };
        match slot {
            Slot::Input => self.0.input = value,
            Slot::Time => self.0.time = value,
            Slot::Output | Slot::Slope => {}
        }
    }

    fn memory(&self) -> &Memory {
        &self.0
    }

    fn restore(&mut self, memory: Memory, _now: Phase) -> Result<()> {
        self.0 = memory;
        Ok(())
    }

    fn step(&mut self, _time: f64, duration: f64) -> Result<()> {
        // Forbidden in a host's process; only for the test.
        assert!(self.0.input < 1e6, "an input that panics");
        let Memory { input, output, time } = self.0;
        self.0.output = input + (output - input) * (-duration / time).exp();
        Ok(())
    }

    fn take_warning(&mut self) -> Option<String> {
        (self.0.input > 1e5).then(|| "an input that is worth a word".to_owned())
    }

    fn states(&self, into: &mut [f64]) {
        into[0] = self.0.output;
    }

    fn set_states(&mut self, states: &[f64]) {
        self.0.output = states[0];
    }

    fn derivatives(&self, into: &mut [f64]) -> Result<()> {
        into[0] = (self.0.input - self.0.output) / self.0.time;
        Ok(())
    }
}

fmi_export::export!(Lag);

use fmi2::*;

/// `fmi2CallbackFunctions` of a host that stores the messages by thread.
#[repr(C)]
struct Callbacks {
    logger: extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char),
    others: [*const c_void; 4],
}

thread_local!(static MESSAGES: RefCell<Vec<(c_int, String, String)>> = const { RefCell::new(Vec::new()) });

/// Named arguments only: there are none after the message.
extern "C" fn keep(_: *mut c_void, _: *const c_char, status: c_int, category: *const c_char, text: *const c_char) {
    // SAFETY: the instance passes strings.
    let [category, text] = [category, text].map(|start| unsafe { CStr::from_ptr(start) }.to_str().unwrap().to_owned());
    MESSAGES.with_borrow_mut(|messages| messages.push((status, category, text)));
}

fn logged(name: &str, logging_on: bool) -> Component {
    let callbacks = Callbacks { logger: keep, others: [std::ptr::null(); 4] };
    let [name, guid] = [name, GUID].map(|text| CString::new(text).unwrap());
    let functions = (&raw const callbacks).cast();
    fmi2Instantiate(name.as_ptr(), 1, guid.as_ptr(), std::ptr::null(), functions, 0, logging_on.into())
}

fn messages() -> Vec<(c_int, String, String)> {
    MESSAGES.with_borrow_mut(std::mem::take)
}

#[test]
#[cfg_attr(miri, ignore = "stable Rust cannot define the logger with the arguments that C has")]
fn a_panic_while_instantiating_is_told() {
    assert!(logged("panics", false).is_null());
    let found = messages();
    assert!(found.len() == 1 && found[0].2.contains("a name that panics"), "{found:?}");
}

#[test]
#[cfg_attr(miri, ignore = "stable Rust cannot define the logger with the arguments that C has")]
fn a_warning_has_its_status_and_its_category() {
    let component = logged("warns", true);
    assert_eq!(fmi2EnterInitializationMode(component), 0);
    assert_eq!(fmi2SetReal(component, [0].as_ptr(), 1, [2e5].as_ptr()), 0);
    assert_eq!(fmi2ExitInitializationMode(component), 0);
    messages();
    assert_eq!(fmi2DoStep(component, 0.0, 0.1, 1), 1);
    let found = messages();
    assert!(found[0].0 == 1 && found[0].1 == "logStatusWarning" && found[0].2.contains("worth a word"), "{found:?}");
    // The status is that of the call, whether the message is logged or not.
    let category = CString::new("logStatusError").unwrap();
    assert_eq!(fmi2SetDebugLogging(component, 1, 1, [category.as_ptr()].as_ptr()), 0);
    assert_eq!(fmi2DoStep(component, 0.1, 0.1, 1), 1);
    assert!(messages().is_empty());
    fmi2FreeInstance(component);
}

#[test]
#[cfg_attr(miri, ignore = "stable Rust cannot define the logger with the arguments that C has")]
fn messages_of_a_lost_instance_pass_the_filter_of_the_host() {
    let component = logged("lost", false);
    assert_eq!(fmi2EnterInitializationMode(component), 0);
    assert_eq!(fmi2SetReal(component, [0].as_ptr(), 1, [1e7].as_ptr()), 0);
    assert_eq!(fmi2ExitInitializationMode(component), 0);
    assert_eq!(fmi2DoStep(component, 0.0, 0.1, 1), 4);
    assert_eq!(fmi2DoStep(component, 0.0, 0.1, 1), 4);
    assert_eq!(messages().len(), 2);
    fmi2FreeInstance(component);

    let component = logged("lost", false);
    assert_eq!(fmi2SetDebugLogging(component, 0, 0, std::ptr::null()), 0);
    assert_eq!(fmi2EnterInitializationMode(component), 0);
    assert_eq!(fmi2SetReal(component, [0].as_ptr(), 1, [1e7].as_ptr()), 0);
    assert_eq!(fmi2ExitInitializationMode(component), 0);
    assert_eq!(fmi2DoStep(component, 0.0, 0.1, 1), 4);
    assert_eq!(fmi2DoStep(component, 0.0, 0.1, 1), 4);
    assert!(messages().is_empty());
    fmi2FreeInstance(component);
}

const ERROR: c_int = 3;

fn instantiate(kind: c_int) -> Component {
    let [name, guid] = ["lag", GUID].map(|text| CString::new(text).unwrap());
    fmi2Instantiate(name.as_ptr(), kind, guid.as_ptr(), std::ptr::null::<c_char>(), std::ptr::null(), 0, 0)
}

fn initialized(kind: c_int) -> Component {
    let component = instantiate(kind);
    assert!(!component.is_null());
    assert_eq!(fmi2SetupExperiment(component, 0, 0.0, 0.0, 0, 0.0), 0);
    assert_eq!(fmi2EnterInitializationMode(component), 0);
    assert_eq!(fmi2SetReal(component, [3].as_ptr(), 1, [0.5].as_ptr()), 0);
    assert_eq!(fmi2SetReal(component, [0].as_ptr(), 1, [2.0].as_ptr()), 0);
    assert_eq!(fmi2ExitInitializationMode(component), 0);
    component
}

fn output(component: Component) -> c_double {
    let mut value = [0.0];
    assert_eq!(fmi2GetReal(component, [1].as_ptr(), 1, value.as_mut_ptr()), 0);
    value[0]
}

/// 2 (1 - e^(-t / 0.5))
fn exact(time: f64) -> f64 {
    -2.0 * (-time / 0.5).exp_m1()
}

#[test]
fn it_is_stepped_saved_and_restored() {
    let component = initialized(1);
    assert_eq!(fmi2DoStep(component, 0.0, 0.3, 1), 0);
    assert!((output(component) - exact(0.3)).abs() < 1e-15);
    let mut state = null_mut();
    assert_eq!(fmi2GetFMUstate(component, &raw mut state), 0);
    assert_eq!(fmi2DoStep(component, 0.3, 0.3, 1), 0);
    let later = output(component);
    assert_eq!(fmi2SetFMUstate(component, state), 0);
    assert_eq!(fmi2DoStep(component, 0.3, 0.3, 1), 0);
    assert_eq!(output(component), later);
    fmi2FreeInstance(component);
    assert_eq!(fmi2DoStep(component, 0.6, 0.3, 1), ERROR);
}

#[test]
fn it_is_integrated_by_the_host() {
    let component = initialized(0);
    let (steps, h) = (1000, 1e-3);
    assert_eq!(fmi2EnterContinuousTimeMode(component), 0);
    let (mut y, mut slope) = ([0.0], [0.0]);
    for step in 0..steps {
        // Midpoint rule: an error of h² / 24 of the third derivative, 16, over 1 s.
        let mut at = |share: f64, y: f64| {
            assert_eq!(fmi2SetTime(component, h * (f64::from(step) + share)), 0);
            assert_eq!(fmi2SetContinuousStates(component, [y].as_ptr(), 1), 0);
            assert_eq!(fmi2GetDerivatives(component, slope.as_mut_ptr(), 1), 0);
            slope[0]
        };
        let first = at(0.0, y[0]);
        y[0] += h * at(0.5, y[0] + 0.5 * h * first);
    }
    assert!((y[0] - exact(1.0)).abs() < 1e-6, "{} {}", y[0], exact(1.0));
    assert_eq!(fmi2DoStep(component, 1.0, 0.1, 1), ERROR);
    fmi2FreeInstance(component);
}

#[test]
fn a_panic_loses_the_instance_and_not_the_host() {
    let component = initialized(1);
    assert_eq!(fmi2SetReal(component, [0].as_ptr(), 1, [1e7].as_ptr()), 0);
    assert_eq!(fmi2DoStep(component, 0.0, 0.1, 1), 4);
    assert_eq!(fmi2DoStep(component, 0.0, 0.1, 1), 4);
    fmi2FreeInstance(component);
}

#[test]
fn what_it_cannot_do_is_refused_with_a_word() {
    let mut instance = Instance::<Lag>::new((), false);
    let refusal = |result: Result<(), Error>| result.unwrap_err().to_string();
    assert!(refusal(instance.set([(1, Value::Real(1.0))].into_iter())).contains("`y`, which is calculated"));
    assert!(refusal(instance.set([(3, Value::Real(0.0))].into_iter())).contains("0.001 to 1000 s"));
    assert!(refusal(instance.set([(9, Value::Real(0.0))].into_iter())).contains("0 to 3"));
    assert!(refusal(instance.do_step(0.0, 1.0)).contains("step complete"));
    instance.enter_initialization_mode().unwrap();
    instance.exit_initialization_mode().unwrap();
    assert!(refusal(instance.set_input_derivatives([(0, 1, 1.0)].into_iter())).contains("input derivatives"));
    assert!(refusal(instance.partial_derivative(1, 0).map(drop)).contains("directional derivatives"));
    assert!(refusal(instance.set_time(1.0)).contains("instances for model exchange"));
    let mut other = Instance::<Lag>::of_kind(Kind::ModelExchange, (), false);
    let saved = instance.save(None).unwrap();
    let bytes = instance.serialize(saved).unwrap();
    assert!(refusal(other.deserialize(&bytes, None).map(drop)).contains("model exchange"));
    assert!(refusal(other.continuous_states(&mut [0.0])).contains("instantiated"));
}

#[test]
fn another_guid_makes_no_instance() {
    let [name, guid] = ["lag", "{other}"].map(|text| CString::new(text).unwrap());
    let component =
        fmi2Instantiate(name.as_ptr(), 1, guid.as_ptr(), std::ptr::null::<c_char>(), std::ptr::null(), 0, 0);
    assert!(component.is_null());
}

struct Described;

impl Describe<Lag> for Described {
    fn start(&self, slot: Slot) -> Option<Value> {
        matches!(slot, Slot::Input | Slot::Time).then_some(Value::Real(1.0))
    }

    fn state_of(&self, derivative: Slot) -> Option<Slot> {
        (derivative == Slot::Slope).then_some(Slot::Output)
    }

    fn dependencies(&self, unknown: Slot) -> Dependencies<'_, Slot> {
        Dependencies::On(Box::new(move |known| (known == unknown) != (unknown == Slot::Slope)))
    }

    fn initial_dependencies(&self, unknown: Slot) -> Dependencies<'_, Slot> {
        if unknown == Slot::Slope { Dependencies::All } else { Dependencies::none() }
    }
}

#[test]
fn its_description_is_written_from_its_variables() {
    let units = [Unit { name: "s", kg_m_s_rad: [0, 0, 1, 0], factor: 1.0, display: Some(("ms", 1e3)) }];
    let header = Header {
        name: "A & B",
        guid: GUID,
        description: "a lag",
        version: "1",
        license: "MIT",
        generation_tool: "test",
        has_structured_names: true,
        capabilities: Capabilities::default(),
        units: &units,
        enumerations: &[],
        experiment: Some([0.0, 1.0, 0.1]),
    };
    let text = xml(&header, &Described);
    for expected in [
        "modelName=\"A &amp; B\" guid=\"{lag}\"",
        "numberOfEventIndicators=\"0\">\n  <ModelExchange modelIdentifier=\"Lag\" canNot",
        "  <CoSimulation modelIdentifier=\"Lag\" canHandleVariableCommunicationStepSize=\"true\" canNot",
        "    <Unit name=\"s\">\n      <BaseUnit s=\"1\"/>\n      <DisplayUnit name=\"ms\" factor=\"1000\"/>\n    </Unit>",
        "name=\"der(y)\" valueReference=\"2\" description=\"its derivative\" causality=\"local\"",
        "<Real unit=\"1/s\" derivative=\"2\"/>",
        "<Real unit=\"s\" min=\"0.001\" max=\"1000\" start=\"1\"/>",
        "<Outputs>\n      <Unknown index=\"2\" dependencies=\"2\"/>\n    </Outputs>",
        "<Derivatives>\n      <Unknown index=\"3\" dependencies=\"1 2 4\"/>\n    </Derivatives>",
        "<InitialUnknowns>\n      <Unknown index=\"2\" dependencies=\"\"/>\n      <Unknown index=\"3\"/>\n",
    ] {
        assert!(text.contains(expected), "{expected}\nin\n{text}");
    }
}
