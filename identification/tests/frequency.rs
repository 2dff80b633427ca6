//! Frequency responses from records, against analytic ones.

use actuator_fmu::parameters::{Base, Model, Order, table};
use identification::{
    frequency::{
        BAND_HZ, FrequencyPoint, FrequencyResponse, LineChoice, Method, estimate, phase_deg, polynomial, response,
    },
    signal::{
        Command, Interpolation,
        excitation::{Excitation, Kind},
        format::PositionUnit,
        record::{Record, rms},
    },
    simulate::simulate,
};
use nalgebra::Complex;
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

use crate::generated::Generated;

/// Largest deviation from eq. (1) in the report's band.
fn greatest_error(measured: &FrequencyResponse, truth: &Base) -> f64 {
    let inside = measured.inside(BAND_HZ).filter(|point| point.excited);
    inside.map(|point| (point.response - response(truth, Order::Third, point.frequency_hz)).norm()).fold(0.0, f64::max)
}

#[test]
fn without_noise_local_polynomials_give_the_analytic_response() {
    for set in table().iter().step_by(2) {
        for interpolation in [Interpolation::Held, Interpolation::Linear] {
            for (kind, duration_s) in
                [(Kind::Sweep, 75.0), (Kind::Random, 25.0), (Kind::Multisine, 25.0), (Kind::Sweep, 25.0)]
            {
                let record = Generated { kind, duration_s, interpolation, ..Generated::new(set.base) }.record();
                let measured = estimate(&[record], Method::Polynomial).unwrap();
                let [low, high] = measured.excited_band_hz().unwrap();
                assert!(low < 0.6 && high > 11.9 && high < 13.1, "{} {kind:?}: {low} to {high}", set.name);
                let error = greatest_error(&measured, &set.base);
                assert!(error < 1e-4, "{} {kind:?} {duration_s} s {interpolation:?}: {error}", set.name);
            }
        }
    }
}

#[test]
fn the_report_s_recipe_is_good_on_long_records_and_not_on_short_ones() {
    for name in ["te-early-unloaded", "us-late-loaded"] {
        let truth = table().iter().find(|set| set.name.to_string() == name).unwrap().base;
        let error = |duration_s, band_hz| {
            let record = Generated { duration_s, noise: 0.02, ..Generated::new(truth) }.record();
            let measured = estimate(&[record], Method::Report).unwrap();
            let inside = measured.inside(band_hz);
            let phase = inside
                .map(|point| phase_deg(point.response * response(&truth, Order::Third, point.frequency_hz).conj()));
            (phase.map(f64::abs).fold(0.0, f64::max), measured.averages.unwrap())
        };
        // Away from the ends of the band; and as used by the report, every bin from 0.5 to 12 Hz.
        let ((long, _), (short, averages)) = (error(75.0, [2.0, 10.0]), error(25.0, BAND_HZ));
        assert!(long < 0.3, "{name}: {long} deg");
        assert!(short > 5.0, "{name}: {short} deg");
        assert!((averages - 3.4).abs() < 0.05, "{averages}");
    }
}

#[test]
fn standard_errors_of_magnitude_and_phase_are_those_seen() {
    let truth = table()[0].base;
    let (mut magnitude, mut phase, mut count) = (0.0, 0.0, 0.0);
    for noise_seed in 0..12 {
        let record =
            Generated { kind: Kind::Random, duration_s: 25.0, noise: 0.05, noise_seed, ..Generated::new(truth) }
                .record();
        let measured = estimate(&[record], Method::Polynomial).unwrap();
        for point in measured.inside(BAND_HZ).step_by(17) {
            let exact = response(&truth, Order::Third, point.frequency_hz);
            magnitude += ((point.response.norm() - exact.norm()) / point.magnitude_std_error).powi(2);
            phase += (phase_deg(point.response * exact.conj()) / point.phase_std_error_deg).powi(2);
            count += 1.0;
        }
    }
    // About 200 values each: the mean of squares is 1 to within three times √(2/200).
    assert!((magnitude / count - 1.0_f64).abs() < 0.3, "{}", magnitude / count);
    assert!((phase / count - 1.0_f64).abs() < 0.3, "{}", phase / count);
}

#[test]
fn several_records_are_averaged_by_their_noise() {
    let truth = table()[3].base;
    let quiet = Generated { noise: 0.002, ..Generated::new(truth) }.record();
    let noisy = Generated { kind: Kind::Random, duration_s: 25.0, noise: 0.2, ..Generated::new(truth) }.record();
    let alone = estimate(std::slice::from_ref(&quiet), Method::Polynomial).unwrap();
    let both = estimate(&[quiet, noisy], Method::Polynomial).unwrap();
    assert!(greatest_error(&both, &truth) < 1.2 * greatest_error(&alone, &truth) + 1e-3);
    assert!(
        both.inside([2.0, 10.0])
            .zip(alone.inside([2.0, 10.0]))
            .all(|(both, alone)| { both.magnitude_std_error <= 1.001 * alone.magnitude_std_error })
    );
}

