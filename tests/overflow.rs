//! Overflow within a call leads to a refusal that changes nothing, for all effects.

use actuator_fmu::{
    fmu::{Slave, Start, Value, variables::variables},
    series::{Range, Series},
};
use fmi_export::Kind;

fn reference(name: &str) -> u32 {
    u32::try_from(variables().iter().position(|variable| variable.name == name).unwrap()).unwrap()
}

fn started(kind: Kind, parameters: &[(&str, f64)]) -> Slave {
    let mut slave = Slave::of_kind(kind, Start::default(), false);
    slave.setup_experiment(0.0, None).unwrap();
    slave.enter_initialization_mode().unwrap();
    set(&mut slave, parameters);
    slave.exit_initialization_mode().unwrap();
    slave
}

fn set(slave: &mut Slave, values: &[(&str, f64)]) {
    slave.set(values.iter().map(|(name, value)| (reference(name), Value::Real(*value)))).unwrap();
}

fn state(slave: &mut Slave) -> Vec<u8> {
    let saved = slave.save(None).unwrap();
    let bytes = slave.serialize(saved).unwrap();
    slave.free(saved).unwrap();
    bytes
}

const EFFECTS: [&[(&str, f64)]; 6] = [
    &[("backlash.gap", 0.5)],
    &[("command_backlash.gap", 0.5), ("delay.time", 0.01), ("dead_zone.half_width", 0.1)],
    &[("rate_limit.up", 60.0), ("rate_limit.down", 60.0)],
    &[("amplitude_gain.cubic", 1.0), ("delay.time", 0.01)],
    &[("coulomb_friction.level", 0.2), ("structural_mode.gain", 0.3), ("backlash.gap", 0.5)],
    &[("position_limit.max", 3.0), ("asymmetric_gain.ratio", 2.0)],
];

#[test]
fn a_step_that_overflows_is_refused_and_changes_nothing() {
    for parameters in EFFECTS {
        for command in [1e61, -1e150, 1e300, f64::MAX, f64::MIN] {
            let mut slave = started(Kind::CoSimulation, parameters);
            // A history, part of which the delay discards within a step.
            for step in 0..5 {
                set(&mut slave, &[("command", f64::from(step))]);
                slave.do_step(0.005 * f64::from(step), 0.005).unwrap();
            }
            set(&mut slave, &[("command", command), ("load", -command)]);
            let before = state(&mut slave);
            let refusal = slave.do_step(0.025, 0.05).unwrap_err().to_string();
            assert!(refusal.contains("finite"), "{refusal}");
            assert!(state(&mut slave) == before, "{parameters:?} {command}");
            set(&mut slave, &[("command", 1.0), ("load", 0.0)]);
            slave.do_step(0.025, 0.05).unwrap();
            assert!(slave.get_real(reference("position")).unwrap().abs() < 10.0);
        }
    }
}

#[test]
fn a_value_that_overflows_is_refused_by_name() {
    let mut slave = started(Kind::ModelExchange, &[]);
    set(&mut slave, &[("command", f64::MAX)]);
    let refusal = slave.get_real(reference("der(drive.target)")).unwrap_err().to_string();
    assert!(refusal.contains("der(drive.target)") && refusal.contains("finite"), "{refusal}");
}

#[test]
fn the_search_for_events_ends_where_numbers_are_none() {
    for wrong in [f64::NAN, f64::INFINITY] {
        let series = Series::polynomial(&[0.0, wrong, 1.0, -wrong]);
        for until in [1.0, f64::NAN] {
            let _ = series.leaves(Range { low: -1.0, high: 1.0 }, 1e-13, until);
            let _ = series.derivative_leaves(Range { low: -1.0, high: 1.0 }, 1e-13, until);
        }
    }
    let _ = Series::polynomial(&[0.0, 1.0, -0.9]).leaves(Range::below(0.2), 0.0, f64::NAN);
}
