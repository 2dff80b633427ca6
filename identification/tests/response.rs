//! Whether a position follows its command, for records whose truth is known: play, dead zones, loads, other clocks, sensors without sign.

use std::{f64::consts::TAU, io::Cursor, path::Path};

use super::inspect::{grave, record};
use identification::{
    inspect::{ExpectedGain, admit, compare_records, finding::Severity, inspect},
    signal::{
        Command, Interpolation,
        excitation::Kind,
        format::{Format, PositionUnit},
        record::Record,
        source::Hashed,
    },
};

/// A staircase through play as wide as several of its steps, and the same record delayed by two seconds.
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

/// Up and down between two levels, through play that absorbs most of it, through narrow play and without; the last one leads by 0.4 s.
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

/// Effect that may keep a position at rest between a few motions.
#[derive(Clone, Copy, Debug)]
enum Behind {
    Play,
    DeadZone,
}

/// Play or a dead zone and a lag for a motion of several frequencies, in an independent formulation, with phases that depend on one number.
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
fn a_record_that_is_no_response_tells_no_noise_of_another() {
    let healthy = record(0, Kind::Random, None);
    let dead = healthy.time().iter().map(|time| 0.1 * (1e4 * time * time).sin()).collect();
    let dead = Record::new(healthy.to_command(), dead, PositionUnit::Degree, Interpolation::Held, "dead").unwrap();
    let mut inspections = [inspect(&healthy), inspect(&dead)];
    let alone = inspections[0].noise;
    compare_records(&[&healthy, &dead], &mut inspections);
    assert_eq!(inspections[1].severity(), Severity::Refusal);
    assert_eq!(inspections[0].noise, alone);
    // A self-oscillating loop is reported where it moves far beyond its command.
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

/// A flexible linear model of a slow command may explain nine tenths of a slow random walk by chance.
#[test]
fn a_walk_that_is_no_response_vouches_for_no_other_record() {
    let random = record(0, Kind::Random, None);
    let walk = |number: u32| {
        let mut place = 0.0;
        let steps = (0..random.len()).map(|n| (1e4 * (n as f64 + 0.37 * f64::from(number)).powi(2)).sin());
        let own = steps.map(|step| {
            place += 0.1 * step;
            place
        });
        let own = own.collect();
        Record::new(random.to_command(), own, random.unit(), random.interpolation(), format!("walk {number}")).unwrap()
    };
    let walks: Vec<Record> = (0..40).map(walk).collect();
    let of_chance: Vec<&Record> = walks.iter().filter(|walk| inspect(walk).following_share >= 0.9).collect();
    assert!(!of_chance.is_empty());
    for walk in of_chance {
        assert_eq!(inspect(walk).severity(), Severity::Refusal, "{:?}", walk.source());
        assert!(admit(&[walk], ExpectedGain::Any).is_err(), "{:?}", walk.source());
    }
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
        found.len() == 1 && found[0].contains("before its command") && found[0].contains("different clocks"),
        "{found:?}"
    );
}

/// A load that moves a position half as far as its command does: if slow, it correlates with the command, and the sum leads the command.
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
