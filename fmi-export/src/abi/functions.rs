//! The functions of FMI 2.0, one for one, for any model. They are safe code: what is not is in `arrays` and `host`.
#![allow(non_snake_case, missing_docs)] // names and meaning are those of the standard

use std::{
    ffi::{c_char, c_double, c_int, c_uint},
    panic::{AssertUnwindSafe, catch_unwind},
};

use super::{
    CallbackFunctions, Component, Instances, SavedState,
    arrays::{array, array_mut, place, text},
};
use crate::{
    error::{Error, Result},
    instance::Instance,
    log::{CATEGORIES, Status},
    model::Model,
    variable::Value,
};

/// `fmi2EventInfo`
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EventInfo {
    new_discrete_states_needed: c_int,
    terminate_simulation: c_int,
    nominals_of_continuous_states_changed: c_int,
    values_of_continuous_states_changed: c_int,
    next_event_time_defined: c_int,
    next_event_time: c_double,
}

// Common

#[must_use]
pub fn fmi2GetTypesPlatform<M: Model>(_: &Instances<M>) -> *const c_char {
    c"default".as_ptr()
}

#[must_use]
pub fn fmi2GetVersion<M: Model>(_: &Instances<M>) -> *const c_char {
    c"2.0".as_ptr()
}

#[allow(clippy::too_many_arguments)] // those of the standard
pub fn fmi2Instantiate<M: Model>(
    all: &Instances<M>,
    name: *const c_char,
    kind: c_int,
    guid: *const c_char,
    resources: *const c_char,
    functions: *const CallbackFunctions,
    _visible: c_int,
    logging_on: c_int,
) -> Component {
    catch_unwind(AssertUnwindSafe(|| all.instantiate(name, kind, guid, resources, functions, logging_on != 0)))
        .unwrap_or(std::ptr::null_mut())
}

pub fn fmi2FreeInstance<M: Model>(all: &Instances<M>, component: Component) {
    // A model whose destructor panics must not take the host down.
    let _ = catch_unwind(AssertUnwindSafe(|| all.free(component)));
}

pub fn fmi2SetDebugLogging<M: Model>(
    all: &Instances<M>,
    component: Component,
    logging_on: c_int,
    n: usize,
    categories: *const *const c_char,
) -> c_int {
    all.guarded(component, "fmi2SetDebugLogging", |instance| {
        let names = array("categories", categories, n)?;
        let names: Vec<String> = names.iter().map(|name| text(*name).unwrap_or_default()).collect();
        let known = CATEGORIES.map(|(name, _)| name);
        if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
            return Err(Error::new("log category", format!("`{name}`"), known.join(", ")));
        }
        instance.log.set(logging_on != 0, &names);
        Ok(())
    })
}

pub fn fmi2SetupExperiment<M: Model>(
    all: &Instances<M>,
    component: Component,
    _tolerance_defined: c_int,
    _tolerance: c_double,
    start: c_double,
    stop_defined: c_int,
    stop: c_double,
) -> c_int {
    all.guarded(component, "fmi2SetupExperiment", |instance| {
        instance.setup_experiment(start, (stop_defined != 0).then_some(stop))
    })
}

pub fn fmi2EnterInitializationMode<M: Model>(all: &Instances<M>, component: Component) -> c_int {
    all.guarded(component, "fmi2EnterInitializationMode", Instance::enter_initialization_mode)
}

pub fn fmi2ExitInitializationMode<M: Model>(all: &Instances<M>, component: Component) -> c_int {
    all.guarded(component, "fmi2ExitInitializationMode", Instance::exit_initialization_mode)
}

pub fn fmi2Terminate<M: Model>(all: &Instances<M>, component: Component) -> c_int {
    all.guarded(component, "fmi2Terminate", Instance::terminate)
}

pub fn fmi2Reset<M: Model>(all: &Instances<M>, component: Component) -> c_int {
    all.guarded(component, "fmi2Reset", Instance::reset)
}

