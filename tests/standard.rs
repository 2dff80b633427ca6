//! Requirements of FMI 2.0 on an instance, beyond the table of legal calls: events, times, directional derivatives, statuses.

use std::{
    ffi::CString,
    ptr::{null, null_mut},
};

use actuator_fmu::fmu::{Slave, Start, Value, fmi2::*, guid, variables::variables};
use fmi_export::Kind;

fn reference(name: &str) -> u32 {
    u32::try_from(variables().iter().position(|variable| variable.name == name).unwrap()).unwrap()
}

fn set(slave: &mut Slave, values: &[(&str, f64)]) {
    slave.set(values.iter().map(|(name, value)| (reference(name), Value::Real(*value)))).unwrap();
}

fn get(slave: &Slave, name: &str) -> f64 {
    slave.get_real(reference(name)).unwrap()
}

/// A second-order actuator with k = 1, ω = 100, ζ = 0.7 and these parameters.
fn prepared(kind: Kind, parameters: &[(&str, f64)]) -> Slave {
    let mut slave = Slave::of_kind(kind, Start::default(), false);
    slave.setup_experiment(0.0, None).unwrap();
    slave.enter_initialization_mode().unwrap();
    slave
        .set([("source", 2), ("order", 1)].map(|(name, item)| (reference(name), Value::Integer(item))).into_iter())
        .unwrap();
    set(&mut slave, &[("custom.k", 1.0), ("custom.omega", 100.0), ("custom.zeta", 0.7)]);
    set(&mut slave, parameters);
    slave
}

fn started(kind: Kind, parameters: &[(&str, f64)]) -> Slave {
    let mut slave = prepared(kind, parameters);
    slave.exit_initialization_mode().unwrap();
    slave
}

const INDICATORS: usize = <actuator_fmu::fmu::ActuatorModel as fmi_export::Model>::EVENT_INDICATORS;

fn indicators(slave: &Slave) -> [f64; INDICATORS] {
    let mut indicators = [0.0; INDICATORS];
    slave.event_indicators(&mut indicators).unwrap();
    indicators
}

// Events

#[test]
fn a_jump_by_tuning_in_event_mode_is_told() {
    let mut slave = started(Kind::ModelExchange, &[("initial_position", 2.0)]);
    assert!(!slave.new_discrete_states().unwrap().states_changed);
    set(&mut slave, &[("position_limit.max", 1.0)]);
    assert_eq!(get(&slave, "drive.position"), 1.0);
    assert!(slave.new_discrete_states().unwrap().states_changed);
    assert!(!slave.new_discrete_states().unwrap().states_changed);
}

#[test]
fn a_failure_in_continuous_time_asks_for_an_event() {
    let mut slave = started(Kind::ModelExchange, &[]);
    slave.new_discrete_states().unwrap();
    slave.enter_continuous_time_mode().unwrap();
    slave.set_time(0.01).unwrap();
    assert!(!slave.completed_integrator_step().unwrap());
    slave.set([(reference("failure"), Value::Integer(3))].into_iter()).unwrap();
    assert!(slave.completed_integrator_step().unwrap());
    slave.enter_event_mode().unwrap();
    slave.new_discrete_states().unwrap();
    slave.enter_continuous_time_mode().unwrap();
    assert!(!slave.completed_integrator_step().unwrap());
}

#[test]
fn indicators_are_positive_where_a_mode_begins_and_of_the_size_of_positions() {
    // Leaving a stop; breaking away from friction, whose level is exactly reached.
    for (parameters, command) in [
        (&[("position_limit.max", 2.0), ("initial_position", 2.0)][..], 0.0),
        (&[("position_limit.max", 2.0), ("initial_position", 2.0), ("coulomb_friction.level", 0.25)][..], 1.5),
        (&[("coulomb_friction.level", 0.25)][..], 0.5),
        (&[("coulomb_friction.level", 0.25)][..], -0.25),
        (&[("rate_limit.up", 30.0), ("rate_limit.down", 30.0)][..], 8.0),
    ] {
        let mut slave = prepared(Kind::ModelExchange, parameters);
        set(&mut slave, &[("command", command)]);
        slave.exit_initialization_mode().unwrap();
        slave.new_discrete_states().unwrap();
        let found = indicators(&slave);
        assert!(found.iter().all(|indicator| (1e-13..100.0).contains(indicator)), "{parameters:?} {found:?}");
    }
}

