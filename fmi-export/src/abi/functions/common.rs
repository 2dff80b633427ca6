//! Functions common to both kinds of instance (sections 2.1.5 to 2.1.9 of the standard).

use std::panic::{AssertUnwindSafe, catch_unwind};

use libc::{c_char, c_double, c_int, c_uint};

use crate::{
    abi::{
        CallbackFunctions, Component, Instances,
        arrays::{Input, Output, Place, text},
    },
    error::{Error, Result},
    instance::Instance,
    log::CATEGORIES,
    model::Model,
    variable::Value,
};

#[must_use]
pub fn fmi2GetTypesPlatform<M: Model>(_: &Instances<M>) -> *const c_char {
    c"default".as_ptr()
}

#[must_use]
pub fn fmi2GetVersion<M: Model>(_: &Instances<M>) -> *const c_char {
    c"2.0".as_ptr()
}

#[allow(clippy::too_many_arguments)] // as in the standard
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
    all.instantiate(name, kind, guid, resources, functions, logging_on != 0)
}

pub fn fmi2FreeInstance<M: Model>(all: &Instances<M>, component: Component) {
    // A panicking destructor of a model must not terminate the host.
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
        let names = Input::new("categories", categories, n)?;
        let names: Vec<String> = names.iter().map(|name| text(name).unwrap_or_default()).collect();
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

fn get<M: Model, T: Copy>(
    all: &Instances<M>,
    component: Component,
    name: &str,
    (references, n, values): (*const c_uint, usize, *mut T),
    pick: impl Fn(&Instance<M>, u32) -> Result<T>,
) -> c_int {
    all.guarded(component, name, |instance| {
        let (references, values) = (Input::new("vr", references, n)?, Output::new("value", values, n)?);
        for (index, reference) in references.iter().enumerate() {
            values.write(index, pick(instance, reference)?);
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
        let (references, values) = (Input::new("vr", references, n)?, Input::new("value", values, n)?);
        instance.set(references.iter().zip(values.iter().map(&wrap)))
    })
}

/// Strings: models have none, so that every reference is invalid.
fn none_of_type<M: Model>(
    all: &Instances<M>,
    component: Component,
    name: &str,
    references: *const c_uint,
    n: usize,
) -> c_int {
    all.guarded(component, name, |_| match Input::new("vr", references, n)?.iter().next() {
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
    let get_one = |instance: &mut Instance<M>| {
        let (reference, value) = (Place::new("vr", references.cast_mut())?, Place::new("value", values)?);
        value.write(instance.get_real(reference.read())?);
        Ok(())
    };
    if n == 1
        && let Some(status) = all.guarded_as_owner(component, "fmi2GetReal", get_one)
    {
        return status;
    }
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
    let set_one = |instance: &mut Instance<M>| {
        let (reference, value) = (Place::new("vr", references.cast_mut())?, Place::new("value", values.cast_mut())?);
        instance.set_one(reference.read(), Value::Real(value.read()))
    };
    if n == 1
        && let Some(status) = all.guarded_as_owner(component, "fmi2SetReal", set_one)
    {
        return status;
    }
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

#[allow(clippy::too_many_arguments)] // as in the standard
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
        let (unknowns, knowns) =
            (Input::new("vUnknown_ref", unknowns, n_unknowns)?, Input::new("vKnown_ref", knowns, n_knowns)?);
        let (seed, sensitivity) =
            (Input::new("dvKnown", seed, n_knowns)?, Output::new("dvUnknown", sensitivity, n_unknowns)?);
        // All are read before the first is written, since the host may pass one array as both.
        let derivative = |unknown| {
            let terms = knowns.iter().zip(seed.iter());
            terms.map(|(known, seed)| Ok(instance.partial_derivative(unknown, known)? * seed)).sum::<Result<f64>>()
        };
        let sums: Vec<f64> = unknowns.iter().map(derivative).collect::<Result<_>>()?;
        sensitivity.write_all(&sums);
        Ok(())
    })
}