fn get<M: Model, T>(
    all: &Instances<M>,
    component: Component,
    name: &str,
    (references, n, values): (*const c_uint, usize, *mut T),
    pick: impl Fn(&Instance<M>, u32) -> Result<T>,
) -> c_int {
    all.guarded(component, name, |instance| {
        let (references, values) = (array("vr", references, n)?, array_mut("value", values, n)?);
        for (value, reference) in values.iter_mut().zip(references) {
            *value = pick(instance, *reference)?;
        }
        Ok(())
    })
}

fn set<M: Model, T: Copy>(
    all: &Instances<M>,
    component: Component,
    name: &str,
    (references, n, values): (*const c_uint, usize, *const T),
    wrap: impl Fn(T) -> Value + Clone,
) -> c_int {
    all.guarded(component, name, |instance| {
        let (references, values) = (array("vr", references, n)?, array("value", values, n)?);
        instance.set(references.iter().copied().zip(values.iter().map(|value| wrap(*value))))
    })
}

/// Strings: models have none, so that every reference is a wrong one.
fn none_of_type<M: Model>(
    all: &Instances<M>,
    component: Component,
    name: &str,
    references: *const c_uint,
    n: usize,
) -> c_int {
    all.guarded(component, name, |_| match array("vr", references, n)?.first() {
        None => Ok(()),
        Some(reference) => {
            Err(Error::new("value reference", reference, "none: the model has no variable of this type"))
        }
    })
}

pub fn fmi2GetReal<M: Model>(
    all: &Instances<M>,
    component: Component,
    references: *const c_uint,
    n: usize,
    values: *mut c_double,
) -> c_int {
    get(all, component, "fmi2GetReal", (references, n, values), Instance::get_real)
}

pub fn fmi2GetInteger<M: Model>(
    all: &Instances<M>,
    component: Component,
    references: *const c_uint,
    n: usize,
    values: *mut c_int,
) -> c_int {
    get(all, component, "fmi2GetInteger", (references, n, values), Instance::get_integer)
}

pub fn fmi2GetBoolean<M: Model>(
    all: &Instances<M>,
    component: Component,
    references: *const c_uint,
    n: usize,
    values: *mut c_int,
) -> c_int {
    get(all, component, "fmi2GetBoolean", (references, n, values), |instance, reference| {
        instance.get_boolean(reference).map(c_int::from)
    })
}

pub fn fmi2GetString<M: Model>(
    all: &Instances<M>,
    component: Component,
    references: *const c_uint,
    n: usize,
    _values: *mut *const c_char,
) -> c_int {
    none_of_type(all, component, "fmi2GetString", references, n)
}

pub fn fmi2SetReal<M: Model>(
    all: &Instances<M>,
    component: Component,
    references: *const c_uint,
    n: usize,
    values: *const c_double,
) -> c_int {
    set(all, component, "fmi2SetReal", (references, n, values), Value::Real)
}

pub fn fmi2SetInteger<M: Model>(
    all: &Instances<M>,
    component: Component,
    references: *const c_uint,
    n: usize,
    values: *const c_int,
) -> c_int {
    set(all, component, "fmi2SetInteger", (references, n, values), Value::Integer)
}

pub fn fmi2SetBoolean<M: Model>(
    all: &Instances<M>,
    component: Component,
    references: *const c_uint,
    n: usize,
    values: *const c_int,
) -> c_int {
    set(all, component, "fmi2SetBoolean", (references, n, values), |value| Value::Boolean(value != 0))
}

pub fn fmi2SetString<M: Model>(
    all: &Instances<M>,
    component: Component,
    references: *const c_uint,
    n: usize,
    _values: *const *const c_char,
) -> c_int {
    none_of_type(all, component, "fmi2SetString", references, n)
}

// Saved states

fn handle(state: SavedState) -> Option<usize> {
    (!state.is_null()).then_some(state as usize)
}

