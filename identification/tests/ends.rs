//! Responses from sweeps that end in mid-motion: from the end of such a record to its beginning the command jumps, and a jump has power at
//! all lines.

use std::f64::consts::{FRAC_PI_2, TAU};

use actuator_fmu::parameters::{Model, Order, table};
use identification::{
    frequency::{FrequencyResponse, Method, estimate, response},
    signal::{Command, Interpolation, format::PositionUnit, record::Record},
    simulate::simulate,
};
use rand::{SeedableRng, rngs::ChaCha8Rng};
use rand_distr::{Distribution, StandardNormal};

const BAND_HZ: [f64; 2] = [0.5, 12.0];

/// A sweep at 200 samples/s.
#[derive(Clone, Copy, Debug)]
struct Sweep {
    duration_s: f64,
    logarithmic: bool,
    /// Angle at which it ends [rad].
    end: f64,
    /// Rest after it [s].
    rest_s: f64,
    noise: f64,
}

impl Sweep {
    fn angle(&self, share: f64) -> f64 {
        let [low, high] = BAND_HZ;
        let ratio = high / low;
        let turns = if self.logarithmic {
            low * (ratio.powf(share) - 1.0) / ratio.ln()
        } else {
            low * share + 0.5 * (high - low) * share * share
        };
        TAU * self.duration_s * turns
    }

    fn measured(&self) -> FrequencyResponse {
        let count = 200.0 * (self.duration_s + self.rest_s);
        let time: Vec<f64> = (0..count as usize).map(|n| n as f64 / 200.0).collect();
        // Stretched slightly, so that it ends at the required angle.
        let turns = ((self.angle(1.0) - self.end) / TAU).round();
        let stretch = (TAU * turns + self.end) / self.angle(1.0);
        let value = |t: &f64| {
            if *t < self.duration_s { (stretch * self.angle(t / self.duration_s)).sin() } else { 0.0 }
        };
        let command = Command { command: time.iter().map(value).collect(), time };
        let model = Model::new(table()[0].base, Order::Third);
        let mut position = simulate(&model, &command, Interpolation::Held).unwrap().position;
        let mut random = ChaCha8Rng::seed_from_u64(7);
        position.iter_mut().for_each(|value| {
            let noise: f64 = StandardNormal.sample(&mut random);
            *value += self.noise * noise;
        });
        let record = Record::new(command, position, PositionUnit::Degree, Interpolation::Held, "sweep").unwrap();
        estimate(&[record], Method::Polynomial).unwrap()
    }
}

#[test]
fn lines_that_only_the_jump_from_end_to_beginning_excites_are_not_stated() {
    let truth = table()[0].base;
    for duration_s in [25.0, 75.0, 300.0] {
        for (logarithmic, end) in [(false, FRAC_PI_2), (false, 0.0), (true, FRAC_PI_2), (true, 0.0)] {
            for noise in [0.002, 0.05] {
                let sweep = Sweep { duration_s, logarithmic, end, rest_s: 0.0, noise };
                let measured = sweep.measured();
                let wrong = measured.points.iter().filter(|point| {
                    let exact = response(&truth, Order::Third, point.frequency_hz);
                    (point.response - exact).norm() > 0.5 * exact.norm()
                });
                let (wrong, count) = (wrong.count(), measured.points.len());
                assert!(200 * wrong <= count, "{sweep:?}: {wrong} of {count} lines are off by half");
                let [low, high] = measured.excited_band_hz().unwrap();
                assert!(low < 1.4 && high > 9.0 && high < 12.5, "{sweep:?}: {low} to {high} Hz");
                // Where command and transient differ, no accuracy is lost.
                let inside = measured.inside([2.0, 9.0]).count() as f64;
                let lines = 7.0 * duration_s.min(100.0);
                assert!((inside / lines - 1.0).abs() < 0.01, "{sweep:?}: {inside} of {lines} lines");
                assert!(measured.notes.iter().any(|note| note.contains("left out")), "{sweep:?}");
            }
        }
    }
}

#[test]
fn a_sweep_that_rests_at_its_end_shows_its_whole_upper_band() {
    let truth = table()[0].base;
    let sweep = Sweep { duration_s: 75.0, logarithmic: false, end: FRAC_PI_2, rest_s: 5.0, noise: 0.02 };
    let measured = sweep.measured();
    let mut count = 0;
    for point in measured.inside([2.0, 12.0]) {
        let exact = response(&truth, Order::Third, point.frequency_hz);
        let off = (point.response - exact).norm() / (std::f64::consts::SQRT_2 * point.magnitude_std_error);
        assert!(off < 4.5 && point.coherence > 0.9, "{} Hz: {off}, {}", point.frequency_hz, point.coherence);
        count += 1;
    }
    assert!((count - 800_i32).abs() <= 1, "{count}");
}

#[test]
fn one_block_tells_no_noise() {
    let sweep = Sweep { duration_s: 12.0, logarithmic: false, end: FRAC_PI_2, rest_s: 0.0, noise: 0.05 };
    let model = Model::new(table()[0].base, Order::Third);
    let time: Vec<f64> = (0..2400).map(|n| f64::from(n) / 200.0).collect();
    let command = Command { command: time.iter().map(|t| sweep.angle(t / 12.0).sin()).collect(), time };
    let position = simulate(&model, &command, Interpolation::Held).unwrap().position;
    let record = Record::new(command, position, PositionUnit::Degree, Interpolation::Held, "short").unwrap();
    let single = estimate(std::slice::from_ref(&record), Method::Report).unwrap();
    assert!(single.notes[0].contains("single block"), "{:?}", single.notes);
    assert!(single.points.iter().all(|point| point.coherence == 0.0 && point.magnitude_std_error.is_infinite()));
    let twice = estimate(&[record.clone(), record], Method::Report).unwrap();
    assert!(twice.points.iter().all(|point| point.magnitude_std_error.is_finite()));
}
