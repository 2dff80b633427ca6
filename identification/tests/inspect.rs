//! Findings on records whose truth is known: nothing serious on healthy ones, generated or measured.

use std::{env, f64::consts::TAU, fs::File, path::Path};

use actuator_fmu::{
    effects::{Effects, find},
    parameters::{Model, table},
};
use identification::{
    generated::TestPoint,
    inspect::{ExpectedGain, admit, finding::Severity, inspect, noise::Source, without_sensor_faults},
    signal::{
        Command, Interpolation,
        excitation::{Excitation, Kind},
        format::{Columns, Format, PositionUnit},
        record::Record,
        source::Hashed,
    },
};
use rand::{SeedableRng, rngs::ChaCha8Rng};
use rand_distr::{Distribution, StandardNormal};

/// A record of an actuator of the tables with noise and, where named, an effect.
pub fn record(set: usize, kind: Kind, effect: Option<(&str, &[f64])>) -> Record {
    let excitation = Excitation { amplitude: 2.0, duration_s: 25.0, seed: set as u64, ..Excitation::new(kind) };
    let mut model = Model::from_set(&table()[set]);
    if let Some((name, values)) = effect {
        model.effects = Effects::default().with(find(name).unwrap(), values).unwrap();
    }
    let point = TestPoint {
        model,
        excitation,
        interpolation: Interpolation::Held,
        noise_share: 0.01,
        turbulence: None,
        seed: set as u64,
    };
    point.record("generated").unwrap()
}

/// Findings other than notes.
pub fn grave(record: &Record) -> Vec<String> {
    let findings = inspect(record).findings.into_iter();
    findings.filter(|finding| finding.severity > Severity::Note).map(|finding| finding.text()).collect()
}

#[test]
fn nothing_grave_is_said_of_healthy_records() {
    for set in 0..table().len() {
        for kind in Kind::ALL {
            let found = grave(&record(set, kind, None));
            assert!(found.is_empty(), "set {set}, {kind:?}: {found:?}");
        }
    }
}

#[test]
fn a_step_is_told_of_a_converter_and_not_of_the_digits_of_a_file() {
    let recorded = record(0, Kind::Random, None);
    let peak = recorded.position().iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
    assert!((1.0..4.0).contains(&peak));
    for (step, told) in [(0.02, true), (1e-3, true), (1e-6, false), (1e-8, false), (4e-9, false)] {
        let rounded = |values: &[f64]| values.iter().map(|value| (value / step).round() * step).collect::<Vec<f64>>();
        let command = Command { time: recorded.time().to_vec(), command: rounded(recorded.command()) };
        let position = rounded(recorded.position());
        let found =
            inspect(&Record::new(command, position, PositionUnit::Degree, Interpolation::Held, "rounded").unwrap());
        let expected = if told { step } else { 0.0 };
        for found in [found.position_step, found.command_step] {
            assert!((found - expected).abs() <= 1e-6 * expected, "{step}: {found}");
        }
        assert_eq!(found.findings.iter().any(|finding| finding.kind == "quantisation"), told, "{step}");
    }
}

#[test]
fn small_motion_within_play_is_a_warning_beside_a_record_that_follows_and_noise_stays_refused() {
    let stuck = record(0, Kind::Random, Some(("coulomb_friction", &[1.5])));
    let follows = record(0, Kind::Multisine, None);
    assert!(admit(&[&stuck], ExpectedGain::Any).is_err());
    let warnings = admit(&[&stuck, &follows], ExpectedGain::Any).unwrap();
    assert!(warnings.iter().any(|warning| warning.contains("another record of the actuator does")), "{warnings:?}");
    // As much motion as that of the command, but of another record.
    let crossed = Record::new(
        stuck.to_command(),
        record(3, Kind::Sweep, None).position().to_vec(),
        PositionUnit::default(),
        Interpolation::Held,
        "crossed",
    );
    assert!(admit(&[&crossed.unwrap(), &follows], ExpectedGain::Any).is_err());
}

