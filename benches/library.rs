//! Cost of the library without the program around it: the parts of `./bench` that no command covers. Each prints lines of tab-separated words.
//!
//! ```text
//! cargo bench --bench library -- simulate MODEL COMMAND.csv OUT.csv REPEATS      ns for a simulation of the command, held
//! cargo bench --bench library -- fits REPEATS RECORD.csv...                      s for fits of all records, 8 starts each; then k, omega, zeta
//! cargo bench --bench library -- monte-carlo COUNT STEPS linear|nonlinear        s for COUNT actuators; mean and deviation at the end
//! ```
#![allow(clippy::unwrap_used, missing_docs, clippy::cast_precision_loss)]

use std::{hint::black_box, path::Path, time::Instant};

use actuator_fmu::{
    actuator::{Actuator, Inputs, Workspace},
    effects::Effects,
    parameters::{Base, Model, Order},
    transition::Ramp,
};
use cli::files;
use identification::{
    estimate::{OrderChoice, Settings, fit},
    signal::{Interpolation, format::Format, write_csv},
    simulate::simulate,
};
use rayon::prelude::*;

/// As in the program `actuator`.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// p, unused by a second-order model.
const POLE: f64 = 1e4;
/// ω [rad/s] and ζ of the starts of a fit.
const OMEGA: [f64; 4] = [90.0, 130.0, 180.0, 250.0];
const ZETA: [f64; 2] = [0.4, 0.9];
/// Sampling interval of the Monte-Carlo run [s].
const STEP_S: f64 = 0.005;
/// Its command: a square wave of this amplitude [deg], and steps per half period.
const SIZE: f64 = 2.0;
const HALF_PERIOD: usize = 50;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["simulate", model, command, out, repeats] => simulation(model, command, out, repeats.parse().unwrap()),
        ["fits", repeats, records @ ..] => fits(repeats.parse().unwrap(), records),
        ["monte-carlo", count, steps, kind] => {
            monte_carlo(count.parse().unwrap(), steps.parse().unwrap(), *kind == "nonlinear");
        }
        _ => println!(
            "simulate MODEL COMMAND.csv OUT.csv REPEATS | fits REPEATS RECORD.csv... | monte-carlo COUNT STEPS linear|nonlinear"
        ),
    }
}

fn simulation(model: &str, command: &str, out: &str, repeats: usize) {
    let model = files::read_model(model).unwrap();
    let command = files::read_command(Path::new(command), &Format::default()).unwrap();
    let response = simulate(&model, &command, Interpolation::Held).unwrap();
    write_csv(std::fs::File::create(out).unwrap(), &command, &response).unwrap();
    for _ in 0..repeats {
        let start = Instant::now();
        black_box(simulate(black_box(&model), &command, Interpolation::Held).unwrap());
        println!("{}", start.elapsed().as_nanos());
    }
}

fn fits(repeats: usize, paths: &[&str]) {
    let records: Vec<_> =
        paths.iter().map(|path| files::read_record(Path::new(path), &Format::default()).unwrap()).collect();
    let starts = OMEGA.iter().flat_map(|omega| ZETA.iter().map(move |zeta| [1.0, POLE, *omega, *zeta])).collect();
    let settings = Settings { order: OrderChoice::Second, starts: Some(starts), ..Settings::default() };
    let mut found = Vec::new();
    for _ in 0..repeats {
        let start = Instant::now();
        found = records.iter().map(|record| fit(std::slice::from_ref(record), &settings).unwrap()).collect();
        println!("{}", start.elapsed().as_secs_f64());
    }
    for (path, fit) in paths.iter().zip(found) {
        let [k, _, omega, zeta] = fit.model.base.values();
        println!("{path}\t{k}\t{omega}\t{zeta}");
    }
}

/// Evenly distributed numbers in -1 to 1: the same on every computer, and in the peer.
fn spread(index: usize, irrational: f64) -> f64 {
    2.0 * (index as f64 * irrational).fract() - 1.0
}

/// The last position of each of many actuators, whose k, ω and ζ spread by 10 % about 1, 150 rad/s and 0.6.
fn monte_carlo(count: usize, steps: usize, nonlinear: bool) {
    let effects = if nonlinear { effects() } else { Effects::default() };
    let start = Instant::now();
    let last: Vec<f64> = (0..count)
        .into_par_iter()
        .map_init(Workspace::default, |workspace, index| {
            let [k, omega, zeta] = [(1.0, 2_f64.sqrt()), (150.0, 3_f64.sqrt()), (0.6, 5_f64.sqrt())]
                .map(|(middle, irrational)| middle * (1.0 + 0.1 * spread(index, irrational)));
            let actuator = Actuator::new(Base::new(k, POLE, omega, zeta).unwrap(), Order::Second, &effects);
            let mut state = actuator.at_rest(0.0);
            workspace.clear();
            for step in 0..steps {
                let value = if (step / HALF_PERIOD).is_multiple_of(2) { SIZE } else { -SIZE };
                actuator.step(&mut state, workspace, Inputs::command(Ramp { value, slope: 0.0 }), STEP_S).unwrap();
            }
            actuator.outputs(&state).position
        })
        .collect();
    let seconds = start.elapsed().as_secs_f64();
    let mean = last.iter().sum::<f64>() / count as f64;
    let variance = last.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count as f64;
    println!("{seconds}\t{mean}\t{}", variance.sqrt());
}

/// A rate limit of 60 deg/s and a gap of 0.2 deg.
fn effects() -> Effects {
    let text = "[base]\norder = 2\nk = { value = 1.0, unit = \"deg/deg\" }\nomega = { value = 150.0, unit = \"rad/s\" }\n\
        zeta = { value = 0.6, unit = \"1\" }\n[effects.rate_limit]\nup = { value = 60.0, unit = \"deg/s\" }\n\
        down = { value = 60.0, unit = \"deg/s\" }\n[effects.backlash]\ngap = { value = 0.2, unit = \"deg\" }\n";
    Model::parse(text).unwrap().effects
}
