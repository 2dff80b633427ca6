//! Estimates from records with spikes, and with noise whose size depends on the rate.

use actuator_fmu::parameters::{Base, Order, table};
use identification::{
    estimate::{Fit, OrderChoice, Settings, fit},
    frequency::{self, BAND_HZ, phase_deg, response},
    signal::{
        excitation::Kind,
        record::{Record, rms},
    },
};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::{Distribution, StandardNormal};

use crate::generated::{Colour, Generated};

/// The record with another position.
fn with_position(record: &Record, position: Vec<f64>) -> Record {
    let (unit, interpolation) = (record.unit(), record.interpolation());
    Record::new(record.to_command(), position, unit, interpolation, record.source()).unwrap()
}

/// The record with spikes of this many standard deviations of its noise at a thousandth of its samples.
fn with_spikes(record: &Record, size: f64, seed: u64) -> Record {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut position = record.position().to_vec();
    for _ in 0..position.len() / 1000 {
        let (place, sign) = (random.random_range(0..position.len()), random.random_range(0..2));
        position[place] += if sign == 0 { size } else { -size };
    }
    with_position(record, position)
}

/// The record with noise that is small at rest and grows with the rate, in total this share of the position's rms.
fn with_rate_noise(record: &Record, share: f64, seed: u64) -> Record {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let position = record.position();
    let rate: Vec<f64> = (0..position.len())
        .map(|n| position[(n + 1).min(position.len() - 1)] - position[n.saturating_sub(1)])
        .collect();
    let typical = rms(&rate);
    let sizes: Vec<f64> = rate.iter().map(|rate| 0.2 + rate.abs() / typical).collect();
    let scale = share * rms(position) / rms(&sizes);
    let noisy = position.iter().zip(&sizes).map(|(value, size)| {
        let draw: f64 = StandardNormal.sample(&mut random);
        value + scale * size * draw
    });
    with_position(record, noisy.collect())
}

fn numbers(fit: &Fit) -> [(f64, f64); 3] {
    ["k", "omega", "zeta"].map(|name| {
        let estimate = fit.estimates.iter().find(|estimate| estimate.name == name).unwrap();
        (estimate.value, estimate.std_error.unwrap())
    })
}

fn truth(base: &Base) -> [f64; 3] {
    [base.k(), base.omega(), base.zeta()]
}

#[test]
#[ignore = "slow"]
fn spikes_move_no_parameter_by_more_than_its_standard_error() {
    for (number, set) in table().iter().enumerate().step_by(3) {
        for (kind, noise, colour) in [
            (Kind::Sweep, 0.02, Colour::White),
            (Kind::Random, 0.02, Colour::First(0.95)),
            (Kind::Random, 0.002, Colour::White),
        ] {
            let seed = number as u64;
            let generated = Generated { kind, noise, colour, noise_seed: seed, ..Generated::new(set.base) };
            let clean = generated.record();
            let spoilt = with_spikes(&clean, 30.0 * noise * rms(clean.position()), seed);
            let [without, with] = [clean, spoilt].map(|record| fit(&[record], &Settings::default()).unwrap());
            let label = format!("{} {kind:?} {noise} {colour:?}", set.name);
            assert!(without.notes.iter().all(|note| !note.contains("spikes")), "{label}: {:?}", without.notes);
            assert!(with.notes.iter().any(|note| note.contains("spikes")), "{label}: {:?}", with.notes);
            for ((a, a_error), (b, b_error)) in numbers(&without).into_iter().zip(numbers(&with)) {
                assert!((a - b).abs() < 0.5 * a_error, "{label}: {a} and {b} +- {a_error}");
                assert!((b_error / a_error - 1.0).abs() < 0.2, "{label}: errors {a_error} and {b_error}");
            }
        }
    }
}

#[test]
#[ignore = "slow"]
fn noise_that_grows_with_the_rate_is_weighed_and_its_errors_are_those_stated() {
    let (mut squares, mut count, mut greatest) = (0.0, 0.0, 0.0_f64);
    for (number, set) in table().iter().enumerate() {
        for kind in [Kind::Sweep, Kind::Random] {
            let clean = Generated { kind, duration_s: 50.0, ..Generated::new(set.base) }.record();
            let record = with_rate_noise(&clean, 0.02, number as u64);
            let fit = fit(&[record], &Settings::default()).unwrap();
            let label = format!("{} {kind:?}", set.name);
            assert!(fit.notes.iter().any(|note| note.contains("depends on the rate")), "{label}: {:?}", fit.notes);
            assert!(fit.notes.iter().all(|note| !note.contains("not noise alone")), "{label}: {:?}", fit.notes);
            for ((value, error), truth) in numbers(&fit).into_iter().zip(truth(&set.base)) {
                let off = (value - truth) / error;
                squares += off * off;
                count += 1.0;
                greatest = greatest.max(off.abs());
            }
        }
    }
    println!("mean of squares {}, greatest {greatest}", squares / count);
    assert!(squares / count < 1.3 && greatest < 4.0, "{} {greatest}", squares / count);
}

