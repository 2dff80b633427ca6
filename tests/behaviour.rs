//! The number of the equations, which the GUID contains, identifies the results of an instance.

use actuator_fmu::{
    actuator::{Actuator, Inputs, Workspace},
    effects::Effects,
    parameters::{Order, table},
    transition::Ramp,
};

/// For the present [`BEHAVIOUR`](actuator_fmu::fmu): the sum over all effects, each alone, of their response to one motion.
const POSITIONS: &str = concat!(
    "delay:7.063977e1 delay:7.061451e1 command_limit:5.944612e1 command_limit:5.940755e1",
    " command_rate_limit:1.482295e2 command_rate_limit:1.482513e2 command_dead_zone:7.156303e1",
    " command_dead_zone:7.146748e1 command_backlash:6.988293e1 command_backlash:6.978949e1",
    " asymmetric_gain:-6.794894e0 asymmetric_gain:-6.896655e0 gain_drift:7.211400e1 gain_drift:7.201780e1",
    " dead_zone:7.246368e1 dead_zone:7.236730e1 amplitude_gain:7.143000e1 amplitude_gain:7.133388e1",
    " hinge_load:7.529653e1 hinge_load:7.519988e1 coulomb_friction:7.204562e1 coulomb_friction:7.194960e1",
    " acceleration_limit:4.192122e3 acceleration_limit:4.190806e3 rate_limit:1.467862e2",
    " rate_limit:1.463834e2 position_limit:2.127140e1 position_limit:2.118043e1 backlash:7.210998e1",
    " backlash:7.200148e1 structural_mode:7.090600e1 structural_mode:7.086197e1 sensor_lag:7.124546e1",
    " sensor_lag:7.118467e1 sensor_bias:7.736524e1 sensor_bias:7.726907e1 chatter:7.220828e1",
    " chatter:7.211210e1 quantisation:7.212000e1 quantisation:7.199750e1",
);

/// Positions at the end of a motion with one effect each, to seven digits: every platform computes them.
fn positions() -> String {
    let set = &table()[2];
    let mut found = Vec::new();
    for (effect, neutral) in Effects::default().iter() {
        let values: Vec<f64> = effect
            .parameters
            .iter()
            .zip(neutral)
            .map(|(parameter, neutral)| match (parameter.name, effect.name) {
                ("min", _) => -2.0,
                ("max", _) => 2.0,
                (_, "rate_limit" | "command_rate_limit") => 40.0,
                (_, "acceleration_limit") => 4000.0,
                _ if parameter.decides => neutral + 0.25 * parameter.nominal,
                _ => 1.1 * neutral,
            })
            .collect();
        let effects = Effects::default().with(effect, &values).unwrap();
        for order in [Order::Second, Order::Third] {
            let actuator = Actuator::new(set.base, order, &effects);
            let (mut state, mut workspace) = (actuator.at_rest(0.5), Workspace::default());
            let mut sum = 0.0;
            for step in 0..200 {
                let command = 5.0 * (0.7 * f64::from(step)).sin();
                let inputs = Inputs { load: Ramp::held(0.3), ..Inputs::command(Ramp { value: command, slope: 20.0 }) };
                actuator.step(&mut state, &mut workspace, inputs, 0.005).unwrap();
                sum += actuator.outputs(&state).position;
            }
            found.push(format!("{}:{sum:.6e}", effect.name));
        }
    }
    found.join(" ")
}

#[test]
fn other_equations_have_another_number() {
    let found = positions();
    assert_eq!(
        found, POSITIONS,
        "raise BEHAVIOUR in src/fmu/identifier.rs, put these positions here, render the description"
    );
}
