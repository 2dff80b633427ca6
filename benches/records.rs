//! A test as long as the report's: 2 300 points of 5 minutes at 200 samples/s, 138 million samples per channel.
//!
//! `cargo bench --bench records` reads one such file 2 300 times through Welch's method, on all processors, and fits it a few times. It
//! prints times and the peak memory. `cargo bench --bench records -- 100` does 100.

#![allow(clippy::unwrap_used, missing_docs)]

use std::{
    sync::atomic::{AtomicUsize, Ordering},
    time::Instant,
};

use actuator_fmu::parameters::{Model, table};
use cli::files;
use identification::{
    estimate::{Settings, fit},
    frequency::welch::Welch,
    signal::{
        Interpolation, Response,
        excitation::{Excitation, Kind},
        format::Format,
        record::rms,
        stream::Stream,
        write_csv,
    },
    simulate::simulate,
};
use rand::{SeedableRng, rngs::ChaCha8Rng};
use rand_distr::{Distribution, StandardNormal};

const POINTS: usize = 2300;
const DURATION_S: f64 = 300.0;
const FITS: usize = 20;

fn main() {
    let points = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(POINTS);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    let command = Excitation { duration_s: DURATION_S, ..Excitation::new(Kind::Random) }.command().unwrap();
    let mut position = simulate(&Model::from_set(&table()[0]), &command, Interpolation::Held).unwrap().position;
    let size = 0.02 * rms(&position);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    position.iter_mut().for_each(|value| {
        let noise: f64 = StandardNormal.sample(&mut random);
        // As written by a data system: six decimals.
        *value = ((*value + size * noise) * 1e6).round() / 1e6;
    });
    let response = Response { position, ..Response::default() };
    write_csv(std::fs::File::create(&path).unwrap(), &command, &response).unwrap();
    let bytes = std::fs::metadata(&path).unwrap().len();
    println!("a record: {} samples, {:.1} MB", command.time.len(), 1e-6 * bytes as f64);
    println!("memory before: {}", greatest_memory());

    let threads = std::thread::available_parallelism().unwrap().get();
    let next = AtomicUsize::new(0);
    let start = Instant::now();
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while next.fetch_add(1, Ordering::Relaxed) < points {
                    let mut welch = Welch::default();
                    welch
                        .add_stream(&mut files::open_stream(&path, &Format::default(), Stream::BLOCK).unwrap())
                        .unwrap();
                    assert!(welch.finish().unwrap().points.len() > 100);
                }
            });
        }
    });
    let seconds = start.elapsed().as_secs_f64();
    let samples = points * command.time.len();
    println!(
        "{points} records through Welch's method: {seconds:.1} s on {threads} threads, {:.0} ns per sample",
        1e9 * seconds * threads as f64 / samples as f64
    );
    println!("memory after: {}", greatest_memory());

    let record = files::read_record(&path, &Format::default()).unwrap();
    let start = Instant::now();
    for _ in 0..FITS {
        fit(std::slice::from_ref(&record), &Settings::default()).unwrap();
    }
    println!("a likelihood fit of it: {:.3} s", start.elapsed().as_secs_f64() / FITS as f64);
    println!("memory after: {}", greatest_memory());
}

/// Peak resident memory so far, if the system reports it.
fn greatest_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM")).unwrap_or("not told by this system");
    line.trim_start_matches("VmHWM:").trim().to_owned()
}
