//! Model exchange (section 3.2 of the standard).

use libc::{c_double, c_int};

use crate::{
    abi::{
        Component, Instances,
        arrays::{Input, Output, Place},
    },
    error::Result,
    instance::Instance,
    model::Model,
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

pub fn fmi2EnterEventMode<M: Model>(all: &Instances<M>, component: Component) -> c_int {
    all.guarded(component, "fmi2EnterEventMode", Instance::enter_event_mode)
}

pub fn fmi2NewDiscreteStates<M: Model>(all: &Instances<M>, component: Component, info: *mut EventInfo) -> c_int {
    all.guarded(component, "fmi2NewDiscreteStates", |instance| {
        let info = Place::new("fmi2eventInfo", info)?;
        let outcome = instance.new_discrete_states()?;
        info.write(EventInfo {
            new_discrete_states_needed: outcome.needs_another.into(),
            terminate_simulation: 0,
            nominals_of_continuous_states_changed: 0,
            values_of_continuous_states_changed: outcome.states_changed.into(),
            next_event_time_defined: outcome.next_event.is_some().into(),
            next_event_time: outcome.next_event.unwrap_or(0.0),
        });
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
        let (enter, terminate) =
            (Place::new("enterEventMode", enter_event_mode)?, Place::new("terminateSimulation", terminate)?);
        enter.write(instance.completed_integrator_step()?.into());
        terminate.write(0);
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
    all.guarded(component, "fmi2SetContinuousStates", |instance| {
        let states = Input::new("x", states, n)?;
        through_buffer(instance, n, |instance, buffer| {
            buffer.iter_mut().zip(states.iter()).for_each(|(number, state)| *number = state);
            instance.set_continuous_states(buffer)
        })
    })
}

/// Runs with `n` numbers owned by the instance, so that nothing is allocated and no slice covers memory of the host.
fn through_buffer<M: Model>(
    instance: &mut Instance<M>,
    n: usize,
    body: impl FnOnce(&mut Instance<M>, &mut [f64]) -> Result<()>,
) -> Result<()> {
    let mut buffer = std::mem::take(&mut instance.numbers);
    // A number of elements other than the model's is refused in `body`; it only determines the length.
    let outcome = match buffer.get_mut(..n) {
        Some(numbers) => body(instance, numbers),
        None => body(instance, &mut vec![0.0; n.min(buffer.len() + 1)]),
    };
    instance.numbers = buffer;
    outcome
}

/// An array filled by the model.
fn numbers<M: Model>(
    all: &Instances<M>,
    component: Component,
    (name, argument): (&str, &str),
    (values, n): (*mut c_double, usize),
    fill: impl FnOnce(&Instance<M>, &mut [f64]) -> Result<()>,
) -> c_int {
    all.guarded(component, name, |instance| {
        let values = Output::new(argument, values, n)?;
        through_buffer(instance, n, |instance, buffer| {
            fill(instance, buffer)?;
            values.write_all(buffer);
            Ok(())
        })
    })
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
