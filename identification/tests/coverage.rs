//! How often stated standard errors cover the truth. Slow (some minutes), so run only by name:
//! `cargo test --release -p identification --test tests coverage -- --ignored --nocapture --test-threads 1`. Results of a run are in docs/estimation.md.

use std::sync::{
    Mutex,
    atomic::{AtomicUsize, Ordering},
};

use actuator_fmu::parameters::{Base, ParameterSet, table};
use identification::{
    estimate::{Fit, Method, Pole, Settings, fit},
    signal::excitation::Kind,
};

use crate::generated::{Colour, Generated};

const REPETITIONS: usize = 200;

/// For one set: how often k, ω and ζ were covered, their errors, and how often p was reported as found, the noise as a misfit, and a delay
/// as suspected: all three falsely.
#[derive(Debug, Default, Clone)]
struct Count {
    covered: [usize; 3],
    errors: [Vec<f64>; 3],
    found: usize,
    misfit: usize,
    delay: usize,
}

/// Fits [`REPETITIONS`] records that differ only in their noise.
fn repeat(base: Base, record: impl Fn(u64) -> Generated + Sync) -> Count {
    let next = AtomicUsize::new(0);
    let count = Mutex::new(Count::default());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().unwrap().get() {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= REPETITIONS {
                        return;
                    }
                    let fit = fit(&[record(seed as u64).record()], &Settings::default()).unwrap();
                    let mut count = count.lock().unwrap();
                    count.found += usize::from(fit.pole == Pole::Found);
                    count.misfit += usize::from(fit.notes.iter().any(|note| note.contains("not noise alone")));
                    count.delay += usize::from(fit.notes.iter().any(|note| note.contains("--delay free")));
                    for (place, (name, truth)) in
                        [("k", base.k()), ("omega", base.omega()), ("zeta", base.zeta())].into_iter().enumerate()
                    {
                        let estimate = fit.estimates.iter().find(|estimate| estimate.name == name).unwrap();
                        let error = estimate.value - truth;
                        count.covered[place] += usize::from(error.abs() < 1.96 * estimate.std_error.unwrap());
                        count.errors[place].push(100.0 * error / truth);
                    }
                }
            });
        }
    });
    count.into_inner().unwrap()
}

fn line(name: &str, count: &Count) -> String {
    let share = |place: usize| 100.0 * count.covered[place] as f64 / REPETITIONS as f64;
    let rms = |place: usize| (count.errors[place].iter().map(|e| e * e).sum::<f64>() / REPETITIONS as f64).sqrt();
    let most = |place: usize| count.errors[place].iter().fold(0.0_f64, |most, e| most.max(e.abs()));
    let beyond = |percent: f64| {
        let count = count.errors[1].iter().filter(|e| e.abs() > percent).count();
        100.0 * count as f64 / REPETITIONS as f64
    };
    format!(
        "| {name} | {:.1} | {:.1} | {:.1} | {:.3} | {:.2} | {:.2} | {:.2} | {:.2} | {:.1} / {:.1} | {} / {} / {} |",
        share(0),
        share(1),
        share(2),
        rms(0),
        rms(1),
        rms(2),
        most(1),
        most(2),
        beyond(1.5),
        beyond(3.0),
        count.found,
        count.misfit,
        count.delay
    )
}

fn study(title: &str, sets: &[&ParameterSet], record: impl Fn(&ParameterSet, u64) -> Generated + Sync) -> [usize; 3] {
    println!(
        "{title}, {REPETITIONS} repetitions\n| set | covers k, % | omega | zeta | rms error k, % | omega | zeta | most omega | zeta | omega beyond 1.5 / 3 %, % | p found / misfit / delay |"
    );
    let mut all = [0; 3];
    for (number, set) in (0_u64..).zip(sets) {
        let count = repeat(set.base, |seed| record(set, 1000 * number + seed));
        println!("{}", line(&set.name.to_string(), &count));
        all.iter_mut().zip(count.covered).for_each(|(all, covered)| *all += covered);
    }
    let share = all.map(|covered| 100.0 * covered as f64 / (REPETITIONS * sets.len()) as f64);
    println!("all: covers k {:.1} %, omega {:.1} %, zeta {:.1} %", share[0], share[1], share[2]);
    all
}

#[test]
#[ignore = "minutes"]
fn standard_errors_cover_the_truth_on_long_sweeps() {
    let sets: Vec<&ParameterSet> = table().iter().collect();
    let covered = study("75 s sweeps, white noise of 2 %", &sets, |set, seed| Generated {
        noise: 0.02,
        noise_seed: seed,
        ..Generated::new(set.base)
    });
    for covered in covered {
        let share = covered as f64 / (REPETITIONS * sets.len()) as f64;
        assert!((0.90..0.99).contains(&share), "{share}");
    }
}

#[test]
#[ignore = "minutes"]
fn standard_errors_cover_the_truth_in_other_noise_and_records() {
    let sets: Vec<&ParameterSet> = table().iter().step_by(4).collect();
    for (title, kind, duration_s, colour) in [
        ("25 s sweeps, white noise of 2 %", Kind::Sweep, 25.0, Colour::White),
        ("75 s random, white noise of 2 %", Kind::Random, 75.0, Colour::White),
        ("75 s sweeps, coloured noise of 2 % (first order, 0.95)", Kind::Sweep, 75.0, Colour::First(0.95)),
        ("75 s random, coloured noise of 2 % (first order, 0.95)", Kind::Random, 75.0, Colour::First(0.95)),
        ("75 s sweeps, noise of 10 % with a resonance at 4 Hz", Kind::Sweep, 75.0, Colour::Resonance),
    ] {
        let covered = study(title, &sets, |set, seed| Generated {
            kind,
            duration_s,
            colour,
            noise: if colour == Colour::Resonance { 0.1 } else { 0.02 },
            noise_seed: seed,
            ..Generated::new(set.base)
        });
        for covered in covered {
            let share = covered as f64 / (REPETITIONS * sets.len()) as f64;
            assert!((0.90..0.995).contains(&share), "{title}: {share}");
        }
    }
}

#[test]
#[ignore = "for the tables in docs/estimation.md"]
fn both_methods_side_by_side() {
    for duration_s in [75.0, 25.0] {
        println!("{duration_s} s sweeps, white noise of 2 %: errors in %, (k, omega, zeta)");
        println!("| set | likelihood | report | report, starts converged |");
        for set in table() {
            let record = Generated { duration_s, noise: 0.02, ..Generated::new(set.base) }.record();
            let truth = [("k", set.base.k()), ("omega", set.base.omega()), ("zeta", set.base.zeta())];
            let errors = |fit: &Fit| {
                let error = |(name, truth): (&str, f64)| {
                    let value = fit.estimates.iter().find(|estimate| estimate.name == name).unwrap().value;
                    format!("{:+.2}", 100.0 * (value / truth - 1.0))
                };
                truth.map(error).join(", ")
            };
            let likelihood = fit(std::slice::from_ref(&record), &Settings::default()).unwrap();
            let report = fit(&[record], &Settings { method: Method::Report, ..Settings::default() }).unwrap();
            let converged = report.starts.iter().filter(|start| start.converged).count();
            println!(
                "| {} | {} | {} | {} of {} |",
                set.name,
                errors(&likelihood),
                errors(&report),
                converged,
                report.starts.len()
            );
        }
    }
}