fn given(state: SavedState) -> Result<usize> {
    handle(state).ok_or_else(|| Error::new("FMUstate", "NULL", "a saved state"))
}

pub fn fmi2GetFMUstate<M: Model>(all: &Instances<M>, component: Component, state: *mut SavedState) -> c_int {
    all.guarded(component, "fmi2GetFMUstate", |instance| {
        let state = place("FMUstate", state)?;
        *state = instance.save(handle(*state))? as SavedState;
        Ok(())
    })
}

pub fn fmi2SetFMUstate<M: Model>(all: &Instances<M>, component: Component, state: SavedState) -> c_int {
    all.guarded(component, "fmi2SetFMUstate", |instance| instance.restore(given(state)?))
}

pub fn fmi2FreeFMUstate<M: Model>(all: &Instances<M>, component: Component, state: *mut SavedState) -> c_int {
    all.guarded(component, "fmi2FreeFMUstate", |instance| {
        // The standard: freeing NULL, or what a NULL pointer would point to, does nothing.
        if state.is_null() {
            return Ok(());
        }
        let state = place("FMUstate", state)?;
        if let Some(handle) = handle(*state) {
            instance.free(handle)?;
            *state = std::ptr::null_mut();
        }
        Ok(())
    })
}

pub fn fmi2SerializedFMUstateSize<M: Model>(
    all: &Instances<M>,
    component: Component,
    state: SavedState,
    size: *mut usize,
) -> c_int {
    all.guarded(component, "fmi2SerializedFMUstateSize", |instance| {
        *place("size", size)? = instance.serialize(given(state)?)?.len();
        Ok(())
    })
}

pub fn fmi2SerializeFMUstate<M: Model>(
    all: &Instances<M>,
    component: Component,
    state: SavedState,
    bytes: *mut c_char,
    size: usize,
) -> c_int {
    all.guarded(component, "fmi2SerializeFMUstate", |instance| {
        let written = instance.serialize(given(state)?)?;
        if size < written.len() {
            return Err(Error::new("size", size, format!("{} or more", written.len())));
        }
        array_mut("serializedState", bytes.cast::<u8>(), size)?[..written.len()].copy_from_slice(&written);
        Ok(())
    })
}

pub fn fmi2DeSerializeFMUstate<M: Model>(
    all: &Instances<M>,
    component: Component,
    bytes: *const c_char,
    size: usize,
    state: *mut SavedState,
) -> c_int {
    all.guarded(component, "fmi2DeSerializeFMUstate", |instance| {
        let state = place("FMUstate", state)?;
        let bytes = array("serializedState", bytes.cast::<u8>(), size)?;
        *state = instance.deserialize(bytes, handle(*state))? as SavedState;
        Ok(())
    })
}

#[allow(clippy::too_many_arguments)] // those of the standard
pub fn fmi2GetDirectionalDerivative<M: Model>(
    all: &Instances<M>,
    component: Component,
    unknowns: *const c_uint,
    n_unknowns: usize,
    knowns: *const c_uint,
    n_knowns: usize,
    seed: *const c_double,
    sensitivity: *mut c_double,
) -> c_int {
    all.guarded(component, "fmi2GetDirectionalDerivative", |instance| {
        let (unknowns, knowns) = (array("vUnknown_ref", unknowns, n_unknowns)?, array("vKnown_ref", knowns, n_knowns)?);
        let (seed, sensitivity) = (array("dvKnown", seed, n_knowns)?, array_mut("dvUnknown", sensitivity, n_unknowns)?);
        for (sum, unknown) in sensitivity.iter_mut().zip(unknowns) {
            *sum = 0.0;
            for (known, seed) in knowns.iter().zip(seed) {
                *sum += instance.partial_derivative(*unknown, *known)? * seed;
            }
        }
        Ok(())
    })
}

// Co-simulation