/// A dead zone wide enough for the record beyond it to be little more linear than it must be.
#[test]
fn motion_within_a_dead_zone_is_a_warning_beside_a_record_that_goes_beyond() {
    let dead_zone = Some(("command_dead_zone", &[1.1][..]));
    let beyond = record(0, Kind::Sweep, dead_zone);
    assert!(inspect(&beyond).following_share < 0.9);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let noise: Vec<f64> = beyond.position().iter().map(|_| StandardNormal.sample(&mut random)).collect();
    let command = record(0, Kind::Random, None).command().iter().map(|value| 0.5 * value).collect();
    let within = Record::new(
        Command { time: beyond.time().to_vec(), command },
        noise.iter().map(|noise| 0.01 * noise).collect(),
        PositionUnit::default(),
        Interpolation::Held,
        "within",
    )
    .unwrap();
    assert!(admit(&[&within], ExpectedGain::Any).is_err());
    let warnings = admit(&[&within, &beyond], ExpectedGain::Any).unwrap();
    assert!(warnings.iter().any(|warning| warning.contains("another record of the actuator does")), "{warnings:?}");
    // A position of another record follows neither by itself nor behind a dead zone.
    let other = record(3, Kind::Multisine, None);
    let crossed = with_position(&beyond, |_, n| other.position()[n]);
    assert!(admit(&[&within, &crossed], ExpectedGain::Any).is_err());
}

#[test]
fn a_gain_that_is_far_from_that_of_the_model_is_a_warning() {
    let follows = record(0, Kind::Multisine, None);
    let gain = inspect(&follows).gain;
    for (times, is_said) in [(0.01, true), (0.15, true), (0.5, false), (1.0, false), (2.0, false), (8.0, true)] {
        let warnings = admit(&[&follows], ExpectedGain::Like(gain / times)).unwrap();
        assert_eq!(warnings.iter().any(|warning| warning.contains("times as far as the model")), is_said, "{times}");
    }
}

#[test]
fn effects_of_the_actuator_are_not_taken_for_clocks_or_a_slow_rate() {
    let effects: [(&str, &[f64]); 8] = [
        ("rate_limit", &[40.0, 40.0]),
        ("acceleration_limit", &[3000.0]),
        ("backlash", &[0.3]),
        ("coulomb_friction", &[0.1]),
        ("asymmetric_gain", &[0.8]),
        ("gain_drift", &[0.005]),
        ("delay", &[0.004]),
        ("dead_zone", &[0.1]),
    ];
    for (name, values) in effects {
        for kind in Kind::ALL {
            let found = grave(&record(4, kind, Some((name, values))));
            assert!(found.is_empty(), "{name}, {kind:?}: {found:?}");
        }
    }
}

#[test]
fn a_drifting_sensor_is_said_with_its_drift() {
    for kind in Kind::ALL {
        let found = inspect(&record(0, kind, Some(("sensor_bias", &[0.0, 0.02]))));
        let drift = found.findings.iter().find(|finding| finding.kind == "level_drift");
        let drift = drift.unwrap_or_else(|| panic!("{kind:?}: {:?}", found.findings));
        assert!(drift.sentence.contains("drifts by 0.4") || drift.sentence.contains("drifts by 0.5"), "{drift:?}");
        assert!(drift.sample.is_some() && drift.time_s.is_some() && drift.remedy.contains("sensor"));
    }
}

/// The same record with another position.
fn with_position(record: &Record, position: impl Fn(&[f64], usize) -> f64) -> Record {
    let read = (0..record.len()).map(|n| position(record.position(), n)).collect();
    Record::new(record.to_command(), read, record.unit(), record.interpolation(), "changed").unwrap()
}

#[test]
fn what_a_logger_makes_of_a_position_is_said() {
    let kinds = |record: &Record| -> Vec<&'static str> {
        inspect(record).findings.iter().filter(|f| f.severity > Severity::Note).map(|finding| finding.kind).collect()
    };
    for kind in Kind::ALL {
        let healthy = record(0, kind, None);
        let last = healthy.len() - 1;
        let stretch = last / 2..last * 3 / 5;
        let frozen = with_position(&healthy, |p, n| p[if stretch.contains(&n) { stretch.start } else { n }]);
        let said = grave(&frozen);
        assert!(kinds(&frozen).contains(&"frozen") && said[0].contains("is constant at"), "{kind:?}: {said:?}");
        assert_eq!(kinds(&with_position(&healthy, |p, n| p[n - n % 3])), ["held_position"], "{kind:?}");
        // In a sweep the fast half resembles the response of another linear system.
        let glued = with_position(&healthy, |p, n| if n > last / 2 { -p[n] } else { p[n] });
        assert!(kind == Kind::Sweep || kinds(&glued).contains(&"sign_changes"), "{kind:?}: {:?}", kinds(&glued));
    }
}

#[test]
fn a_rate_is_no_position() {
    let moved = record(0, Kind::Random, None);
    let rate = with_position(&moved, |p, n| 200.0 * (p[(n + 1).min(p.len() - 1)] - p[n.saturating_sub(1)]) / 2.0);
    let found = grave(&rate);
    assert!(found.len() == 1 && found[0].contains("in proportion"), "{found:?}");
    assert!(admit(&[&rate], ExpectedGain::Any).is_ok());
    for expected in [ExpectedGain::Positive, ExpectedGain::Like(1.0)] {
        assert!(admit(&[&rate], expected).unwrap_err().to_string().contains("in proportion"));
    }
}