/// Drives an instance like a host with sampled inputs: it enters event mode at each sample and at each time event, and sets the input
/// before and at the event. Returns the number of events.
fn events(slave: &mut Slave, samples: &[f64], input: impl Fn(f64) -> f64) -> usize {
    let mut next_event = slave.new_discrete_states().unwrap().next_event;
    slave.enter_continuous_time_mode().unwrap();
    let (mut time, mut count, mut samples) = (0.0, 0, samples.iter().copied().peekable());
    while let Some(sample) = samples.peek().copied() {
        let to = next_event.map_or(sample, |event| event.min(sample));
        for share in [0.5, 1.0] {
            let now = time + share * (to - time);
            slave.set_time(now).unwrap();
            set(slave, &[("command", input(now))]);
            slave.completed_integrator_step().unwrap();
        }
        time = to;
        count += 1;
        assert!(count < 100 * 400, "events without end at {time} s");
        slave.enter_event_mode().unwrap();
        set(slave, &[("command", input(time))]);
        next_event = slave.new_discrete_states().unwrap().next_event;
        slave.enter_continuous_time_mode().unwrap();
        if to == sample {
            samples.next();
        }
    }
    count
}

#[test]
fn a_sampled_input_makes_as_many_events_as_corners_and_no_corner_makes_none() {
    let delay = [("delay.time", 0.0123)];
    let samples: Vec<f64> = (1..400).map(|step| 0.005 * f64::from(step) + 1e-4 * f64::from(step * 7 % 10)).collect();
    // A corner at every sample: one event there, one when it leaves the delay.
    let corners = |time: f64| {
        let index = samples.partition_point(|sample| *sample <= time);
        let before = if index == 0 { 0.0 } else { samples[index - 1] };
        f64::from(u32::try_from(index % 3).unwrap()) * (time - before) + before
    };
    let count = events(&mut started(Kind::ModelExchange, &delay), &samples, corners);
    assert!(count <= 2 * samples.len() + 1, "{count} events for {} samples", samples.len());
    // A straight line: the events of the host, and one for the start.
    let count = events(&mut started(Kind::ModelExchange, &delay), &samples, |time| 3.0 * time);
    assert!(count <= samples.len() + samples.len() / 2, "{count} events for {} samples", samples.len());
}

// Times

#[test]
fn times_outside_the_experiment_are_refused() {
    let mut slave = Slave::of_kind(Kind::ModelExchange, Start::default(), false);
    slave.setup_experiment(1.0, Some(2.0)).unwrap();
    slave.enter_initialization_mode().unwrap();
    slave.exit_initialization_mode().unwrap();
    for (time, allowed) in [(0.9, false), (1.0, true), (1.5, true), (2.0 + 1e-12, true), (2.01, false), (1e9, false)] {
        assert_eq!(slave.set_time(time).is_ok(), allowed, "{time}");
    }
    slave.new_discrete_states().unwrap();
    slave.enter_continuous_time_mode().unwrap();
    // A solver evaluates slightly beyond the end, and interpolates.
    for (time, allowed) in [(0.9, false), (2.01, true), (2.1, false)] {
        assert_eq!(slave.set_time(time).is_ok(), allowed, "{time}");
    }
}

#[test]
fn no_two_steps_start_from_one_point_however_late_it_is() {
    let mut slave = Slave::new(Start::default(), false);
    slave.setup_experiment(1e9, None).unwrap();
    slave.enter_initialization_mode().unwrap();
    slave.exit_initialization_mode().unwrap();
    slave.do_step(1e9, 1e-5).unwrap();
    let refusal = slave.do_step(1e9, 1e-5).unwrap_err().to_string();
    assert!(refusal.contains("currentCommunicationPoint"), "{refusal}");
    slave.do_step(1e9 + 1e-5, 1e-5).unwrap();
}

// Directional derivatives

