//! Laws that hold for every effect of the chain. Responses are checked against an independent plant in fmpy-tests.

use actuator_fmu::{
    actuator::{Actuator, Inputs, State, Workspace},
    effects::{Act, CHAIN, Effect, Effects, Observed, find},
    parameters::{Base, Order, table},
    transition::Ramp,
};
use proptest::prelude::*;

/// Values of an effect that are not neutral: between its neutral and a usual value.
fn values(effect: &Effect, share: f64) -> Vec<f64> {
    let towards = |parameter: &actuator_fmu::effects::Parameter| match parameter.name {
        "min" => -share * parameter.nominal,
        "ratio" => 1.0 + 0.5 * share,
        _ if !parameter.decides => parameter.neutral,
        _ => share * parameter.nominal,
    };
    effect.parameters.iter().map(towards).collect()
}

fn any_effect() -> impl Strategy<Value = (&'static Effect, f64)> {
    (prop::sample::select(CHAIN), 0.2_f64..1.0)
}

fn run(actuator: &Actuator, state: &mut State, commands: &[f64], steps: &[f64]) -> Vec<(f64, f64, f64)> {
    let mut workspace = Workspace::default();
    let mut record = Vec::new();
    for command in commands {
        for step in steps {
            actuator.step(state, &mut workspace, Inputs::command(Ramp::held(*command)), *step).unwrap();
        }
        let outputs = actuator.outputs(state);
        record.push((outputs.position, outputs.deflection, outputs.rate));
    }
    record
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Cutting steps changes nothing: 1e-9 of 8 deg, some thousand roundings; 2e-8 with a cubic spring,
    /// which is linear while the fast pole decays, anew after a cut.
    #[test]
    fn the_cut_of_time_changes_nothing(
        (effect, share) in any_effect(),
        (other, other_share) in any_effect(),
        set in prop::sample::select(table()),
        order in prop::sample::select(Order::ALL),
        commands in prop::collection::vec(-8.0_f64..8.0, 5..20),
        cut in 0.01_f64..0.99,
    ) {
        let effects = Effects::default().with(effect, &values(effect, share)).unwrap();
        let effects = effects.with(other, &values(other, other_share)).unwrap();
        let actuator = Actuator::new(set.base, order, &effects);
        let whole = run(&actuator, &mut actuator.at_rest(0.0), &commands, &[0.005]);
        let pieces = run(&actuator, &mut actuator.at_rest(0.0), &commands, &[0.005 * cut, 0.005 * (1.0 - cut)]);
        let has = |name| [effect, other].iter().any(|effect| effect.name == name);
        let tolerance = if has("amplitude_gain") && order == Order::Third { 16e-8 } else { 8e-9 };
        let steps = has("quantisation");
        for ((_, deflection, _), (_, again, _)) in whole.iter().zip(&pieces) {
            prop_assert!((deflection - again).abs() < tolerance, "{} {}: {deflection} {again}", effect.name, other.name);
        }
        for ((position, ..), (again, ..)) in whole.iter().zip(&pieces).filter(|_| !steps) {
            prop_assert!((position - again).abs() < tolerance, "{} {}: {position} {again}", effect.name, other.name);
        }
    }

    /// A saved state continues bit for bit.
    #[test]
    fn a_saved_state_goes_on_to_the_bit(
        (effect, share) in any_effect(),
        commands in prop::collection::vec(-8.0_f64..8.0, 5..20),
    ) {
        let effects = Effects::default().with(effect, &values(effect, share)).unwrap();
        let actuator = Actuator::new(table()[0].base, Order::Third, &effects);
        let mut state = actuator.at_rest(0.5);
        run(&actuator, &mut state, &commands, &[0.004]);
        let mut saved: State = postcard::from_bytes(&postcard::to_allocvec(&state).unwrap()).unwrap();
        prop_assert_eq!(&saved, &state);
        let one = run(&actuator, &mut state, &commands, &[0.004]);
        let other = run(&actuator, &mut saved, &commands, &[0.004]);
        prop_assert_eq!(one, other);
    }

    /// An approximate motion equals the exact one to 1e-5 of 8 deg (of 50 000 motions one is off by more than 3e-6, of a million one by more
    /// than that), in steps within which the fastest poles come to rest as well.
    #[test]
    fn an_approximate_motion_is_the_exact_one(
        (effect, share) in any_effect(),
        (other, other_share) in any_effect(),
        set in prop::sample::select(table()),
        order in prop::sample::select(Order::ALL),
        commands in prop::collection::vec(-8.0_f64..8.0, 5..20),
        step in prop::sample::select(vec![0.001, 0.005, 0.02, 0.1]),
    ) {
        let effects = Effects::default().with(effect, &values(effect, share)).unwrap();
        let effects = effects.with(other, &values(other, other_share)).unwrap();
        let exact = Actuator::new(set.base, order, &effects);
        let expected = run(&exact, &mut exact.at_rest(0.0), &commands, &[step]);
        let approximate = Actuator::new(set.base, order, &effects).approximate();
        let found = run(&approximate, &mut approximate.at_rest(0.0), &commands, &[step]);
        for ((_, expected, _), (_, found, _)) in expected.iter().zip(&found) {
            prop_assert!((expected - found).abs() < 80e-6, "{} {}: {expected} {found}", effect.name, other.name);
        }
    }

    /// The same to 5e-4 of the largest position (of 30 000 motions one is off by 1e-4, 48 by more than 3e-6) on other bases, from hardly to
    /// heavily damped, with a pole from slow to fast, under commands and loads that move between the samples of an even or an uneven clock.
    #[test]
    fn an_approximate_motion_of_any_base_under_any_inputs_is_the_exact_one(
        (effect, share) in any_effect(),
        (other, other_share) in any_effect(),
        (omega, zeta, pole_ratio) in (20.0_f64..300.0, prop_oneof![0.1_f64..3.0, 3.0_f64..20.0], 0.5_f64..50.0),
        order in prop::sample::select(Order::ALL),
        inputs in prop::collection::vec((-8.0_f64..8.0, -2.0_f64..2.0), 6..25),
        (is_held, is_loaded, is_even) in any::<(bool, bool, bool)>(),
        step_ratio in prop::sample::select(vec![0.1, 0.5, 1.0, 2.0, 5.0, 12.0]),
    ) {
        let base = Base::from_values([1.0, pole_ratio * omega, omega, zeta]).unwrap();
        let effects = Effects::default().with(effect, &values(effect, share)).unwrap();
        let effects = effects.with(other, &values(other, other_share)).unwrap();
        let motion = |actuator: Actuator| -> Vec<f64> {
            let (mut state, mut workspace) = (actuator.at_rest(0.0), Workspace::default());
            let samples = inputs.windows(2).enumerate();
            let motion = samples.map(|(index, pair)| {
                let duration = step_ratio / omega * if is_even { 1.0 } else { 1.0 + 0.3 * (index as f64).sin() };
                let ramp = |from: f64, to: f64| {
                    Ramp { value: from, slope: if is_held { 0.0 } else { (to - from) / duration } }
                };
                let load = if is_loaded { ramp(pair[0].1, pair[1].1) } else { Ramp::default() };
                let at = Inputs { load, ..Inputs::command(ramp(pair[0].0, pair[1].0)) };
                actuator.step(&mut state, &mut workspace, at, duration).unwrap();
                actuator.outputs(&state).deflection
            });
            motion.collect()
        };
        let exact = motion(Actuator::new(base, order, &effects));
        let approximate = motion(Actuator::new(base, order, &effects).approximate());
        let size = exact.iter().fold(8.0_f64, |size, position| size.max(position.abs()));
        for (expected, found) in exact.iter().zip(&approximate) {
            prop_assert!((expected - found).abs() < 5e-4 * size, "{} {}: {expected} {found}", effect.name, other.name);
        }
    }

    /// Effects whose parameters have no sign are odd: the same in both directions.
    #[test]
    fn what_has_no_side_is_odd(
        (effect, share) in any_effect(),
        commands in prop::collection::vec(-8.0_f64..8.0, 5..20),
    ) {
        let sided = ["asymmetric_gain", "hinge_load", "sensor_bias", "chatter"];
        prop_assume!(!sided.contains(&effect.name));
        let effects = Effects::default().with(effect, &values(effect, share)).unwrap();
        let actuator = Actuator::new(table()[0].base, Order::Third, &effects);
        let mirrored: Vec<f64> = commands.iter().map(|command| -command).collect();
        let one = run(&actuator, &mut actuator.at_rest(0.0), &commands, &[0.005]);
        let other = run(&actuator, &mut actuator.at_rest(0.0), &mirrored, &[0.005]);
        for ((position, ..), (mirror, ..)) in one.iter().zip(&other) {
            prop_assert!((position + mirror).abs() < 1e-10, "{}: {position} {mirror}", effect.name);
        }
    }
}