pub fn fmi2SetRealInputDerivatives<M: Model>(
    all: &Instances<M>,
    component: Component,
    references: *const c_uint,
    n: usize,
    orders: *const c_int,
    values: *const c_double,
) -> c_int {
    all.guarded(component, "fmi2SetRealInputDerivatives", |instance| {
        let (references, orders, values) =
            (array("vr", references, n)?, array("order", orders, n)?, array("value", values, n)?);
        let items = references.iter().zip(orders).zip(values);
        let items: Vec<_> = items.map(|((reference, order), value)| (*reference, *order, *value)).collect();
        instance.set_input_derivatives(&items)
    })
}

pub fn fmi2GetRealOutputDerivatives<M: Model>(
    all: &Instances<M>,
    component: Component,
    references: *const c_uint,
    n: usize,
    orders: *const c_int,
    values: *mut c_double,
) -> c_int {
    all.guarded(component, "fmi2GetRealOutputDerivatives", |instance| {
        let (references, orders, values) =
            (array("vr", references, n)?, array("order", orders, n)?, array_mut("value", values, n)?);
        for (value, (reference, order)) in values.iter_mut().zip(references.iter().zip(orders)) {
            *value = instance.output_derivative(*reference, *order)?;
        }
        Ok(())
    })
}

pub fn fmi2DoStep<M: Model>(
    all: &Instances<M>,
    component: Component,
    current: c_double,
    duration: c_double,
    _no_set_state_prior: c_int,
) -> c_int {
    all.guarded(component, "fmi2DoStep", |instance| instance.do_step(current, duration))
}

pub fn fmi2CancelStep<M: Model>(all: &Instances<M>, component: Component) -> c_int {
    all.guarded(component, "fmi2CancelStep", |instance| instance.cancel_step())
}

const NO_STATUS: c_int = -1;
const DO_STEP_STATUS: c_int = 0;
const PENDING_STATUS: c_int = 1;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

/// Steps are never pending, so that each kind of status has one answer; another kind is discarded.
fn status<M: Model, T>(
    all: &Instances<M>,
    component: Component,
    name: &str,
    (kind, answered): (c_int, c_int),
    value: *mut T,
    answer: impl FnOnce(&Instance<M>) -> Result<T>,
) -> c_int {
    all.guarded(component, name, |instance| {
        let answer = || {
            if kind != answered {
                let allowed = if answered == NO_STATUS { "none of this type".to_owned() } else { answered.to_string() };
                return Err(Error::new("fmi2StatusKind", kind, allowed));
            }
            *place("value", value)? = answer(instance)?;
            Ok(())
        };
        answer().map_err(Error::discarded)
    })
}

pub fn fmi2GetStatus<M: Model>(all: &Instances<M>, component: Component, kind: c_int, value: *mut c_int) -> c_int {
    status(all, component, "fmi2GetStatus", (kind, DO_STEP_STATUS), value, |_| Ok(Status::Ok as c_int))
}

pub fn fmi2GetRealStatus<M: Model>(
    all: &Instances<M>,
    component: Component,
    kind: c_int,
    value: *mut c_double,
) -> c_int {
    status(all, component, "fmi2GetRealStatus", (kind, LAST_SUCCESSFUL_TIME), value, Instance::last_successful_time)
}

pub fn fmi2GetIntegerStatus<M: Model>(
    all: &Instances<M>,
    component: Component,
    kind: c_int,
    value: *mut c_int,
) -> c_int {
    status(all, component, "fmi2GetIntegerStatus", (kind, NO_STATUS), value, |_| Ok(0))
}

pub fn fmi2GetBooleanStatus<M: Model>(
    all: &Instances<M>,
    component: Component,
    kind: c_int,
    value: *mut c_int,
) -> c_int {
    status(all, component, "fmi2GetBooleanStatus", (kind, TERMINATED), value, |_| Ok(0))
}

pub fn fmi2GetStringStatus<M: Model>(
    all: &Instances<M>,
    component: Component,
    kind: c_int,
    value: *mut *const c_char,
) -> c_int {
    status(all, component, "fmi2GetStringStatus", (kind, PENDING_STATUS), value, |_| Ok(c"".as_ptr()))
}

