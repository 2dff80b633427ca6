//! Any function with any arguments.

use std::ptr::{null, null_mut};

use fmi_export::abi::Component;

use super::{
    arguments::{Of, count, duration, item_of, number, one_in, pick, references, value_of, whole},
    life::{Life, OK},
    sound::{INDICATORS, STATES},
    states::{disturbed, serialized},
};

/// Finite, if the call has succeeded.
fn assert_finite(name: &str, status: i32, values: &[f64]) {
    assert!(status > 1 || values.iter().all(|value| value.is_finite()), "{name}: {values:?}");
}

/// Calls one function.
pub(super) fn call(life: &mut Life<'_>) {
    let component = life.any_component();
    match life.rng.u8(..100) {
        0..14 => reals(life, component),
        14..22 => whole_numbers(life, component),
        22..25 => texts(life, component),
        25..36 => states(life, component),
        36..40 => directional_derivative(life, component),
        40..48 => derivatives_of_inputs_and_outputs(life, component),
        48..54 => {
            let (current, duration) = (number(&mut life.rng), duration(&mut life.rng));
            life.call("fmi2DoStep", component, |f| (f.fmi2DoStep)(component, current, duration, 0));
        }
        54..60 => status(life, component),
        60..80 => exchange(life, component),
        80..84 => logging(life, component),
        84..86 => life.instantiate_wrongly(),
        86 => life.free_in_logger(),
        _ => phases(life, component),
    }
}

fn reals(life: &mut Life<'_>, component: Component) {
    let n = count(&mut life.rng);
    let references = references(&mut life.rng, n, Of::Real, &[]);
    let mut values: Vec<f64> = references.iter().map(|reference| value_of(&mut life.rng, *reference)).collect();
    match life.rng.u8(..16) {
        0 => {
            life.call("fmi2SetReal", component, |f| (f.fmi2SetReal)(component, null(), n, values.as_ptr()));
            life.call("fmi2GetReal", component, |f| (f.fmi2GetReal)(component, references.as_ptr(), n, null_mut()));
        }
        1 => {
            // A misaligned address, and a length beyond any memory.
            let aside = values.as_mut_ptr().wrapping_byte_add(1);
            life.call("fmi2GetReal", component, |f| (f.fmi2GetReal)(component, references.as_ptr(), n.max(1), aside));
            let place = values.as_mut_ptr();
            life.call("fmi2GetReal", component, |f| (f.fmi2GetReal)(component, null(), usize::MAX, place));
        }
        2..9 => {
            let status = life.call("fmi2GetReal", component, |f| {
                (f.fmi2GetReal)(component, references.as_ptr(), n, values.as_mut_ptr())
            });
            assert_finite("fmi2GetReal", status, &values);
        }
        _ => {
            life.call("fmi2SetReal", component, |f| {
                (f.fmi2SetReal)(component, references.as_ptr(), n, values.as_ptr())
            });
        }
    }
}

fn whole_numbers(life: &mut Life<'_>, component: Component) {
    let n = count(&mut life.rng);
    let of = pick(&mut life.rng, &[Of::Integer, Of::Boolean]);
    let references = references(&mut life.rng, n, of, &[]);
    let mut values: Vec<i32> = references.iter().map(|reference| item_of(&mut life.rng, *reference)).collect();
    let (from, place) = (references.as_ptr(), values.as_mut_ptr());
    match life.rng.u8(..4) {
        0 => life.call("fmi2GetInteger", component, |f| (f.fmi2GetInteger)(component, from, n, place)),
        1 => life.call("fmi2SetInteger", component, |f| (f.fmi2SetInteger)(component, from, n, place)),
        2 => life.call("fmi2GetBoolean", component, |f| (f.fmi2GetBoolean)(component, from, n, place)),
        _ => life.call("fmi2SetBoolean", component, |f| (f.fmi2SetBoolean)(component, from, n, place)),
    };
}

fn texts(life: &mut Life<'_>, component: Component) {
    let n = count(&mut life.rng);
    let references = references(&mut life.rng, n, Of::Real, &[]);
    let mut values = vec![null(); n];
    if one_in(&mut life.rng, 2) {
        values.fill(c"\xff%s".as_ptr());
        life.call("fmi2SetString", component, |f| {
            (f.fmi2SetString)(component, references.as_ptr(), n, values.as_ptr())
        });
    } else {
        life.call("fmi2GetString", component, |f| {
            (f.fmi2GetString)(component, references.as_ptr(), n, values.as_mut_ptr())
        });
    }
}

