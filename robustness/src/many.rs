//! Many instances at once, from several threads: each must respond as it does alone.

use std::sync::Barrier;

use actuator_fmu::fmu::variables::variables;
use fastrand::Rng;
use fmi_export::abi::Component;

use crate::{
    functions::invented,
    host::{CO_SIMULATION, Host, last_message},
};

/// Value reference of a variable.
#[must_use]
pub fn reference(name: &str) -> u32 {
    let index = variables().iter().position(|variable| variable.name == name).expect("a variable");
    u32::try_from(index).expect("an index")
}

/// Effects from which an instance draws.
const EFFECTS: [(&str, f64); 8] = [
    ("backlash.gap", 0.3),
    ("delay.time", 0.02),
    ("rate_limit.up", 60.0),
    ("coulomb_friction.level", 0.1),
    ("sensor_lag.time", 0.004),
    ("command_backlash.gap", 0.2),
    ("dead_zone.half_width", 0.2),
    ("position_limit.max", 2.0),
];

/// An instance with its own effects, as a number that can be sent to another thread.
fn made(host: &Host, number: u64) -> usize {
    let mut rng = Rng::with_seed(number);
    let mut drawn =
        |(name, value): &(&str, f64)| (rng.u8(..4) == 0).then(|| (reference(name), value * (0.5 + rng.f64())));
    let effects: Vec<(u32, f64)> = EFFECTS.iter().filter_map(&mut drawn).collect();
    host.initialized(CO_SIMULATION, &effects) as usize
}

const STEP_S: f64 = 0.005;

/// One step under the instance's own command; returns the outputs, to the bit.
fn stepped(host: &Host, component: usize, number: u64, step: u64) -> [u64; 2] {
    let component: Component = invented(component);
    let f = &host.functions;
    let value = 2.0 * ((number as f64).sin() + 0.1 * step as f64).sin();
    let (command, outputs) = (reference("command"), ["position", "rate"].map(reference));
    assert_eq!((f.fmi2SetReal)(component, &raw const command, 1, &raw const value), 0);
    assert_eq!((f.fmi2DoStep)(component, STEP_S * step as f64, STEP_S, 0), 0, "{}", last_message());
    let mut values = [0.0; 2];
    assert_eq!((f.fmi2GetReal)(component, outputs.as_ptr(), 2, values.as_mut_ptr()), 0);
    values.map(f64::to_bits)
}

/// Outputs of instances that live one after another.
fn alone(host: &Host, numbers: impl Iterator<Item = u64>, steps: u64) -> Vec<[u64; 2]> {
    numbers
        .map(|number| {
            let component = made(host, number);
            let last = (0..steps).fold([0; 2], |_, step| stepped(host, component, number, step));
            (host.functions.fmi2FreeInstance)(invented(component));
            last
        })
        .collect()
}

/// Outputs of instances that all live at once: created by one of this many threads, stepped by the next, with all others between two steps
/// of each, and freed by the one after that.
fn together(host: &Host, count: u64, threads: u64, steps: u64) -> Vec<[u64; 2]> {
    let all = Barrier::new(usize::try_from(threads).expect("few threads"));
    let share = |thread: u64| (0..count).filter(move |number| number % threads == thread);
    let components = std::sync::Mutex::new(vec![0; usize::try_from(count).expect("an index")]);
    let component = |number: u64| components.lock().expect("no panic")[usize::try_from(number).expect("an index")];
    let live = |thread: u64| {
        for number in share(thread) {
            let made = made(host, number);
            components.lock().expect("no panic")[usize::try_from(number).expect("an index")] = made;
        }
        all.wait();
        let own: Vec<(u64, usize)> = share((thread + 1) % threads).map(|number| (number, component(number))).collect();
        let mut last = Vec::new();
        for step in 0..steps {
            last = own.iter().map(|(number, component)| stepped(host, *component, *number, step)).collect();
        }
        all.wait();
        share((thread + 2) % threads).for_each(|number| (host.functions.fmi2FreeInstance)(invented(component(number))));
        own.into_iter().map(|(number, _)| number).zip(last).collect::<Vec<_>>()
    };
    let live = &live;
    let mut answers: Vec<(u64, [u64; 2])> = std::thread::scope(|scope| {
        let started: Vec<_> = (0..threads).map(|thread| scope.spawn(move || live(thread))).collect();
        started.into_iter().flat_map(|thread| thread.join().expect("no panic")).collect()
    });
    answers.sort_unstable();
    answers.into_iter().map(|(_, answer)| answer).collect()
}

/// Checks that this many instances, alive at once on this many threads, respond to the bit as each does alone.
pub fn agree(host: &Host, count: u64, threads: u64, steps: u64) {
    assert!(together(host, count, threads, steps) == alone(host, 0..count, steps), "answers depend on the others");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functions::Functions;

    #[test]
    fn instances_on_four_threads_answer_as_each_does_alone() {
        let _alone = crate::alone();
        let (count, steps) = if cfg!(miri) { (8, 2) } else { (400, 20) };
        agree(&Host::new(Functions::linked()), count, 4, steps);
    }
}