// Model exchange

pub fn fmi2EnterEventMode<M: Model>(all: &Instances<M>, component: Component) -> c_int {
    all.guarded(component, "fmi2EnterEventMode", Instance::enter_event_mode)
}

pub fn fmi2NewDiscreteStates<M: Model>(all: &Instances<M>, component: Component, info: *mut EventInfo) -> c_int {
    all.guarded(component, "fmi2NewDiscreteStates", |instance| {
        let info = place("fmi2eventInfo", info)?;
        let outcome = instance.new_discrete_states()?;
        *info = EventInfo {
            new_discrete_states_needed: outcome.needs_another.into(),
            terminate_simulation: 0,
            nominals_of_continuous_states_changed: 0,
            values_of_continuous_states_changed: outcome.states_changed.into(),
            next_event_time_defined: outcome.next_event.is_some().into(),
            next_event_time: outcome.next_event.unwrap_or(0.0),
        };
        Ok(())
    })
}

pub fn fmi2EnterContinuousTimeMode<M: Model>(all: &Instances<M>, component: Component) -> c_int {
    all.guarded(component, "fmi2EnterContinuousTimeMode", Instance::enter_continuous_time_mode)
}

pub fn fmi2CompletedIntegratorStep<M: Model>(
    all: &Instances<M>,
    component: Component,
    _no_set_state_prior: c_int,
    enter_event_mode: *mut c_int,
    terminate: *mut c_int,
) -> c_int {
    all.guarded(component, "fmi2CompletedIntegratorStep", |instance| {
        let (enter, terminate) = (place("enterEventMode", enter_event_mode)?, place("terminateSimulation", terminate)?);
        (*enter, *terminate) = (instance.completed_integrator_step()?.into(), 0);
        Ok(())
    })
}

pub fn fmi2SetTime<M: Model>(all: &Instances<M>, component: Component, time: c_double) -> c_int {
    all.guarded(component, "fmi2SetTime", |instance| instance.set_time(time))
}

pub fn fmi2SetContinuousStates<M: Model>(
    all: &Instances<M>,
    component: Component,
    states: *const c_double,
    n: usize,
) -> c_int {
    all.guarded(component, "fmi2SetContinuousStates", |instance| instance.set_continuous_states(array("x", states, n)?))
}

/// An array that the model fills.
fn numbers<M: Model>(
    all: &Instances<M>,
    component: Component,
    (name, argument): (&str, &str),
    (values, n): (*mut c_double, usize),
    fill: impl FnOnce(&Instance<M>, &mut [f64]) -> Result<()>,
) -> c_int {
    all.guarded(component, name, |instance| fill(instance, array_mut(argument, values, n)?))
}

pub fn fmi2GetDerivatives<M: Model>(
    all: &Instances<M>,
    component: Component,
    values: *mut c_double,
    n: usize,
) -> c_int {
    numbers(all, component, ("fmi2GetDerivatives", "derivatives"), (values, n), Instance::derivatives)
}

pub fn fmi2GetEventIndicators<M: Model>(
    all: &Instances<M>,
    component: Component,
    values: *mut c_double,
    n: usize,
) -> c_int {
    let names = ("fmi2GetEventIndicators", "eventIndicators");
    numbers(all, component, names, (values, n), Instance::event_indicators)
}

pub fn fmi2GetContinuousStates<M: Model>(
    all: &Instances<M>,
    component: Component,
    values: *mut c_double,
    n: usize,
) -> c_int {
    numbers(all, component, ("fmi2GetContinuousStates", "x"), (values, n), Instance::continuous_states)
}

pub fn fmi2GetNominalsOfContinuousStates<M: Model>(
    all: &Instances<M>,
    component: Component,
    values: *mut c_double,
    n: usize,
) -> c_int {
    let names = ("fmi2GetNominalsOfContinuousStates", "x_nominal");
    numbers(all, component, names, (values, n), Instance::nominals)
}