#[test]
fn every_effect_does_something_and_nothing_at_its_neutral_values() {
    let commands: Vec<f64> = (0..60).map(|step| 8.0 * (0.3 * f64::from(step)).sin()).collect();
    let base = table()[0].base;
    let plain = Actuator::new(base, Order::Third, &Effects::default());
    let expected = run(&plain, &mut plain.at_rest(0.0), &commands, &[0.005]);
    for effect in CHAIN {
        let neutral: Vec<f64> = effect.parameters.iter().map(|parameter| parameter.neutral).collect();
        let effects = Effects::default().with(effect, &neutral).unwrap();
        let actuator = Actuator::new(base, Order::Third, &effects);
        assert_eq!(run(&actuator, &mut actuator.at_rest(0.0), &commands, &[0.005]), expected, "{}", effect.name);
        let effects = Effects::default().with(effect, &values(effect, 0.5)).unwrap();
        let actuator = Actuator::new(base, Order::Third, &effects);
        assert_ne!(run(&actuator, &mut actuator.at_rest(0.0), &commands, &[0.005]), expected, "{}", effect.name);
    }
}

#[test]
fn start_values_are_admissible() {
    let observed = Observed {
        command_peak: 4.0,
        position_range: (-4.1, 4.2),
        rate_peak: 120.0,
        acceleration_peak: 9e3,
        residual_rms: 0.05,
        residual_mean: -0.01,
        residual_frequency_hz: 7.0,
        position_step: 0.001,
        duration_s: 25.0,
        sample_time_s: 0.005,
    };
    for effect in CHAIN {
        let candidates = (effect.start_values)(&observed);
        assert!(!candidates.is_empty(), "{}", effect.name);
        for start in candidates {
            let effects = Effects::default().with(effect, &start);
            assert!(effects.is_ok(), "{}: {start:?}", effect.name);
            assert!(!effect.is_neutral(&start), "{}: {start:?}", effect.name);
        }
    }
}

