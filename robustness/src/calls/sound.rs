//! The next call of a correct host, so that lives reach all states of the standard.

use fmi_export::abi::Component;

use super::{
    arguments::{Of, duration, item_of, one_in, pick, references, value_of},
    life::{DISCARD, Known, Life, OK},
};
use crate::host::MODEL_EXCHANGE;
use actuator_fmu::fmu::{ActuatorModel, variables::Causality};
use fmi_export::Model;

/// Number of continuous states.
pub(super) const STATES: usize = <ActuatorModel as Model>::STATES;
/// Number of event indicators.
pub(super) const INDICATORS: usize = <ActuatorModel as Model>::EVENT_INDICATORS;
/// `fmi2LastSuccessfulTime`
const LAST_SUCCESSFUL_TIME: i32 = 2;

/// Advances one instance: through initialization if not done, otherwise by a step.
pub(super) fn forward(life: &mut Life<'_>) {
    let index = life.rng.usize(..life.instances.len());
    let known = life.instances[index];
    let component = known.component;
    // The next call is found by trying: a call that is not legal is refused and changes nothing.
    match life.rng.u8(..8) {
        0 => {
            life.call("fmi2SetupExperiment", component, |f| (f.fmi2SetupExperiment)(component, 0, 0.0, 0.0, 0, 0.0));
            tune(life, component, &[Causality::Parameter]);
            life.call("fmi2EnterInitializationMode", component, |f| (f.fmi2EnterInitializationMode)(component));
        }
        1 => {
            if one_in(&mut life.rng, 2) {
                tune(life, component, &[Causality::Parameter]);
            }
            life.call("fmi2ExitInitializationMode", component, |f| (f.fmi2ExitInitializationMode)(component));
        }
        _ if known.kind == MODEL_EXCHANGE => integrate(life, index),
        _ => step(life, component),
    }
}

/// Sets values that are mostly allowed.
fn tune(life: &mut Life<'_>, component: Component, of: &[Causality]) {
    let count = life.rng.usize(1..4);
    let reals = references(&mut life.rng, count, Of::Real, of);
    let values: Vec<f64> = reals.iter().map(|reference| value_of(&mut life.rng, *reference)).collect();
    life.call("fmi2SetReal", component, |f| (f.fmi2SetReal)(component, reals.as_ptr(), count, values.as_ptr()));
    if one_in(&mut life.rng, 3) {
        let items = references(&mut life.rng, 1, Of::Integer, of);
        let value = item_of(&mut life.rng, items[0]);
        life.call("fmi2SetInteger", component, |f| (f.fmi2SetInteger)(component, items.as_ptr(), 1, &raw const value));
    }
}

fn step(life: &mut Life<'_>, component: Component) {
    let mut time = 0.0;
    let status = life.call("fmi2GetRealStatus", component, |f| {
        (f.fmi2GetRealStatus)(component, LAST_SUCCESSFUL_TIME, &raw mut time)
    });
    if status != OK {
        return;
    }
    if one_in(&mut life.rng, 2) {
        tune(life, component, &[Causality::Input]);
    }
    let duration = duration(&mut life.rng);
    let status = life.call("fmi2DoStep", component, |f| (f.fmi2DoStep)(component, time, duration, 1));
    // Its next steps would be as slow, each of seconds; another instance tests more.
    if status == DISCARD && !one_in(&mut life.rng, 4) {
        life.free_known(component);
    }
}

/// One step of an explicit Euler method with the event handling of a host.
fn integrate(life: &mut Life<'_>, index: usize) {
    let Known { component, time, .. } = life.instances[index];
    match life.rng.u8(..10) {
        0 => {
            life.call("fmi2EnterEventMode", component, |f| (f.fmi2EnterEventMode)(component));
            return;
        }
        1..3 => {
            let mut info = [0_u64; 4];
            let place = info.as_mut_ptr().cast();
            life.call("fmi2NewDiscreteStates", component, |f| (f.fmi2NewDiscreteStates)(component, place));
            life.call("fmi2EnterContinuousTimeMode", component, |f| (f.fmi2EnterContinuousTimeMode)(component));
            return;
        }
        3 => tune(life, component, &[Causality::Input]),
        _ => {}
    }
    let (mut states, mut derivatives, mut indicators) = ([0.0; STATES], [0.0; STATES], [0.0; INDICATORS]);
    let got = life.call("fmi2GetContinuousStates", component, |f| {
        (f.fmi2GetContinuousStates)(component, states.as_mut_ptr(), STATES)
    });
    let derived = life
        .call("fmi2GetDerivatives", component, |f| (f.fmi2GetDerivatives)(component, derivatives.as_mut_ptr(), STATES));
    if got != OK || derived != OK {
        return;
    }
    let h = pick(&mut life.rng, &[1e-5, 1e-4, 1e-3, 1e-9, 0.01]);
    if life.call("fmi2SetTime", component, |f| (f.fmi2SetTime)(component, time + h)) == OK {
        life.instances[index].time = time + h;
    }
    states.iter_mut().zip(derivatives).for_each(|(state, derivative)| *state += h * derivative);
    life.call("fmi2SetContinuousStates", component, |f| {
        (f.fmi2SetContinuousStates)(component, states.as_ptr(), STATES)
    });
    life.call("fmi2GetEventIndicators", component, |f| {
        (f.fmi2GetEventIndicators)(component, indicators.as_mut_ptr(), INDICATORS)
    });
    let (mut enter, mut terminate) = (0, 0);
    life.call("fmi2CompletedIntegratorStep", component, |f| {
        (f.fmi2CompletedIntegratorStep)(component, 1, &raw mut enter, &raw mut terminate)
    });
}
