//! Functions that a real-time host calls between two communication points do not allocate, as counted by the allocator of the test program.
#![allow(unsafe_code)]

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
    ffi::CString,
    ptr::{null, null_mut},
};

use actuator_fmu::fmu::{
    Start,
    fmi2::*,
    guid,
    variables::{Causality, variables},
};
use fmi_export::abi::Component;

/// Counts the allocations of each thread.
struct Counting;

thread_local!(static COUNT: Cell<u64> = const { Cell::new(0) });

// SAFETY: all calls are forwarded to the system's allocator; the count is a thread-local number without destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's obligations are those of the system's allocator.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(body: impl FnOnce()) -> u64 {
    let before = COUNT.with(Cell::get);
    body();
    COUNT.with(Cell::get) - before
}

fn reference(name: &str) -> u32 {
    u32::try_from(variables().iter().position(|variable| variable.name == name).unwrap()).unwrap()
}

fn instance(kind: i32, parameters: &[(&str, f64)]) -> Component {
    let [name, guid] = ["counted".to_owned(), guid(&Start::default())].map(|text| CString::new(text).unwrap());
    let component = fmi2Instantiate(name.as_ptr(), kind, guid.as_ptr(), null(), null(), 0, 0);
    assert!(!component.is_null());
    assert_eq!(fmi2SetupExperiment(component, 0, 0.0, 0.0, 0, 0.0), 0);
    assert_eq!(fmi2EnterInitializationMode(component), 0);
    for (name, value) in parameters {
        assert_eq!(fmi2SetReal(component, [reference(name)].as_ptr(), 1, [*value].as_ptr()), 0, "{name}");
    }
    assert_eq!(fmi2ExitInitializationMode(component), 0);
    component
}

const CASES: [&[(&str, f64)]; 6] = [
    &[],
    &[("rate_limit.up", 60.0), ("rate_limit.down", 60.0), ("backlash.gap", 0.5)],
    &[("coulomb_friction.level", 0.2), ("structural_mode.gain", 0.3), ("sensor_lag.time", 0.004)],
    &[("delay.time", 0.1)],
    &[("delay.time", 10.0), ("command_rate_limit.up", 20.0), ("command_backlash.gap", 0.1), ("rate_limit.up", 60.0)],
    &[
        ("amplitude_gain.cubic", 0.001),
        ("hinge_load.stiffness", 0.1),
        ("position_limit.max", 3.0),
        ("gain_drift.rate", 0.01),
    ],
];

#[test]
fn co_simulation_allocates_nothing_from_the_first_step_on() {
    let [command, load, position] = ["command", "load", "position"].map(reference);
    let [failure, saturated] = ["failure", "saturated"].map(reference);
    let outputs: Vec<u32> = (0..)
        .zip(variables())
        .filter(|(_, variable)| variable.causality == Causality::Output && variable.name != "saturated")
        .map(|(reference, _)| reference)
        .collect();
    for parameters in CASES {
        let component = instance(1, parameters);
        let mut state = null_mut();
        assert_eq!(fmi2GetFMUstate(component, &raw mut state), 0);
        let (mut values, mut flag) = (vec![0.0; outputs.len()], 0);
        let count = allocations(|| {
            for step in 0..5000 {
                let time = f64::from(step) * 1e-3;
                let value = 8.0 * (12.0 * time).sin() + f64::from(step % 7);
                let mut status = fmi2SetReal(component, [command, load].as_ptr(), 2, [value, 0.1].as_ptr());
                status |= fmi2SetRealInputDerivatives(component, [command].as_ptr(), 1, [1].as_ptr(), [3.0].as_ptr());
                status |= fmi2SetInteger(component, [failure].as_ptr(), 1, [1 + i32::from(step == 3000)].as_ptr());
                status |= fmi2DoStep(component, time, 1e-3, 0);
                status |= fmi2GetReal(component, outputs.as_ptr(), outputs.len(), values.as_mut_ptr());
                status |= fmi2GetBoolean(component, [saturated].as_ptr(), 1, &raw mut flag);
                status |=
                    fmi2GetRealOutputDerivatives(component, [position].as_ptr(), 1, [1].as_ptr(), values.as_mut_ptr());
                if step % 100 == 99 {
                    status |= fmi2GetFMUstate(component, &raw mut state);
                    status |= fmi2SetFMUstate(component, state);
                }
                assert_eq!(status, 0, "{parameters:?} step {step}");
            }
        });
        // The instances silence messages of panics.
        (count > 0).then(|| eprintln!("{count} allocations: {parameters:?}"));
        assert_eq!(count, 0);
        fmi2FreeInstance(component);
    }
}

#[test]
fn model_exchange_evaluates_without_allocation() {
    for parameters in CASES {
        let component = instance(0, parameters);
        assert_eq!(fmi2EnterContinuousTimeMode(component), 0);
        let (mut states, mut derivatives, mut indicators) = ([0.0; 7], [0.0; 7], [0.0; 64]);
        let nx = variables().iter().filter(|variable| variable.name.starts_with("der(")).count();
        let nz = actuator_fmu::actuator::Actuator::EVENT_INDICATORS;
        let count = allocations(|| {
            let mut status = fmi2GetContinuousStates(component, states.as_mut_ptr(), nx);
            for step in 1..200 {
                status |= fmi2SetTime(component, f64::from(step) * 1e-4);
                status |= fmi2SetReal(component, [reference("command")].as_ptr(), 1, [f64::from(step) * 1e-3].as_ptr());
                status |= fmi2SetContinuousStates(component, states.as_ptr(), nx);
                status |= fmi2GetDerivatives(component, derivatives.as_mut_ptr(), nx);
                status |= fmi2GetEventIndicators(component, indicators.as_mut_ptr(), nz);
            }
            assert_eq!(status, 0);
        });
        assert_eq!(count, 0, "{parameters:?}");
        fmi2FreeInstance(component);
    }
}