#[test]
fn directional_derivatives_in_model_exchange_are_those_of_the_equations() {
    let mut slave = started(Kind::ModelExchange, &[("sensor_lag.time", 0.01), ("backlash.gap", 0.5)]);
    slave.new_discrete_states().unwrap();
    slave.enter_continuous_time_mode().unwrap();
    let by = |unknown, known| slave.partial_derivative(reference(unknown), reference(known)).unwrap();
    let close = |found: f64, expected: f64| (found - expected).abs() <= 1e-6 * expected.abs().max(1.0);
    for (unknown, known, expected) in [
        ("der(drive.position)", "drive.rate", 1.0),
        ("der(drive.rate)", "drive.position", -1e4),
        ("der(drive.rate)", "drive.rate", -140.0),
        ("der(drive.rate)", "command", 1e4),
        ("der(drive.rate)", "load", 1e4),
        ("der(sensor_lag.reading)", "sensor_lag.reading", -100.0),
        ("position", "sensor_lag.reading", 1.0),
        ("rate", "drive.rate", 1.0),
        ("deflection", "drive.rate", 0.0),
    ] {
        let found = by(unknown, known);
        assert!(close(found, expected), "{unknown} by {known}: {found}, not {expected}");
    }
}

#[test]
fn every_dependency_on_a_state_is_one_that_may_be_asked_for() {
    let mut slave = started(Kind::CoSimulation, &[]);
    slave.do_step(0.0, 0.005).unwrap();
    let found = slave.partial_derivative(reference("position"), reference("drive.position")).unwrap();
    assert!((found - 1.0).abs() < 1e-9, "{found}");
}

#[test]
fn seeds_and_sensitivities_may_be_one_array() {
    let [name, guid] = ["one".to_owned(), guid(&Start::default())].map(|text| CString::new(text).unwrap());
    let component = fmi2Instantiate(name.as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 0);
    assert_eq!(fmi2SetupExperiment(component, 0, 0.0, 0.0, 0, 0.0), 0);
    assert_eq!(fmi2EnterInitializationMode(component), 0);
    assert_eq!(fmi2ExitInitializationMode(component), 0);
    assert_eq!(fmi2DoStep(component, 0.0, 0.005, 1), 0);
    let (unknowns, knowns) = (["rate", "position"].map(reference), ["command", "load"].map(reference));
    let derivatives = |seed: *const f64, into: *mut f64| {
        fmi2GetDirectionalDerivative(component, unknowns.as_ptr(), 2, knowns.as_ptr(), 2, seed, into)
    };
    let (seed, mut apart) = ([1.0, 0.5], [f64::NAN; 2]);
    assert_eq!(derivatives(seed.as_ptr(), apart.as_mut_ptr()), 0);
    let mut shared = seed;
    let pointer = shared.as_mut_ptr();
    assert_eq!(derivatives(pointer, pointer), 0);
    assert_eq!(shared, apart);
    fmi2FreeInstance(component);
    let mut state = null_mut();
    assert_eq!(fmi2GetFMUstate(component, &raw mut state), 3);
}

// Numbers

#[test]
fn a_longer_delay_holds_the_oldest_command() {
    let mut slave = started(Kind::CoSimulation, &[("delay.time", 0.01)]);
    for step in 0..100 {
        set(&mut slave, &[("command", 8.5)]);
        slave.set_input_derivatives([(reference("command"), 1, 100.0 * f64::from(step % 2))].into_iter()).unwrap();
        slave.do_step(0.01 * f64::from(step), 0.01).unwrap();
    }
    set(&mut slave, &[("delay.time", 1.0)]);
    for step in 100..150 {
        slave.do_step(0.01 * f64::from(step), 0.01).unwrap();
        let position = get(&slave, "position");
        assert!((7.0..12.0).contains(&position), "{position} deg after {step} steps");
    }
}

#[test]
fn a_start_rests_through_effects_on_the_command() {
    let effects = [("asymmetric_gain.ratio", 0.5), ("command_dead_zone.half_width", 0.25), ("delay.time", 0.5)];
    for initial in [-2.0, 1.5] {
        let mut slave = started(Kind::CoSimulation, &[&effects[..], &[("initial_position", initial)]].concat());
        for step in 0..40 {
            slave.do_step(0.01 * f64::from(step), 0.01).unwrap();
            assert!((get(&slave, "position") - initial).abs() < 1e-12, "{} at step {step}", get(&slave, "position"));
        }
    }
    let mut slave = prepared(Kind::CoSimulation, &[("command_limit.max", 1.0), ("initial_position", 2.0)]);
    let refusal = slave.exit_initialization_mode().unwrap_err().to_string();
    assert!(refusal.contains("initial_position") && refusal.contains("some command holds"), "{refusal}");
    set(&mut slave, &[("initial_position", 1.0)]);
    slave.exit_initialization_mode().unwrap();
}