/// Record of a second-order servo (7 Hz) at this sampling rate, integrated in small steps, with noise and play at the output.
fn with_play(rate_hz: f64, half_gap: f64, noise: f64) -> Record {
    const FINE: u32 = 40;
    let excitation = Excitation { rate_hz, duration_s: 60.0, ..Excitation::new(Kind::Sweep) };
    let Command { time, command } = excitation.command().unwrap();
    let (omega, step) = (TAU * 7.0, 1.0 / (rate_hz * f64::from(FINE)));
    let (mut place, mut rate, mut behind) = (0.0, 0.0, 0.0_f64);
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let answered = command.iter().map(|command| {
        let chance: f64 = StandardNormal.sample(&mut random);
        let measured = behind + noise * chance;
        for _ in 0..FINE {
            rate += step * omega * (omega * (command - place) - 1.4 * rate);
            place += step * rate;
            behind = behind.clamp(place - half_gap, place + half_gap);
        }
        measured
    });
    let position = answered.collect();
    Record::new(Command { time, command }, position, PositionUnit::Degree, Interpolation::Held, "play").unwrap()
}

#[test]
fn noise_above_the_band_is_that_of_the_measurement_and_little_more_beside_play() {
    for rate_hz in [100.0, 500.0, 2000.0] {
        for (half_gap, noise, most) in [(0.0, 0.01, 1.06), (0.0, 1e-3, 1.15), (0.025, 2e-3, 2.0)] {
            let found = inspect(&with_play(rate_hz, half_gap, noise)).noise;
            assert_eq!(found.source, Source::AboveBand);
            let ratio = found.rms / noise;
            assert!(ratio > 0.94 && ratio < most, "{rate_hz} samples/s, play {half_gap}, noise {noise}: {ratio}");
        }
    }
}

#[test]
fn a_motion_that_creeps_to_another_level_is_no_slip_and_a_slip_there_is_one() {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data");
    let folder = env::var("ACTUATOR_DATA").unwrap_or_else(|_| beside.into());
    let path = Path::new(&folder).join("mts_servohydraulic/chirp_0A.csv");
    let Ok(file) = File::open(&path) else {
        println!("skipped: no measured record {} (set ACTUATOR_DATA)", path.display());
        return;
    };
    let columns: Columns = "time=t_s,command=cmd_mm,position=pos_mm".parse().unwrap();
    let format = Format { columns, unit: PositionUnit::Millimetre, ..Format::default() };
    let whole = Record::from_csv(Box::new(Hashed::new(file)), &path, &format).unwrap();
    // The last motion and the rest after it, during which the level settles within half a second.
    let last = whole.part(whole.len() * 7 / 10..whole.len()).unwrap();
    let (_, words) = without_sensor_faults(last.clone());
    assert!(words.iter().all(|word| !word.contains("slip")), "{words:?}");
    let place = 14_000;
    let slipped = last.position().iter().enumerate().map(|(n, value)| value + if n < place { 0.0 } else { 0.3 });
    let slipped = slipped.collect();
    let record = Record::new(last.to_command(), slipped, last.unit(), last.interpolation(), "slipped").unwrap();
    let (_, words) = without_sensor_faults(record);
    assert!(words.iter().any(|word| word.contains("slip")), "{words:?}");
}

#[test]
fn nothing_grave_is_said_of_measured_rigs() {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data");
    let folder = env::var("ACTUATOR_DATA").unwrap_or_else(|_| beside.into());
    let rigs = [
        ("mts_servohydraulic", PositionUnit::Millimetre, "mm"),
        ("bam_sts3250", PositionUnit::Radian, "rad"),
        ("bam_xl330", PositionUnit::Radian, "rad"),
    ];
    for (rig, unit, suffix) in rigs {
        let Ok(files) = Path::new(&folder).join(rig).read_dir() else {
            println!("skipped: no measured records in {folder}/{rig} (set ACTUATOR_DATA)");
            continue;
        };
        let paths = files.map(|file| file.unwrap().path());
        for path in paths.filter(|path| path.extension().is_some_and(|extension| extension == "csv")) {
            let columns: Columns = format!("time=t_s,command=cmd_{suffix},position=pos_{suffix}").parse().unwrap();
            let format = Format { columns, unit, ..Format::default() };
            let text = Box::new(Hashed::new(File::open(&path).unwrap()));
            let found = grave(&Record::from_csv(text, &path, &format).unwrap());
            assert!(found.is_empty(), "{}: {found:?}", path.display());
        }
    }
}
