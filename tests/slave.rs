//! Laws of the co-simulation slave, through its safe interface. The packaged binary is tested in fmpy-tests.

use actuator_fmu::{
    fmu::{Slave, Start, Value, variables::variables},
    parameters::{Identity, PositionUnit},
};
use proptest::prelude::*;

fn reference(name: &str) -> u32 {
    u32::try_from(variables().iter().position(|variable| variable.name == name).unwrap()).unwrap()
}

fn started() -> Slave {
    let mut slave = Slave::new(Start::default(), false);
    slave.setup_experiment(0.0, None).unwrap();
    slave.enter_initialization_mode().unwrap();
    slave.exit_initialization_mode().unwrap();
    slave
}

fn command(slave: &mut Slave, value: f64) {
    slave.set([(reference("command"), Value::Real(value))].into_iter()).unwrap();
}

#[test]
fn a_refused_setting_changes_nothing() {
    let mut slave = started();
    let items = [(reference("command"), Value::Real(1.0)), (reference("custom.p"), Value::Real(f64::NAN))];
    assert!(slave.set(items.into_iter()).unwrap_err().to_string().contains("custom.p"));
    assert_eq!(slave.get_real(reference("command")).unwrap(), 0.0);
}

#[test]
fn a_selection_without_data_can_be_corrected_and_left() {
    let mut slave = Slave::new(Start::default(), false);
    slave.enter_initialization_mode().unwrap();
    let select =
        |stage| ["surface", "stage", "load_case"].map(reference).into_iter().zip([3, stage, 2].map(Value::Integer));
    slave.set(select(3)).unwrap();
    assert!(slave.exit_initialization_mode().is_err());
    slave.set(select(2)).unwrap();
    slave.exit_initialization_mode().unwrap();
    assert_eq!(slave.get_real(reference("active.omega")).unwrap(), 150.85);
}

proptest! {
    /// Masters that repeat steps rely on it: the outputs after a restored state are those after the saved state.
    #[test]
    fn a_restored_state_goes_on_as_before(commands in prop::collection::vec(-10.0_f64..10.0, 2..20), h in 1e-4_f64..0.1) {
        let mut slave = started();
        let run = |slave: &mut Slave, from: f64| -> Vec<f64> {
            commands.iter().enumerate().map(|(index, value)| {
                command(slave, *value);
                slave.do_step(from + h * index as f64, h).unwrap();
                slave.get_real(reference("position")).unwrap()
            }).collect()
        };
        run(&mut slave, 0.0);
        let time = h * commands.len() as f64;
        let saved = slave.save(None).unwrap();
        let bytes = slave.serialize(saved).unwrap();
        let first = run(&mut slave, time);
        slave.restore(saved).unwrap();
        prop_assert_eq!(&run(&mut slave, time), &first);
        let mut other = started();
        let read = other.deserialize(&bytes, None).unwrap();
        other.restore(read).unwrap();
        prop_assert_eq!(&run(&mut other, time), &first);
    }

    /// Arbitrary bytes are never accepted as a state and never crash the slave.
    #[test]
    fn changed_bytes_are_refused(position in any::<prop::sample::Index>(), change in 1_u8..) {
        let mut slave = started();
        let saved = slave.save(None).unwrap();
        let mut bytes = slave.serialize(saved).unwrap();
        let position = position.index(bytes.len());
        bytes[position] ^= change;
        prop_assert!(slave.deserialize(&bytes, None).is_err());
        prop_assert!(slave.deserialize(&bytes[..position], None).is_err());
    }
}

#[test]
fn what_is_refused_is_said_in_the_unit_of_the_model() {
    let identity = Identity { unit: PositionUnit::Millimetre, ..Identity::default() };
    let mut slave = Slave::new(Start { identity, ..Start::default() }, false);
    slave.setup_experiment(0.0, None).unwrap();
    slave.enter_initialization_mode().unwrap();
    let items = [("position_limit.max", 4.0), ("initial_position", 5.0)];
    slave.set(items.map(|(name, value)| (reference(name), Value::Real(value))).into_iter()).unwrap();
    let message = slave.exit_initialization_mode().unwrap_err().to_string();
    assert!(message.contains("5 mm") && message.contains("to 4 mm"), "{message}");
}
