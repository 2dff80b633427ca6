//! The step against independent formulations: a Runge-Kutta integration of the equations of motion, and the
//! frequency response in closed form.

use actuator_fmu::{
    actuator::{Actuator, Inputs, Workspace},
    effects::Effects,
    parameters::{Base, Order, table},
    transition::Ramp,
};
use identification::frequency::response;
use nalgebra::{Complex, Vector3};

/// ẋ = p (k c - x), δ̇ = v, v̇ = ω² (x - δ) - 2ζω v by the classical fourth-order method.
fn runge_kutta(base: &Base, command: Ramp, duration: f64, steps: u32) -> Vector3<f64> {
    let derivative = |t: f64, z: Vector3<f64>| {
        let (omega, zeta) = (base.omega(), base.zeta());
        Vector3::new(
            base.p() * (base.k() * command.at(t) - z.x),
            z.z,
            omega * omega * (z.x - z.y) - 2.0 * zeta * omega * z.z,
        )
    };
    let h = duration / f64::from(steps);
    (0..steps).fold(Vector3::zeros(), |z, step| {
        let t = f64::from(step) * h;
        let k1 = derivative(t, z);
        let k2 = derivative(t + 0.5 * h, z + 0.5 * h * k1);
        let k3 = derivative(t + 0.5 * h, z + 0.5 * h * k2);
        let k4 = derivative(t + h, z + h * k3);
        z + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    })
}

#[test]
fn a_step_is_the_integral_of_the_equations_of_motion() {
    // 2e5 steps of p h = 0.015 at most: truncation below 1e-11 of a motion of 1 deg, rounding about the same.
    for (p, zeta) in [(200.0, 0.5624), (1e4, 0.5624), (150.0, 1.7), (1.0, 1.0)] {
        let base = Base::new(1.0198, p, 165.26, zeta).unwrap();
        let command = Ramp { value: 1.0, slope: -20.0 };
        let actuator = Actuator::new(base, Order::Third, &Effects::default());
        let mut state = actuator.at_rest(0.0);
        actuator.step(&mut state, &mut Workspace::default(), Inputs::command(command), 0.3).unwrap();
        let expected = runge_kutta(&base, command, 0.3, 200_000);
        for (found, expected, scale) in
            [(state.pole, expected.x, 1.0), (state.position, expected.y, 1.0), (state.rate, expected.z, 165.26)]
        {
            assert!((found - expected).abs() < 1e-9 * scale, "p = {p}: {found} {expected}");
        }
    }
}

#[test]
fn a_finely_sampled_sine_comes_out_with_the_analytic_gain_and_phase() {
    // A command linear between samples 50 µs apart departs from the sine by (2π 12 h)²/8 = 2e-6 at most.
    let h = 5e-5;
    for set in table() {
        for order in Order::ALL {
            let frequency = 10.0;
            let sine = |step: u32| (std::f64::consts::TAU * frequency * h * f64::from(step)).sin();
            let actuator = Actuator::new(set.base, *order, &Effects::default());
            let (mut state, mut workspace) = (actuator.at_rest(0.0), Workspace::default());
            let mut sum = Complex::new(0.0, 0.0);
            // One second to settle (ζω > 46 1/s), then one period.
            for step in 0..22_000 {
                if step >= 20_000 {
                    let angle = -std::f64::consts::TAU * frequency * h * f64::from(step);
                    sum += Complex::from_polar(state.position, angle);
                }
                let command = Ramp { value: sine(step), slope: (sine(step + 1) - sine(step)) / h };
                actuator.step(&mut state, &mut workspace, Inputs::command(command), h).unwrap();
            }
            let gain = sum * Complex::new(0.0, 2.0) / 2000.0;
            let expected = response(&set.base, *order, frequency);
            assert!((gain - expected).norm() < 4e-6, "{} {order:?}: {gain} {expected}", set.name);
        }
    }
}