#[test]
fn the_order_of_the_chain_is_that_of_the_signal() {
    let place = |act: &Act| match act {
        Act::Delay | Act::Command(_) | Act::GainDrift(_) => 0,
        Act::Loop(_) => 1,
        Act::Surface(_) => 2,
        Act::Sensor(_) => 3,
        Act::Reading { .. } => 4,
    };
    assert!(CHAIN.is_sorted_by_key(|effect| place(&effect.act)));
}

#[test]
fn the_nearest_position_that_a_command_holds_is_held() {
    let base = Base::from_values([0.9, 200.0, 100.0, 0.5]).unwrap();
    let with = |name: &str, values: &[f64], effects: &Effects| effects.with(find(name).unwrap(), values).unwrap();
    let limit = with("command_limit", &[-0.7, 1.0], &Effects::default());
    let stop = with("position_limit", &[-0.5, 0.4], &limit);
    let narrow = with("command_dead_zone", &[0.2], &limit);
    let one_sided = with("asymmetric_gain", &[0.0], &Effects::default());
    let table = [
        (&limit, 0.3, 0.3),
        (&limit, -0.9, -0.63),
        (&limit, 2.0, 0.9),
        (&stop, 2.0, 0.4),
        (&narrow, 2.0, 0.72),
        (&one_sided, -1.0, 0.0),
    ];
    for (effects, wanted, nearest) in table {
        let actuator = Actuator::new(base, Order::Third, effects);
        let found = actuator.nearest_held(wanted);
        assert!((found - nearest).abs() < 1e-15, "{wanted}: {found} for {nearest}");
        let held = actuator.holding_command(found).unwrap();
        let (mut state, mut workspace) = (actuator.at_rest(found), Workspace::default());
        for _ in 0..50 {
            let command = Inputs::command(Ramp { value: held, slope: 0.0 });
            actuator.step(&mut state, &mut workspace, command, 0.01).unwrap();
            assert!((actuator.outputs(&state).position - found).abs() < 1e-12);
        }
    }
}
