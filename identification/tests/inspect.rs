//! What is said of records whose truth is known: nothing grave of healthy ones, generated or measured.

use std::{env, f64::consts::TAU, fs::File, io::Cursor, path::Path};

use actuator_fmu::{
    effects::{Effects, find},
    parameters::{Model, table},
};
use identification::{
    generated::TestPoint,
    inspect::{ExpectedGain, admit, compare_records, finding::Severity, inspect, noise::Source, without_sensor_faults},
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
fn record(set: usize, kind: Kind, effect: Option<(&str, &[f64])>) -> Record {
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

/// Findings that are no notes.
fn grave(record: &Record) -> Vec<String> {
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
    // As much motion as the command has, that is another's.
    let crossed = Record::new(
        stuck.to_command(),
        record(3, Kind::Sweep, None).position().to_vec(),
        PositionUnit::default(),
        Interpolation::Held,
        "crossed",
    );
    assert!(admit(&[&crossed.unwrap(), &follows], ExpectedGain::Any).is_err());
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

/// A staircase behind play as wide as several of its steps, and the same record two seconds late.
#[test]
fn wide_play_in_steps_is_no_other_clock_and_two_seconds_are() {
    const GAP: f64 = 5.0;
    let command: Vec<f64> = (0..4000_i32).map(|n| 1.5 * f64::from(((n / 50) % 12 - 6).abs() - 3)).collect();
    let mut position = command[0];
    let behind_play = command.iter().zip((0..4000).map(|n| (0.37 * f64::from(n * n % 1009)).sin()));
    let measured: Vec<f64> = behind_play
        .map(|(command, noise)| {
            position = position.clamp(command - 0.5 * GAP, command + 0.5 * GAP);
            position + 0.01 * noise
        })
        .collect();
    let of = |position: Vec<f64>| {
        let command = Command { time: (0..4000).map(|n| 0.01 * f64::from(n)).collect(), command: command.clone() };
        Record::new(command, position, PositionUnit::default(), Interpolation::Held, "made").unwrap()
    };
    let is_late = |record: &Record| inspect(record).findings.iter().any(|finding| finding.text().contains(" late,"));
    assert!(!is_late(&of(measured.clone())));
    let sweep = record(0, Kind::Sweep, None);
    let late: Vec<f64> = (0..sweep.len()).map(|n| sweep.position()[n.saturating_sub(400)]).collect();
    let late = Record::new(sweep.to_command(), late, sweep.unit(), sweep.interpolation(), "late").unwrap();
    assert!(is_late(&late), "{:?}", grave(&late));
}

/// Up and down between two levels, behind a play that swallows most of it, behind a narrow one and without; the last 0.4 s ahead.
#[test]
fn wide_play_between_two_levels_is_no_lead_and_another_clock_is() {
    const COUNT: usize = 1600;
    const AHEAD: usize = 80;
    let level = |time: f64| match time {
        ..1.9 => -16.0 * time,
        ..2.9 => -30.4,
        ..4.8 => -30.4 + 16.0 * (time - 2.9),
        ..5.8 => 0.0,
        _ => -16.0 * (time - 5.8),
    };
    let time: Vec<f64> = (0..COUNT + AHEAD).map(|n| 0.005 * n as f64).collect();
    let command: Vec<f64> = time.iter().map(|time| level(*time)).collect();
    let position = |half_gap: f64| -> Vec<f64> {
        let (mut held, mut position) = (0.0, 0.0);
        let of = |(n, command): (usize, &f64)| {
            held = f64::max(held, command - half_gap).min(command + half_gap);
            position += 0.05 * (held - position);
            position + 0.1 * (0.37 * (n * n % 1009) as f64).sin()
        };
        command.iter().enumerate().map(of).collect()
    };
    let leads = |position: &[f64]| {
        let command = Command { time: time[..COUNT].to_vec(), command: command[..COUNT].to_vec() };
        let record =
            Record::new(command, position.to_vec(), PositionUnit::Degree, Interpolation::Held, "made").unwrap();
        inspect(&record).findings.iter().any(|finding| finding.text().contains("leads its command"))
    };
    for half_gap in [12.0, 2.0, 0.0] {
        assert!(!leads(&position(half_gap)[..COUNT]), "{half_gap}");
    }
    assert!(leads(&position(0.0)[AHEAD..]));
}

/// What a position may stand still in between a few motions.
#[derive(Clone, Copy, Debug)]
enum Behind {
    Play,
    DeadZone,
}

/// A play or a dead zone and a lag behind a motion of several frequencies, in a formulation of this test's own, with the phases of one number.
fn hanging(behind: Behind, number: f64) -> (Command, Vec<f64>) {
    const INTERVAL_S: f64 = 0.005;
    const LAG_S: f64 = 0.03;
    const DEAD_ZONE: f64 = 0.65; // of the command's peak
    let motion = |time: f64| -> f64 {
        let phase = |place: f64| number * place * place;
        let waves = match behind {
            Behind::Play => [0.31, 0.47, 0.83, 1.13, 1.61, 1.97],
            Behind::DeadZone => [0.155, 0.235, 0.415, 0.565, 0.805, 0.985],
        };
        let waves = waves.map(|hz| (TAU * hz * time + phase(TAU * hz)).sin());
        time.min(1.0) * waves.iter().sum::<f64>() // from rest
    };
    let time: Vec<f64> = (0..3000).map(|n| f64::from(n) * INTERVAL_S).collect();
    let command: Vec<f64> = time.iter().map(|time| motion(*time)).collect();
    let peak = command.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let (half_gap, half_width) = (0.75 * peak, DEAD_ZONE * peak);
    let (mut held, mut position) = (0.0, 0.0);
    let positions = command.iter().map(|value| {
        held = match behind {
            Behind::Play => f64::max(held, value - half_gap).min(value + half_gap),
            Behind::DeadZone => value.signum() * (value.abs() - half_width).max(0.0),
        };
        position += (held - position) * (1.0 - (-INTERVAL_S / LAG_S).exp());
        position
    });
    let positions = positions.collect();
    (Command { time, command }, positions)
}

#[test]
fn a_position_that_hangs_in_a_wide_play_or_dead_zone_follows_its_command() {
    let record = |command: Command, position| {
        Record::new(command, position, PositionUnit::Degree, Interpolation::Held, "hanging").unwrap()
    };
    let cases = [1.0, 2.0, 3.0].map(|number| (Behind::Play, number)).into_iter();
    for (behind, number) in cases.chain([2.0, 3.0, 4.0, 5.0, 6.0].map(|number| (Behind::DeadZone, number))) {
        let ((command, position), (_, other)) = (hanging(behind, number), hanging(behind, number + 0.5));
        let own = record(Command { time: command.time.clone(), command: command.command.clone() }, position);
        assert_ne!(inspect(&own).severity(), Severity::Refusal, "{behind:?} {number}: {:?}", grave(&own));
        let unrelated = record(command, other);
        assert_eq!(inspect(&unrelated).severity(), Severity::Refusal, "{behind:?} {number}: {:?}", grave(&unrelated));
    }
}

#[test]
fn a_position_that_is_its_command_is_refused() {
    let sweep = record(0, Kind::Sweep, None);
    let command = sweep.to_command();
    let copied = command.command.clone();
    let copy = Record::new(command, copied, sweep.unit(), sweep.interpolation(), "copy").unwrap();
    let inspection = inspect(&copy);
    assert_eq!(inspection.severity(), Severity::Refusal);
    assert!(inspection.findings.iter().any(|finding| finding.kind == "position_is_command"));
}

/// A rectified response, and that of another command.
#[test]
fn a_position_without_sign_is_refused_as_one() {
    let sweep = record(0, Kind::Sweep, None);
    let refused = |positions: &[f64]| {
        let without_sign = positions.iter().map(|position| position.abs()).collect();
        let own =
            Record::new(sweep.to_command(), without_sign, sweep.unit(), sweep.interpolation(), "unsigned").unwrap();
        let findings = inspect(&own).findings;
        findings.into_iter().find(|finding| finding.severity == Severity::Refusal).map(|finding| finding.kind)
    };
    assert_eq!(refused(sweep.position()), Some("unsigned"));
    let mut backwards = sweep.position().to_vec();
    backwards.reverse();
    assert_eq!(refused(&backwards), Some("no_response"));
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

#[test]
fn a_record_that_is_no_response_tells_no_noise_of_another() {
    let healthy = record(0, Kind::Random, None);
    let dead = healthy.time().iter().map(|time| 0.1 * (1e4 * time * time).sin()).collect();
    let dead = Record::new(healthy.to_command(), dead, PositionUnit::Degree, Interpolation::Held, "dead").unwrap();
    let mut inspections = [inspect(&healthy), inspect(&dead)];
    let alone = inspections[0].noise;
    compare_records(&[&healthy, &dead], &mut inspections);
    assert_eq!(inspections[1].severity(), Severity::Refusal);
    assert_eq!(inspections[0].noise, alone);
    // A loop that oscillates by itself is said to where it goes far beyond its command.
    let range = |values: &[f64]| values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let remedies = [0.5, 10.0].map(|times: f64| {
        let swing = times * range(healthy.command());
        let own = healthy.time().iter().map(|time| swing * (TAU * 1.7 * time).sin()).collect();
        let own = Record::new(healthy.to_command(), own, PositionUnit::Degree, Interpolation::Held, "own").unwrap();
        grave(&own).concat()
    });
    assert!(remedies[0].contains("does not follow") && !remedies[0].contains("by itself"), "{remedies:?}");
    assert!(remedies[1].contains("does not follow") && remedies[1].contains("oscillates by itself"), "{remedies:?}");
}

#[test]
fn a_position_written_with_the_next_command_is_said() {
    let healthy = record(0, Kind::Steps, None);
    let count = healthy.len();
    let early = Record::new(
        Command { time: healthy.time()[..count - 2].to_vec(), command: healthy.command()[..count - 2].to_vec() },
        healthy.position()[2..].to_vec(),
        PositionUnit::Degree,
        Interpolation::Held,
        "early",
    );
    let found = grave(&early.unwrap());
    assert!(
        found.len() == 1 && found[0].contains("before its command does") && found[0].contains("one clock"),
        "{found:?}"
    );
}

/// A load that moves a position half as far as its command does: of slow signals it correlates with the command, and the sum leads that.
#[test]
fn a_load_is_no_lead() {
    const LAG_S: f64 = 0.01;
    let sine = |hz: f64, phase: f64| move |t: f64| (TAU * hz * t + phase).sin();
    let command = |t: f64| 4.0 / TAU * 2.0 * sine(0.2, 0.0)(t).asin();
    let load = |t: f64| sine(0.13, 1.2)(t) + 0.5 * sine(0.31, 1.0)(t);
    let text = |with_load: bool| {
        let rows = (0..3000).map(|n| f64::from(n) / 200.0).map(|t| {
            let position = command(t - LAG_S) + 1.5 * load(t) + 0.01 * sine(61.0, 0.0)(t);
            let row = format!("{t},{},{position}", command(t));
            if with_load { format!("{row},{}\n", load(t)) } else { row + "\n" }
        });
        let head = if with_load { "time,command,position,load\n" } else { "time,command,position\n" };
        head.to_owned() + &rows.collect::<String>()
    };
    let read = |text: String| {
        let text = Box::new(Hashed::new(Cursor::new(text.into_bytes())));
        inspect(&Record::from_csv(text, Path::new("loaded.csv"), &Format::default()).unwrap())
    };
    let (hidden, said) = (read(text(false)), read(text(true)));
    assert!(hidden.findings.iter().any(|finding| finding.kind == "lead"), "{:?}", hidden.findings);
    assert_eq!(said.severity(), Severity::Note, "{:?}", said.findings);
    assert!(
        (said.lag_s - LAG_S).abs() < 0.5 * LAG_S && said.following_share > 0.99,
        "{} {}",
        said.lag_s,
        said.following_share
    );
}

/// Of a servo of second order (7 Hz) at so many samples/s, by small steps of it, with noise; a play stands behind it.
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
    // The last motion and the rest behind it, to which the level creeps within half a second.
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