#[test]
fn a_step_that_takes_too_long_ends_where_it_has_come_to() {
    let mut slave = started(Kind::CoSimulation, &[("rate_limit.up", 60.0), ("backlash.gap", 0.1)]);
    set(&mut slave, &[("command", 5.0)]);
    let error = slave.do_step(0.0, 1e5).unwrap_err();
    let reached = slave.last_successful_time().unwrap();
    assert!(reached > 100.0 && reached < 1e5, "{reached} s: {error}");
    assert!((get(&slave, "drive.position") - 5.0).abs() < 1e-9);
    slave.do_step(reached, 0.01).unwrap();
    let [name, guid] = ["long".to_owned(), guid(&Start::default())].map(|text| CString::new(text).unwrap());
    let component = fmi2Instantiate(name.as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 0);
    assert_eq!(fmi2EnterInitializationMode(component), 0);
    assert_eq!(fmi2SetReal(component, [reference("rate_limit.up")].as_ptr(), 1, [60.0].as_ptr()), 0);
    assert_eq!(fmi2ExitInitializationMode(component), 0);
    let mut reached = 0.0;
    assert_eq!(fmi2DoStep(component, 0.0, 1e5, 1), 2);
    assert_eq!(fmi2GetRealStatus(component, 2, &raw mut reached), 0);
    assert_eq!(fmi2DoStep(component, reached, 0.01, 1), 0);
    fmi2FreeInstance(component);
}

#[test]
fn a_motion_that_has_decayed_is_at_rest() {
    let parameters =
        [("rate_limit.up", 60.0), ("backlash.gap", 0.1), ("structural_mode.gain", 0.1), ("sensor_lag.time", 0.004)];
    let mut slave = started(Kind::CoSimulation, &[&parameters[..], &[("initial_position", 3.0)]].concat());
    for step in 0..4000 {
        slave.do_step(0.01 * f64::from(step), 0.01).unwrap();
    }
    for variable in variables().iter().filter(|variable| variable.name.starts_with("der(")) {
        let state = variable.name.trim_start_matches("der(").trim_end_matches(')');
        let value = get(&slave, state);
        assert!(value == 0.0 || value.is_normal(), "{state} {value:e}");
    }
}

#[test]
fn a_limit_that_acts_within_a_step_is_told_at_its_end() {
    let mut slave = started(Kind::CoSimulation, &[("rate_limit.up", 30.0), ("rate_limit.down", 30.0)]);
    set(&mut slave, &[("command", 3.0)]);
    slave.do_step(0.0, 0.5).unwrap();
    assert!(get(&slave, "rate").abs() < 1e-6);
    assert!(slave.get_boolean(reference("saturated")).unwrap());
    slave.do_step(0.5, 0.1).unwrap();
    assert!(!slave.get_boolean(reference("saturated")).unwrap());
}

#[test]
fn a_refused_initialization_changes_nothing_and_can_be_repeated() {
    type Values<'a> = &'a [(&'a str, f64)];
    let refused: [(Values, Values); 3] = [
        (&[("position_limit.max", 1.0), ("initial_position", 2.0)], &[("initial_position", 0.5)]),
        (&[("command_limit.max", 1.0), ("initial_position", 2.0)], &[("initial_position", 0.5)]),
        (
            &[("position_limit.max", -1.0), ("position_limit.min", 1.0)],
            &[("position_limit.max", 2.0), ("initial_position", 1.5)],
        ),
    ];
    for kind in [Kind::CoSimulation, Kind::ModelExchange] {
        for (parameters, corrected) in refused {
            let mut slave = prepared(kind, parameters);
            let content = |slave: &mut Slave| {
                let state = slave.save(None).unwrap();
                slave.serialize(state).unwrap()
            };
            let before = content(&mut slave);
            slave.exit_initialization_mode().unwrap_err();
            assert!(content(&mut slave) == before, "{kind:?} {parameters:?}");
            set(&mut slave, corrected);
            slave.exit_initialization_mode().unwrap();
        }
    }
}
