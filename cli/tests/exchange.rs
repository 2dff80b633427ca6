//! Model exchange through an importer (crate `fmi-rs`), with a minimal solver: Runge and Kutta's, and bisection at events.

use std::sync::Arc;

use actuator_fmu::{
    effects::Effects,
    fmu::variables::variables,
    parameters::{Base, Model, Order},
};
use fmi_rs::fmi2::{FMU2, ME, builder::FMU2Builder, types::fmi2Status};
use identification::{
    signal::{Command, Interpolation},
    simulate::simulate,
};

const STATES: usize = 7;
const INDICATORS: usize = 24;
/// Its error over a second is about (ω h)⁴ of the motion: 1e-9.
const STEP_S: f64 = 5e-5;

fn reference(name: &str) -> u32 {
    u32::try_from(variables().iter().position(|variable| variable.name == name).unwrap()).unwrap()
}

fn good(status: fmi2Status) {
    assert!(matches!(status, fmi2Status::Ok), "{status:?}");
}

struct Solved {
    fmu: Arc<FMU2<ME>>,
    time: f64,
    states: [f64; STATES],
    events: usize,
}

impl Solved {
    fn start(builder: &FMU2Builder, model: &Model) -> Self {
        let fmu = builder.instantiate_me("solved").unwrap();
        good(fmu.setupExperiment(None, 0.0, None));
        good(fmu.setInteger(&[reference("source")], &[2]));
        good(fmu.setInteger(&[reference("order")], &[model.order as i32 + 1]));
        for (name, value) in ["k", "p", "omega", "zeta"].iter().zip(model.base.values()) {
            good(fmu.setReal(&[reference(&format!("custom.{name}"))], &[value]));
        }
        for ((effect, parameter), value) in Effects::parameters().zip(model.effects.values()) {
            good(fmu.setReal(&[reference(&format!("{}.{}", effect.name, parameter.name))], &[*value]));
        }
        good(fmu.enterInitializationMode());
        good(fmu.exitInitializationMode());
        let mut solved = Self { fmu, time: 0.0, states: [0.0; STATES], events: 0 };
        solved.iterate();
        solved
    }

    /// From event mode to continuous-time mode.
    fn iterate(&mut self) {
        let (mut again, mut ends, mut nominals, mut values, mut next) = (true, false, false, false, None);
        while again {
            good(self.fmu.newDiscreteStates(&mut again, &mut ends, &mut nominals, &mut values, &mut next));
        }
        assert!(!ends && next.is_none());
        good(self.fmu.enterContinuousTimeMode());
        good(self.fmu.getContinuousStates(&mut self.states));
    }

    fn rates(&self, time: f64, states: &[f64; STATES]) -> [f64; STATES] {
        let mut rates = [0.0; STATES];
        good(self.fmu.setTime(time));
        good(self.fmu.setContinuousStates(states));
        good(self.fmu.getDerivatives(&mut rates));
        rates
    }

    /// States after a step that is not yet accepted, and the indicators there.
    fn attempt(&self, h: f64) -> ([f64; STATES], [f64; INDICATORS]) {
        let along = |rates: &[f64; STATES], h: f64| -> [f64; STATES] {
            std::array::from_fn(|index| self.states[index] + h * rates[index])
        };
        let one = self.rates(self.time, &self.states);
        let two = self.rates(self.time + 0.5 * h, &along(&one, 0.5 * h));
        let three = self.rates(self.time + 0.5 * h, &along(&two, 0.5 * h));
        let four = self.rates(self.time + h, &along(&three, h));
        let mean = std::array::from_fn(|i| (one[i] + 2.0 * two[i] + 2.0 * three[i] + four[i]) / 6.0);
        let after = along(&mean, h);
        let mut indicators = [0.0; INDICATORS];
        self.rates(self.time + h, &after);
        good(self.fmu.getEventIndicators(&mut indicators));
        (after, indicators)
    }

    fn run_to(&mut self, end: f64) {
        while end - self.time > 1e-12 {
            let mut h = STEP_S.min(end - self.time);
            let mut after = self.attempt(h);
            let below = |indicators: &[f64; INDICATORS]| indicators.iter().any(|indicator| *indicator < -1e-12);
            if below(&after.1) {
                let (mut low, mut high) = (0.0, h);
                for _ in 0..40 {
                    let middle = 0.5 * (low + high);
                    *(if below(&self.attempt(middle).1) { &mut high } else { &mut low }) = middle;
                }
                h = high;
                after = self.attempt(h);
            }
            (self.states, self.time) = (after.0, self.time + h);
            let (mut event, mut ends) = (0, 0);
            good(self.fmu.completedIntegratorStep(1, &mut event, &mut ends));
            if event != 0 {
                self.events += 1;
                good(self.fmu.enterEventMode());
                self.iterate();
            }
        }
    }

    fn command(&mut self, value: f64) {
        good(self.fmu.enterEventMode());
        good(self.fmu.setReal(&[reference("command")], &[value]));
        self.iterate();
    }

    fn position(&self) -> f64 {
        let mut value = [0.0];
        good(self.fmu.getReal(&[reference("position")], &mut value));
        value[0]
    }
}

#[test]
fn a_simple_solver_follows_the_exact_motion_through_events() {
    let path = fmu_build::build(concat!(env!("CARGO_MANIFEST_DIR"), "/.."), &fmu_build::Options::default()).unwrap();
    let builder = FMU2Builder::new(&path).unwrap();
    let base = Base::new(1.02, 1e4, 120.0, 0.55).unwrap();
    let effect = |name: &str, values: &[f64]| {
        Effects::default().with(actuator_fmu::effects::find(name).unwrap(), values).unwrap()
    };
    let time: Vec<f64> = (0..12).map(|index| 0.02 * f64::from(index)).collect();
    let steps = [0.0, 3.0, 3.0, -2.0, -2.0, 4.0, 1.0, 1.0, -4.0, 2.0, 2.0, 2.0];
    let command = Command { time, command: steps.to_vec() };
    for (effects, order) in [
        (Effects::default(), Order::Second),
        (Effects::default(), Order::Third),
        (effect("position_limit", &[-1.5, 2.5]), Order::Second),
        (effect("rate_limit", &[90.0, 110.0]), Order::Second),
        (effect("backlash", &[0.4]), Order::Second),
        (effect("coulomb_friction", &[0.3]), Order::Second),
    ] {
        let model = Model { effects, ..Model::new(base, order) };
        let exact = simulate(&model, &command, Interpolation::Held).unwrap().position;
        let mut solved = Solved::start(&builder, &model);
        let mut worst = 0.0_f64;
        for (index, step) in command.steps(Interpolation::Held).enumerate() {
            solved.command(step.command.value);
            solved.run_to(step.start + step.duration);
            worst = worst.max((solved.position() - exact[index + 1]).abs());
        }
        // The pole of the third order, 1e4 1/s, gives p h = 0.5: the fourth-order error is 1e-3 of the remaining change of x.
        let allowed = if order == Order::Third { 1e-5 } else { 1e-8 };
        assert!(worst < allowed, "{worst:e} {:?}", model.effects.values());
        assert_eq!(solved.events > 0, model.effects != Effects::default());
    }
}
