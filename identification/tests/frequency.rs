//! Frequency responses from records, against analytic ones.

use actuator_fmu::parameters::{Base, Model, Order, table};
use identification::{
    frequency::{BAND_HZ, FrequencyResponse, Method, estimate, phase_deg, response},
    signal::{
        Command, Interpolation,
        excitation::{Excitation, Kind},
        format::PositionUnit,
        record::Record,
    },
    simulate::simulate,
};
use nalgebra::Complex;

use crate::generated::Generated;

/// Greatest distance from eq. (1) in the report's band.
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
