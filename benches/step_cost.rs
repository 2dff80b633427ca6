//! Cost of a step of the packaged FMU with effects, as a ratio to the linear step, measured in the same run.
//!
//! `cargo bench --bench step_cost` steps the FMU as an importer does (set the command, step, get the position) through a sine that the rate
//! limit clips and the backlash reverses. The cases alternate, and the fastest of many rounds counts, so that a noisy machine hardly
//! affects the ratios.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{sync::Arc, time::Instant};

use fmi_rs::{
    fmi2::{CS, FMU2, builder::FMU2Builder, log::DefaultLogger, types::fmi2Status},
    model_description::fmi2::ModelDescription,
};

const ROUNDS: usize = 60;
const STEPS: u32 = 2_000;
const STEP_S: f64 = 0.005;
/// 2 Hz and 8 deg require 100 deg/s.
const FREQUENCY_HZ: f64 = 2.0;
const AMPLITUDE_DEG: f64 = 8.0;

const CASES: [(&str, &[(&str, f64)]); 5] = [
    ("linear", &[]),
    ("rate limit", &[("rate_limit.up", 60.0), ("rate_limit.down", 60.0)]),
    ("backlash", &[("backlash.gap", 0.5)]),
    ("rate limit and backlash", &[("rate_limit.up", 60.0), ("rate_limit.down", 60.0), ("backlash.gap", 0.5)]),
    (
        "friction, mode and lag",
        &[("coulomb_friction.level", 0.2), ("structural_mode.gain", 0.3), ("sensor_lag.time", 0.004)],
    ),
];

fn reference(description: &ModelDescription, name: &str) -> u32 {
    description.variable_by_name(name).unwrap().valueReference
}

fn ok(status: fmi2Status) {
    assert_eq!(status, fmi2Status::Ok);
}

fn round(builder: &FMU2Builder, parameters: &[(&str, f64)]) -> f64 {
    let description = &builder.model_description;
    let fmu = FMU2::<CS>::new(
        builder.unzipdir.path(),
        "BactActuator",
        "bench",
        &description.guid,
        false,
        false,
        false,
        Arc::new(DefaultLogger::default()),
        false,
    )
    .unwrap();
    ok(fmu.setupExperiment(None, 0.0, None));
    for (name, value) in parameters {
        ok(fmu.setReal(&[reference(description, name)], &[*value]));
    }
    ok(fmu.enterInitializationMode());
    ok(fmu.exitInitializationMode());
    let (command, position) = (reference(description, "command"), reference(description, "position"));
    let commands: Vec<f64> = (0..STEPS)
        .map(|step| AMPLITUDE_DEG * (std::f64::consts::TAU * FREQUENCY_HZ * STEP_S * f64::from(step)).sin())
        .collect();
    let mut sum = 0.0;
    let start = Instant::now();
    for (step, value) in (0..STEPS).zip(commands) {
        ok(fmu.setReal(&[command], &[value]));
        ok(fmu.doStep(f64::from(step) * STEP_S, STEP_S, 1));
        let mut out = [0.0];
        ok(fmu.getReal(&[position], &mut out));
        sum += out[0];
    }
    let seconds = start.elapsed().as_secs_f64();
    assert!(sum.is_finite());
    seconds / f64::from(STEPS)
}

fn main() {
    let fmu = fmu_build::build(concat!(env!("CARGO_MANIFEST_DIR"), "/.."), &fmu_build::Options::default()).unwrap();
    let builder = FMU2Builder::new(&fmu).unwrap();
    let mut best = [f64::INFINITY; CASES.len()];
    for _ in 0..ROUNDS {
        for (best, (_, parameters)) in best.iter_mut().zip(CASES) {
            *best = best.min(round(&builder, parameters));
        }
    }
    println!("{:<26} {:>9} {:>15}", "effects", "ns/step", "ratio to linear");
    for (seconds, (name, _)) in best.iter().zip(CASES) {
        println!("{name:<26} {:>9.0} {:>15.2}", seconds * 1e9, seconds / best[0]);
    }
}
