//! Excitations, and records made of them.

use actuator_fmu::parameters::PositionUnit;
use identification::signal::{
    Interpolation,
    excitation::{Excitation, Kind},
    record::Record,
};

#[test]
fn excitations_have_their_size_band_and_seed() {
    for kind in Kind::ALL {
        let excitation =
            Excitation { amplitude: 3.0, seed: 11, duration_s: 25.0, quiet_s: 1.0, ..Excitation::new(kind) };
        let command = excitation.command().unwrap();
        assert_eq!(command.command.len(), 5000);
        let peak = command.command.iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
        assert!((peak - 3.0).abs() < 0.01, "{kind:?}: {peak}");
        assert!(command.command[..200].iter().chain(&command.command[4800..]).all(|value| *value == 0.0), "{kind:?}");
        assert_eq!(excitation.command().unwrap(), command);
        let other = Excitation { seed: 12, ..excitation }.command().unwrap();
        assert_eq!(other == command, matches!(kind, Kind::Sweep | Kind::Triangles), "{kind:?}");
    }
    // Outside 0.5-12 Hz random and multisine contain only the ends of the record.
    for (kind, least) in [(Kind::Random, 0.99), (Kind::Multisine, 0.999)] {
        let command = Excitation { duration_s: 50.0, ..Excitation::new(kind) }.command().unwrap().command;
        let power = |from_hz: f64, to_hz: f64| -> f64 {
            let lines = (1..2500).map(|line| f64::from(line) / 50.0).filter(|f| (from_hz..=to_hz).contains(f));
            lines
                .map(|f| {
                    let turn = std::f64::consts::TAU * f * 0.005;
                    let (mut re, mut im) = (0.0, 0.0);
                    for (index, value) in command.iter().enumerate() {
                        let (sin, cos) = (turn * index as f64).sin_cos();
                        re += value * cos;
                        im -= value * sin;
                    }
                    re * re + im * im
                })
                .sum()
        };
        assert!(power(0.4, 12.1) > least * power(0.0, 50.0), "{kind:?}");
    }
    let odd = Excitation { band_hz: [5.0, 4.0], ..Excitation::new(Kind::Sweep) };
    assert!(odd.command().unwrap_err().to_string().contains("upper edge of the band"));
    let short = Excitation { duration_s: 0.1, ..Excitation::new(Kind::Random) };
    assert!(short.command().unwrap_err().to_string().contains("samples"));
}

#[test]
fn a_generated_record_is_checked_like_a_measured_one() {
    let command = Excitation::new(Kind::Sweep).command().unwrap();
    let short = Record::new(command.clone(), vec![0.0; 7], PositionUnit::Degree, Interpolation::Held, "short");
    assert!(short.unwrap_err().to_string().contains("lengths"));
    let mut position = vec![0.0; command.time.len()];
    position[3] = f64::NAN;
    let nan = Record::new(command, position, PositionUnit::Degree, Interpolation::Held, "nan");
    assert!(nan.unwrap_err().to_string().contains("NaN"));
}