#[test]
fn uneven_samples_give_the_same_response() {
    let truth = table()[5].base;
    let mut command = Excitation { duration_s: 50.0, ..Excitation::new(Kind::Random) }.command().unwrap();
    command.time =
        (0..command.time.len()).map(|index| (index as f64 + 0.3 * (index as f64 * 0.7).sin()) * 0.005).collect();
    for interpolation in [Interpolation::Held, Interpolation::Linear] {
        let position = simulate(&Model::new(truth, Order::Third), &command, interpolation).unwrap().position;
        let record = Record::new(command.clone(), position, PositionUnit::Degree, interpolation, "uneven").unwrap();
        let measured = estimate(&[record], Method::Polynomial).unwrap();
        // A spline through samples of a motion with corners in its acceleration.
        let error = greatest_error(&measured, &truth);
        assert!(error < 3e-3, "{interpolation:?}: {error}");
        assert!(measured.notes[0].contains("uneven"));
    }
}

#[test]
fn a_response_that_no_model_has_is_measured_all_the_same() {
    // A weak structural mode at 8 Hz on top of eq. (1), as a sum of two positions: H = H1 + 0.1 H2.
    let truth = table()[1].base;
    let mode = Base::new(0.1, 1e6, std::f64::consts::TAU * 8.0, 0.05).unwrap();
    let command: Command = Excitation { duration_s: 75.0, ..Excitation::new(Kind::Random) }.command().unwrap();
    let position = |base, order| simulate(&Model::new(base, order), &command, Interpolation::Held).unwrap().position;
    let sum: Vec<f64> =
        position(truth, Order::Third).iter().zip(position(mode, Order::Second)).map(|(a, b)| a + b).collect();
    let record = Record::new(command, sum, PositionUnit::Degree, Interpolation::Held, "two modes").unwrap();
    let measured = estimate(&[record], Method::Polynomial).unwrap();
    for point in measured.inside([0.7, 11.8]) {
        let f = point.frequency_hz;
        let exact: Complex<f64> = response(&truth, Order::Third, f) + response(&mode, Order::Second, f);
        // The mode is 0.8 Hz wide and peaks at one; the polynomials span half a hertz.
        assert!((point.response - exact).norm() < 0.02, "{f} Hz: {} {exact}", point.response);
    }
}

#[test]
fn long_records_are_resolved_on_a_grid_and_every_line_says_the_same() {
    let truth = table()[2].base;
    let record = Generated { kind: Kind::Random, duration_s: 600.0, noise: 0.02, ..Generated::new(truth) }.record();
    let grid = estimate(std::slice::from_ref(&record), Method::Polynomial).unwrap();
    let every = polynomial::estimate(std::slice::from_ref(&record), LineChoice::All).unwrap();
    assert!((1100..1200).contains(&grid.points.len()), "{}", grid.points.len());
    assert!((6850..6950).contains(&every.points.len()), "{}", every.points.len());
    for point in &grid.points {
        let near = |other: &&FrequencyPoint| (other.frequency_hz - point.frequency_hz).abs() < 1e-6;
        let same = every.points.iter().find(near).unwrap();
        // From the same neighbourhood, but for a reference model with other points.
        let apart = (same.response - point.response).norm() / point.magnitude_std_error;
        assert!(apart < 0.2, "{} Hz: {apart} standard errors", point.frequency_hz);
        let exact = response(&truth, Order::Third, point.frequency_hz);
        let off = (point.response - exact).norm() / (std::f64::consts::SQRT_2 * point.magnitude_std_error);
        assert!(off < 4.5, "{} Hz: {off} standard errors", point.frequency_hz);
    }
}

#[test]
fn frequencies_stay_inside_what_the_command_excites_and_below_half_the_sampling_rate() {
    let truth = table()[2].base;
    let of = |kind, duration_s, noise| {
        let record = Generated { kind, duration_s, noise, ..Generated::new(truth) }.record();
        estimate(&[record], Method::Polynomial).unwrap()
    };
    for noise in [0.0, 0.02] {
        for (kind, duration_s) in [(Kind::Multisine, 25.0), (Kind::Multisine, 400.0), (Kind::Random, 400.0)] {
            let measured = of(kind, duration_s, noise);
            let [low, high] = measured.excited_band_hz().unwrap();
            // The ends of a record excite some lines outside the band.
            let lines = 12.0 / duration_s;
            assert!(low > 0.5 - lines && low < 0.52 + lines, "{kind:?} {duration_s} s: from {low} Hz");
            assert!(high < 12.0 + lines && high > 11.95 - lines, "{kind:?} {duration_s} s: to {high} Hz");
            assert!(measured.points.iter().all(|point| point.excited && point.magnitude_std_error.is_finite()));
        }
    }
    // Steps that excite all frequencies.
    let time: Vec<f64> = (0..4000).map(|index| f64::from(index) * 0.005).collect();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let command: Vec<f64> = (0..4000).map(|_| f64::from(random.random_range(0..2))).collect();
    let command = Command { time, command };
    let position = simulate(&Model::new(truth, Order::Third), &command, Interpolation::Held).unwrap().position;
    let record = Record::new(command, position, PositionUnit::Degree, Interpolation::Held, "wide").unwrap();
    let wide = estimate(&[record], Method::Polynomial).unwrap();
    assert!(wide.points.iter().all(|point| point.frequency_hz < 100.0) && wide.points.len() > 1000);
}

