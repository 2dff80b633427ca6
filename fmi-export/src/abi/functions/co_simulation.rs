//! Co-simulation (section 4.2 of the standard).

use libc::{c_char, c_double, c_int, c_uint};

use crate::{
    abi::{
        Component, Instances,
        arrays::{Input, Output, Place},
    },
    error::{Error, Result},
    instance::Instance,
    log::Status,
    model::Model,
};

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
            (Input::new("vr", references, n)?, Input::new("order", orders, n)?, Input::new("value", values, n)?);
        let items = references.iter().zip(orders.iter()).zip(values.iter());
        instance.set_input_derivatives(items.map(|((reference, order), value)| (reference, order, value)))
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
            (Input::new("vr", references, n)?, Input::new("order", orders, n)?, Output::new("value", values, n)?);
        for (index, (reference, order)) in references.iter().zip(orders.iter()).enumerate() {
            values.write(index, instance.output_derivative(reference, order)?);
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
    all.guarded_as_owner(component, "fmi2DoStep", |instance| instance.do_step(current, duration))
        .unwrap_or_else(|| all.guarded(component, "fmi2DoStep", |instance| instance.do_step(current, duration)))
}

pub fn fmi2CancelStep<M: Model>(all: &Instances<M>, component: Component) -> c_int {
    all.guarded(component, "fmi2CancelStep", |instance| instance.cancel_step())
}

const NO_STATUS: c_int = -1;
const DO_STEP_STATUS: c_int = 0;
const PENDING_STATUS: c_int = 1;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

/// Steps are never pending, so that each status kind has one answer; others are discarded.
fn status<M: Model, T: Copy>(
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
            Place::new("value", value)?.write(answer(instance)?);
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