fn states(life: &mut Life<'_>, component: Component) {
    let mut state = life.any_state();
    let place = &raw mut state;
    match life.rng.u8(..8) {
        0 | 1 => {
            if one_in(&mut life.rng, 2) {
                state = null_mut();
            }
            let status = life.call("fmi2GetFMUstate", component, |f| (f.fmi2GetFMUstate)(component, &raw mut state));
            if status == OK {
                life.keep_state(state);
            }
        }
        2 => {
            life.call("fmi2SetFMUstate", component, |f| (f.fmi2SetFMUstate)(component, state));
        }
        3 => {
            // Its handle is kept: a freed one will be passed again.
            life.call("fmi2FreeFMUstate", component, |f| (f.fmi2FreeFMUstate)(component, place));
        }
        4 => {
            let mut size = 0;
            life.call("fmi2SerializedFMUstateSize", component, |f| {
                (f.fmi2SerializedFMUstateSize)(component, state, &raw mut size)
            });
            let mut bytes = vec![0_u8; if one_in(&mut life.rng, 3) { 3 } else { size }];
            life.call("fmi2SerializeFMUstate", component, |f| {
                (f.fmi2SerializeFMUstate)(component, state, bytes.as_mut_ptr().cast(), bytes.len())
            });
        }
        5 => {
            if let Some(bytes) = serialized(life.f, component) {
                life.bytes.truncate(7);
                life.bytes.insert(0, bytes);
            }
        }
        _ => deserialize(life, component),
    }
}

/// Bytes of any instance of the life, mostly corrupted, for any instance; accepted ones are restored immediately, and stepped.
fn deserialize(life: &mut Life<'_>, component: Component) {
    let bytes = match life.bytes.len() {
        0 => (0..life.rng.usize(..300)).map(|_| life.rng.u8(..)).collect(),
        some => life.bytes[life.rng.usize(..some)].clone(),
    };
    let bytes = disturbed(&mut life.rng, bytes);
    let mut state = if one_in(&mut life.rng, 3) { life.any_state() } else { null_mut() };
    let status = life.call("fmi2DeSerializeFMUstate", component, |f| {
        (f.fmi2DeSerializeFMUstate)(component, bytes.as_ptr().cast(), bytes.len(), &raw mut state)
    });
    if status == OK {
        life.keep_state(state);
        life.call("fmi2SetFMUstate", component, |f| (f.fmi2SetFMUstate)(component, state));
    }
}

fn directional_derivative(life: &mut Life<'_>, component: Component) {
    let (unknowns, knowns) = (life.rng.usize(..6), life.rng.usize(..6));
    let unknown = references(&mut life.rng, unknowns, Of::Real, &[]);
    let known = references(&mut life.rng, knowns, Of::Real, &[]);
    let (seed, mut sensitivity) = (life.numbers(knowns), vec![0.0; unknowns]);
    life.call("fmi2GetDirectionalDerivative", component, |f| {
        let (unknown, known) = (unknown.as_ptr(), known.as_ptr());
        let into = sensitivity.as_mut_ptr();
        (f.fmi2GetDirectionalDerivative)(component, unknown, unknowns, known, knowns, seed.as_ptr(), into)
    });
}

fn derivatives_of_inputs_and_outputs(life: &mut Life<'_>, component: Component) {
    use actuator_fmu::fmu::variables::Causality::{Input, Output};
    let n = count(&mut life.rng);
    let orders: Vec<i32> = (0..n).map(|_| if one_in(&mut life.rng, 4) { whole(&mut life.rng) } else { 1 }).collect();
    let mut values = life.numbers(n);
    if one_in(&mut life.rng, 2) {
        let references = references(&mut life.rng, n, Of::Real, &[Input]);
        life.call("fmi2SetRealInputDerivatives", component, |f| {
            (f.fmi2SetRealInputDerivatives)(component, references.as_ptr(), n, orders.as_ptr(), values.as_ptr())
        });
    } else {
        let references = references(&mut life.rng, n, Of::Real, &[Output]);
        let status = life.call("fmi2GetRealOutputDerivatives", component, |f| {
            (f.fmi2GetRealOutputDerivatives)(component, references.as_ptr(), n, orders.as_ptr(), values.as_mut_ptr())
        });
        assert_finite("fmi2GetRealOutputDerivatives", status, &values);
    }
}