#[test]
fn where_nothing_is_excited_nothing_is_known() {
    // Two sines: two lines for three coefficients.
    let truth = table()[2].base;
    let time: Vec<f64> = (0..8000).map(|index| f64::from(index) * 0.005).collect();
    let sines = |t: &f64| (std::f64::consts::TAU * t).sin() + (std::f64::consts::TAU * 8.0 * t).sin();
    let command = Command { command: time.iter().map(sines).collect(), time };
    let position = simulate(&Model::new(truth, Order::Third), &command, Interpolation::Held).unwrap().position;
    let record = Record::new(command, position, PositionUnit::Degree, Interpolation::Held, "two sines").unwrap();
    let measured = estimate(&[record], Method::Polynomial).unwrap();
    for point in &measured.points {
        let off = (point.response - response(&truth, Order::Third, point.frequency_hz)).norm();
        assert!(off < 0.01, "{} Hz: {off} with a coherence of {}", point.frequency_hz, point.coherence);
    }
}

/// The record with spikes of this many standard deviations of its noise at a thousandth of its samples.
fn with_spikes(record: &Record, size: f64, seed: u64) -> Record {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut position = record.position().to_vec();
    for _ in 0..position.len() / 1000 {
        let (place, sign) = (random.random_range(0..position.len()), random.random_range(0..2));
        position[place] += if sign == 0 { size } else { -size };
    }
    let (unit, interpolation) = (record.unit(), record.interpolation());
    Record::new(record.to_command(), position, unit, interpolation, "with spikes").unwrap()
}

#[test]
fn spikes_move_no_response_by_more_than_its_standard_error() {
    for (number, set) in table().iter().enumerate().step_by(4) {
        for (kind, noise) in [(Kind::Sweep, 0.02), (Kind::Random, 0.02), (Kind::Random, 0.002)] {
            let generated = Generated { kind, noise, noise_seed: number as u64, ..Generated::new(set.base) };
            let clean = generated.record();
            let spoilt = with_spikes(&clean, 30.0 * noise * rms(clean.position()), number as u64);
            let [without, with] = [clean, spoilt].map(|record| estimate(&[record], Method::Polynomial).unwrap());
            assert!(
                without.notes.iter().all(|note| note.contains("the ends of the record"))
                    && with.notes.len() == without.notes.len() + 1
                    && with.notes.iter().any(|note| note.contains("spikes")),
                "{} {kind:?} {noise}: {:?}",
                set.name,
                with.notes
            );
            let pairs = || without.inside(BAND_HZ).zip(with.inside(BAND_HZ));
            let moved = pairs().map(|(a, b)| (a.response - b.response).norm() / a.magnitude_std_error);
            let moved = moved.fold(0.0, f64::max);
            assert!(moved < 1.0, "{} {kind:?} {noise}: {moved} standard errors", set.name);
            let wider = pairs().map(|(a, b)| b.magnitude_std_error / a.magnitude_std_error).fold(0.0, f64::max);
            assert!(wider < 1.3, "{} {kind:?} {noise}: {wider}", set.name);
        }
    }
}

#[test]
fn long_uneven_records_take_no_longer_for_it() {
    let truth = table()[5].base;
    let mut command = Excitation { duration_s: 500.0, ..Excitation::new(Kind::Random) }.command().unwrap();
    command.time =
        (0..command.time.len()).map(|index| (index as f64 + 0.3 * (index as f64 * 0.7).sin()) * 0.005).collect();
    let position = simulate(&Model::new(truth, Order::Third), &command, Interpolation::Held).unwrap().position;
    let record = Record::new(command, position, PositionUnit::Degree, Interpolation::Held, "uneven").unwrap();
    let measured = estimate(&[record], Method::Polynomial).unwrap();
    let error = greatest_error(&measured, &truth);
    assert!(error < 3e-3 && measured.points.len() > 1000, "{error}, {}", measured.points.len());
}