#[test]
fn standard_errors_of_responses_hold_in_noise_that_grows_with_the_rate() {
    for kind in [Kind::Sweep, Kind::Random] {
        let (mut squares, mut count) = (0.0, 0.0);
        for (number, set) in table().iter().enumerate() {
            let clean = Generated { kind, duration_s: 50.0, ..Generated::new(set.base) }.record();
            let record = with_rate_noise(&clean, 0.02, number as u64);
            let measured = frequency::estimate(&[record], frequency::Method::Polynomial).unwrap();
            for point in measured.inside(BAND_HZ).step_by(13) {
                let exact = response(&set.base, Order::Third, point.frequency_hz);
                let magnitude = (point.response.norm() - exact.norm()) / point.magnitude_std_error;
                let phase = phase_deg(point.response * exact.conj()) / point.phase_std_error_deg;
                squares += magnitude * magnitude + phase * phase;
                count += 2.0;
            }
        }
        println!("{kind:?}: mean of squares {}", squares / count);
        assert!(squares / count < 1.3, "{kind:?}: {}", squares / count);
    }
}

#[test]
#[ignore = "slow"]
fn noise_alone_is_never_called_more_and_loses_no_sample() {
    for (number, set) in table().iter().enumerate() {
        for (kind, colour, noise) in [
            (Kind::Sweep, Colour::White, 0.02),
            (Kind::Random, Colour::First(0.95), 0.02),
            (Kind::Sweep, Colour::Resonance, 0.1),
        ] {
            let seed = number as u64;
            let record =
                Generated { kind, colour, noise, noise_seed: seed, duration_s: 50.0, ..Generated::new(set.base) };
            let fit = fit(&[record.record()], &Settings::default()).unwrap();
            let wrong = ["not noise alone", "spikes", "depends on the rate"];
            let said = |note: &&String| wrong.iter().any(|words| note.contains(words));
            assert_eq!(fit.notes.iter().find(said), None, "{} {kind:?} {colour:?}", set.name);
        }
    }
}

#[test]
#[ignore = "slow"]
fn a_residual_that_depends_on_the_motion_is_said_to_however_small() {
    for (number, set) in table().iter().enumerate().step_by(4) {
        // Dry friction of a sensor's linkage and a cubic gain: a tenth of the noise and more.
        for (kind, shape) in [
            (Kind::Random, (|position: f64, rate: f64| 0.006 * rate.signum() + 0.0 * position) as fn(f64, f64) -> f64),
            (Kind::Sweep, |position, _| 0.01 * position * position),
        ] {
            let clean = Generated { kind, noise: 0.01, noise_seed: number as u64, ..Generated::new(set.base) }.record();
            let smooth = Generated { kind, ..Generated::new(set.base) }.record();
            let position = smooth.position();
            let spoilt = (0..position.len()).map(|n| {
                let rate = position[(n + 1).min(position.len() - 1)] - position[n.saturating_sub(1)];
                clean.position()[n] + rms(position) * shape(position[n] / rms(position), rate)
            });
            let fit = fit(&[with_position(&clean, spoilt.collect())], &Settings::default()).unwrap();
            let said = fit.notes.iter().any(|note| note.contains("not noise alone"));
            assert!(said, "{} {kind:?}: {} rms, {:?}", set.name, fit.residual_rms, fit.notes);
        }
    }
}

#[test]
fn the_order_with_the_larger_residual_is_stated_with_its_reason() {
    for (number, set) in table().iter().enumerate() {
        let record = Generated { noise: 0.02, noise_seed: number as u64, duration_s: 25.0, ..Generated::new(set.base) };
        let record = record.record();
        let of = |order| fit(std::slice::from_ref(&record), &Settings { order, ..Settings::default() }).unwrap();
        let [second, third, auto] = [OrderChoice::Second, OrderChoice::Third, OrderChoice::Auto].map(of);
        let least = second.residual_rms.min(third.residual_rms);
        let reason = auto.notes.iter().any(|note| note.contains("has the smaller residual"));
        assert!(reason || auto.residual_rms < least * (1.0 + 1e-7), "{}: {} {least}", set.name, auto.residual_rms);
    }
}