fn status(life: &mut Life<'_>, component: Component) {
    let kind = whole(&mut life.rng);
    let (mut number, mut whole, mut text) = (0.0, 0, null());
    let no_place = one_in(&mut life.rng, 8);
    let place = if no_place { null_mut() } else { &raw mut whole };
    match life.rng.u8(..5) {
        0 => life.call("fmi2GetStatus", component, |f| (f.fmi2GetStatus)(component, kind, place)),
        1 => life.call("fmi2GetRealStatus", component, |f| (f.fmi2GetRealStatus)(component, kind, &raw mut number)),
        2 => life.call("fmi2GetIntegerStatus", component, |f| (f.fmi2GetIntegerStatus)(component, kind, place)),
        3 => life.call("fmi2GetBooleanStatus", component, |f| (f.fmi2GetBooleanStatus)(component, kind, place)),
        _ => life.call("fmi2GetStringStatus", component, |f| (f.fmi2GetStringStatus)(component, kind, &raw mut text)),
    };
}

/// Functions of model exchange, mostly with valid lengths.
fn exchange(life: &mut Life<'_>, component: Component) {
    let right = if one_in(&mut life.rng, 2) { STATES } else { INDICATORS };
    let n = if one_in(&mut life.rng, 6) { count(&mut life.rng) } else { right };
    let mut values = life.numbers(n);
    let (time, place) = (number(&mut life.rng), values.as_mut_ptr());
    let (mut enter, mut terminate, mut info) = (0, 0, [0_u64; 4]);
    let info = if one_in(&mut life.rng, 6) { null_mut() } else { info.as_mut_ptr().cast() };
    match life.rng.u8(..10) {
        0 => life.call("fmi2EnterEventMode", component, |f| (f.fmi2EnterEventMode)(component)),
        1 => life.call("fmi2NewDiscreteStates", component, |f| (f.fmi2NewDiscreteStates)(component, info)),
        2 => life.call("fmi2EnterContinuousTimeMode", component, |f| (f.fmi2EnterContinuousTimeMode)(component)),
        3 => life.call("fmi2CompletedIntegratorStep", component, |f| {
            (f.fmi2CompletedIntegratorStep)(component, 0, &raw mut enter, &raw mut terminate)
        }),
        4 => life.call("fmi2SetTime", component, |f| (f.fmi2SetTime)(component, time)),
        5 => life.call("fmi2SetContinuousStates", component, |f| (f.fmi2SetContinuousStates)(component, place, n)),
        6 => life.call("fmi2GetDerivatives", component, |f| (f.fmi2GetDerivatives)(component, place, n)),
        7 => life.call("fmi2GetEventIndicators", component, |f| (f.fmi2GetEventIndicators)(component, place, n)),
        8 => life.call("fmi2GetContinuousStates", component, |f| (f.fmi2GetContinuousStates)(component, place, n)),
        _ => life.call("fmi2GetNominalsOfContinuousStates", component, |f| {
            (f.fmi2GetNominalsOfContinuousStates)(component, place, n)
        }),
    };
}

fn logging(life: &mut Life<'_>, component: Component) {
    let known =
        ["logAll", "logStatusError", "logStatusWarning"].map(|name| std::ffi::CString::new(name).expect("text"));
    let names = [known[0].as_ptr(), known[1].as_ptr(), known[2].as_ptr(), c"\xff%n".as_ptr(), null()];
    let categories: Vec<_> = (0..life.rng.usize(..3)).map(|_| pick(&mut life.rng, &names)).collect();
    let (n, on) = (categories.len(), whole(&mut life.rng));
    life.call("fmi2SetDebugLogging", component, |f| (f.fmi2SetDebugLogging)(component, on, n, categories.as_ptr()));
}

fn phases(life: &mut Life<'_>, component: Component) {
    let (tolerance, start, stop) = (number(&mut life.rng), number(&mut life.rng), number(&mut life.rng));
    let defined = whole(&mut life.rng);
    match life.rng.u8(..20) {
        0..4 => life.call("fmi2SetupExperiment", component, |f| {
            (f.fmi2SetupExperiment)(component, defined, tolerance, start, defined, stop)
        }),
        4..9 => life.call("fmi2EnterInitializationMode", component, |f| (f.fmi2EnterInitializationMode)(component)),
        9..14 => life.call("fmi2ExitInitializationMode", component, |f| (f.fmi2ExitInitializationMode)(component)),
        14 => life.call("fmi2Terminate", component, |f| (f.fmi2Terminate)(component)),
        15..17 => life.call("fmi2Reset", component, |f| (f.fmi2Reset)(component)),
        17 => life.call("fmi2CancelStep", component, |f| (f.fmi2CancelStep)(component)),
        _ => {
            assert_eq!(crate::functions::text((life.f.fmi2GetVersion)()).as_deref(), Some("2.0"));
            assert_eq!(crate::functions::text((life.f.fmi2GetTypesPlatform)()).as_deref(), Some("default"));
            life.count("fmi2GetVersion", OK);
            life.count("fmi2GetTypesPlatform", OK);
            OK
        }
    };
}
