//! Diagnosis on records whose plant is known. The independent plant, with many more cases, is in `fmpy-tests/hidden`; here are the
//! laws: the meaning of verdicts, the nesting of candidates, no changes beyond those requested.

use std::{fs, process::Command, sync::Mutex};

use actuator_fmu::{
    effects::{Effects, find},
    parameters::{Model, Order, table},
};
use cli::{
    campaign::{self, Manifest},
    invocation::Invocation,
    report::campaign as report,
};
use identification::{
    diagnose::{self, Diagnosis, Verdict},
    estimate::{self, DelayChoice, Settings},
    generated::TestPoint,
    progress::Done,
    signal::{
        Command as Signal, Interpolation,
        excitation::{Excitation, Kind},
        record::Record,
    },
    simulate::simulate,
};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

const SEED: u64 = 1998;

fn base() -> Model {
    Model { order: Order::Second, ..Model::from_set(&table()[0]) }
}

fn with(name: &str, values: &[f64]) -> Model {
    let effects = Effects::default().with(find(name).unwrap(), values).unwrap();
    Model { effects, ..base() }
}

fn record(model: &Model, kind: Kind, amplitude: f64, seed: u64) -> Record {
    let excitation = Excitation { amplitude, seed, duration_s: 10.0, ..Excitation::new(kind) };
    let point = TestPoint {
        model: model.clone(),
        excitation,
        interpolation: Interpolation::Held,
        noise_share: 0.01,
        turbulence: None,
        seed,
    };
    point.record(kind.name()).unwrap()
}

/// A sweep and a random sequence half as large as fit records, a multisine as check record.
fn records(model: &Model) -> ([Record; 2], [Record; 1]) {
    let fit = [record(model, Kind::Sweep, 4.0, SEED), record(model, Kind::Random, 2.0, SEED + 1)];
    (fit, [record(model, Kind::Multisine, 3.0, SEED + 2)])
}

fn diagnosed(truth: &Model) -> Diagnosis {
    let (fit, check) = records(truth);
    diagnose::diagnose(&base(), &fit, &check, &[], None).unwrap()
}

#[test]
fn a_hidden_effect_is_named_with_its_strength() {
    for (name, values) in [("backlash", vec![0.2]), ("rate_limit", vec![120.0, 90.0])] {
        let diagnosis = diagnosed(&with(name, &values));
        assert_eq!(diagnosis.verdict, Verdict::Named, "{name}");
        let [finding] = diagnosis.findings.as_slice() else { panic!("{:?}", diagnosis.findings) };
        assert_eq!(finding.name, name);
        for (parameter, truth) in finding.parameters.iter().zip(&values) {
            let error = parameter.std_error.unwrap();
            assert!((parameter.value - truth).abs() < 5.0 * error && error < 0.05 * truth, "{parameter:?}");
        }
        assert!(diagnosis.misfit.is_noise());
    }
}

#[test]
fn nothing_is_named_where_nothing_is_missing_and_the_model_stays_as_it_was() {
    let diagnosis = diagnosed(&base());
    assert_eq!(diagnosis.verdict, Verdict::NothingMissing);
    assert!(diagnosis.findings.is_empty());
    assert_eq!(diagnosis.after, base());
}

#[test]
fn a_base_that_is_wrong_in_numbers_is_a_parameter_shift() {
    let set = &table()[0];
    let [k, p, omega, zeta] = set.base.values();
    let shifted = Model { base: actuator_fmu::parameters::Base::new(k, p, 0.92 * omega, zeta).unwrap(), ..base() };
    let diagnosis = diagnosed(&shifted);
    assert_eq!(diagnosis.verdict, Verdict::Named);
    assert_eq!(diagnosis.findings[0].name, "parameter_shift");
    assert!((diagnosis.after.base.omega() / (0.92 * omega) - 1.0).abs() < 0.01);
}

/// Near the given base a lag and a mode imitate it; once the base has the lag, nothing remains for the mode. The search removes the level of each
/// record; a record with a level relative to the packaged model is reported.
#[test]
#[ignore = "slow"]
fn a_base_that_is_a_factor_away_is_a_parameter_shift_alone() {
    let [k, p, omega, zeta] = base().base.values();
    let slow = Model { base: actuator_fmu::parameters::Base::new(k, p, 0.45 * omega, zeta).unwrap(), ..base() };
    let (fit, [check]) = records(&slow);
    let signal = Signal { time: check.time().to_vec(), command: check.command().to_vec() };
    let position = check.position().iter().map(|position| position + 0.5).collect();
    let check = Record::new(signal, position, check.unit(), check.interpolation(), "check.csv").unwrap();
    let diagnosis = diagnose::diagnose(&base(), &fit, &[check], &[], None).unwrap();
    let named: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.name).collect();
    assert_eq!(named, ["parameter_shift"]);
    assert!((diagnosis.after.base.omega() / (0.45 * omega) - 1.0).abs() < 0.01, "{:?}", diagnosis.after.base);
    let levels: Vec<&String> = diagnosis.notes.iter().filter(|note| note.contains("has a level of")).collect();
    let [note] = levels.as_slice() else { panic!("{:?}", diagnosis.notes) };
    assert!(note.starts_with("check.csv has a level of 0.500 deg"), "{note}");
}

#[test]
fn a_pole_that_the_given_model_does_not_have_is_no_delay() {
    let [k, p, omega, zeta] = base().base.values();
    let of = |p: f64| Model {
        base: actuator_fmu::parameters::Base::new(k, p, omega, zeta).unwrap(),
        order: Order::Third,
        ..base()
    };
    let (fit, check) = records(&of(6.0 * omega));
    // As after a fit that does not determine the pole.
    let unseen = of(500.0 * omega);
    let diagnosis = diagnose::diagnose(&unseen, &fit, &check, &[], None).unwrap();
    let named: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.name).collect();
    assert_eq!(named, ["parameter_shift"]);
    assert!((diagnosis.after.base.p() / (6.0 * omega) - 1.0).abs() < 0.1, "{p} {:?}", diagnosis.after.base);
}

#[test]
#[ignore = "slow"]
fn a_limit_is_found_though_the_given_base_is_a_factor_away() {
    let truth = with("rate_limit", &[60.0, 60.0]);
    let (fit, check) = records(&truth);
    let [k, p, omega, _] = base().base.values();
    let slow = Model { base: actuator_fmu::parameters::Base::new(k, p, omega / 4.0, 1.5).unwrap(), ..base() };
    let diagnosis = diagnose::diagnose(&slow, &fit, &check, &[], None).unwrap();
    assert_eq!(diagnosis.findings.first().map(|finding| finding.family), Some("limit"), "{:?}", diagnosis.leads);
    assert!((diagnosis.after.base.omega() / omega - 1.0).abs() < 0.05, "{:?}", diagnosis.after.base);
}

/// A record with much motion that ends with one slow rise to a stop; most of the information of a long record is in the parts that are searched first.
#[test]
fn a_stop_that_parts_of_a_long_record_do_not_reach_is_found() {
    let truth = with("position_limit", &[-2.5, 2.5]);
    let long = |seed: u64, noise_seed: u64| {
        let lively = record(&truth, Kind::Random, 1.0, seed);
        let interval = lively.sampling().interval_s();
        let mut command: Vec<f64> = (0..5).flat_map(|_| lively.command().to_vec()).collect();
        command.extend((0..4000_i32).map(|n| 3.5 * (std::f64::consts::PI * f64::from(n) / 4000.0).sin()));
        let time: Vec<f64> = (0..command.len()).map(|n| interval * n as f64).collect();
        let command = Signal { time, command };
        let mut position = simulate(&truth, &command, Interpolation::Held).unwrap().position;
        let mut noise = ChaCha8Rng::seed_from_u64(noise_seed);
        position.iter_mut().for_each(|value| *value += 0.01 * (noise.random::<f64>() - 0.5));
        let unit = lively.unit();
        Record::new(command, position, unit, Interpolation::Held, format!("long {seed}")).unwrap()
    };
    let diagnosis = diagnose::diagnose(&base(), &[long(1, 2), long(3, 4)], &[long(5, 6)], &[], None).unwrap();
    let named: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.name).collect();
    assert_eq!(named, ["position_limit"], "{:?}", diagnosis.verdict);
    let highest = diagnosis.findings[0].parameters.iter().find(|parameter| parameter.name == "max").unwrap();
    assert!((highest.value / 2.5 - 1.0).abs() < 0.01, "{highest:?}");
}

/// A record whose measured position is too large.
fn raised(record: &Record, by: f64) -> Record {
    let position = record.position().iter().map(|value| value + by).collect();
    Record::new(record.to_command(), position, record.unit(), record.interpolation(), record.source()).unwrap()
}

#[test]
fn a_bias_of_the_sensor_is_the_same_in_all_records() {
    let (fit, check) = records(&base());
    let named = |levels: [f64; 3]| {
        let fit = [raised(&fit[0], levels[0]), raised(&fit[1], levels[1])];
        let check = [raised(&check[0], levels[2])];
        let diagnosis = diagnose::diagnose(&base(), &fit, &check, &[], None).unwrap();
        diagnosis.findings.iter().map(|finding| finding.name).collect::<Vec<&str>>()
    };
    assert_eq!(named([0.3, 0.3, 0.3]), ["sensor_bias"]);
    // From a reference that was reset before each record.
    assert!(!named([0.3, -0.25, 0.1]).contains(&"sensor_bias"));
}

#[test]
fn what_would_have_been_seen_is_said_and_would_have_been() {
    let diagnosis = diagnosed(&base());
    let gap = diagnosis.detectable.iter().find(|effect| effect.name == "backlash").unwrap();
    assert!(gap.value > 0.001 && gap.value < 0.1, "{gap:?}");
    let stronger = diagnosed(&with("backlash", &[2.0 * gap.value]));
    assert_ne!(stronger.verdict, Verdict::NothingMissing);
}

#[test]
#[ignore = "slow"]
fn a_limit_that_only_the_check_record_reaches_is_a_suspicion_with_its_size() {
    let truth = with("rate_limit", &[60.0, 60.0]);
    let fit = [record(&truth, Kind::Sweep, 0.4, SEED), record(&truth, Kind::Random, 0.3, SEED + 1)];
    let check = [record(&truth, Kind::Multisine, 3.0, SEED + 2)];
    let diagnosis = diagnose::diagnose(&base(), &fit, &check, &[], None).unwrap();
    assert_eq!(diagnosis.verdict, Verdict::Unexplained);
    let lead = &diagnosis.leads[0];
    assert!(lead.name.contains("rate_limit") && lead.why_not.contains("check record"), "{lead:?}");
    assert!((lead.parameters["up"] / 60.0 - 1.0).abs() < 0.1, "{lead:?}");
}

#[test]
fn every_candidate_nests_the_base() {
    let diagnosis = diagnosed(&with("backlash", &[0.2]));
    let of = |name: &str| diagnosis.candidates.iter().find(|candidate| candidate.name == name).unwrap();
    let base = of("parameter_shift").fit_rms.max(of("none").fit_rms);
    assert!(
        diagnosis.candidates.iter().all(|candidate| candidate.fit_rms < 1.001 * base),
        "{:?}",
        diagnosis.candidates
    );
    // All but the given model, which is not fitted, were searched.
    assert!(diagnosis.searches >= diagnosis.candidates.len() as u64 - 1, "{}", diagnosis.searches);
}

/// A law of counts, not of times: a large part of all simulations lies between the shares 0.2 and 0.9.
#[test]
fn a_search_says_what_share_of_it_is_done() {
    for truth in [with("backlash", &[0.2]), with("rate_limit", &[120.0, 90.0]), base()] {
        let (fit, check) = records(&truth);
        let heard: Mutex<Vec<Done>> = Mutex::default();
        let hear = |done: Done| heard.lock().unwrap().push(done);
        let said = diagnose::diagnose_reporting(&base(), &fit, &check, &[], None, Some(&hear)).unwrap();
        assert_eq!(said.after, diagnosed(&truth).after);
        let heard = heard.into_inner().unwrap();
        assert_rises_to_one(&heard);
        let between = heard.windows(2).filter(|pair| (0.2..0.9).contains(&pair[0].share));
        let samples: u64 = between.map(|pair| pair[1].samples - pair[0].samples).sum();
        let all = heard.last().unwrap().samples;
        assert!(samples > all / 4, "{samples} of {all}");
    }
}

#[test]
fn a_fit_says_what_share_of_it_is_done() {
    let (fit, _) = records(&base());
    for delay in [DelayChoice::Declared(0.0), DelayChoice::Free] {
        let settings = Settings { delay, ..Settings::default() };
        let heard: Mutex<Vec<Done>> = Mutex::default();
        let hear = |done: Done| heard.lock().unwrap().push(done);
        let found = estimate::fit_reporting(&fit, &settings, Some(&hear)).unwrap();
        assert_eq!(found.model, estimate::fit(&fit, &settings).unwrap().model);
        assert_rises_to_one(&heard.into_inner().unwrap());
    }
}

fn assert_rises_to_one(heard: &[Done]) {
    assert!(heard.len() > 20, "{heard:?}");
    assert!(heard[0].share < 0.1 && heard.last().unwrap().share == 1.0, "{heard:?}");
    for pair in heard.windows(2) {
        assert!(pair[0].share < pair[1].share && pair[0].samples <= pair[1].samples, "{pair:?}");
    }
}

#[test]
fn without_check_records_a_part_is_held_out_and_said() {
    let truth = base();
    let (fit, _) = records(&truth);
    let several = diagnose::divide(fit.to_vec(), Vec::new()).unwrap();
    assert_eq!((several.fit.len(), several.check.len()), (1, 1));
    assert!(several.note.unwrap().contains("held out"));
    let single = diagnose::divide(fit[..1].to_vec(), Vec::new()).unwrap();
    assert_eq!(single.fit[0].len() + single.check[0].len(), fit[0].len());
}

#[test]
#[ignore = "slow"]
fn a_command_that_is_held_though_linear_was_said_is_no_delay() {
    let folder = tempfile::tempdir().unwrap();
    let (fit, check) = records(&with("backlash", &[0.2]));
    for (name, record) in [("sweep.csv", &fit[0]), ("random.csv", &fit[1]), ("check.csv", &check[0])] {
        record.write_csv(std::fs::File::create(folder.path().join(name)).unwrap()).unwrap();
    }
    std::fs::write(folder.path().join("model.toml"), base().to_toml().unwrap()).unwrap();
    let arguments = ["--model", "model.toml", "--fit", "sweep.csv", "random.csv", "--check", "check.csv", "--linear"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_actuator"));
    command.current_dir(folder.path()).arg("diagnose").args(arguments).args(["-o", "out", "--json"]);
    let done = command.output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    let names: Vec<&str> =
        json["effects"].as_array().unwrap().iter().map(|effect| effect["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["backlash"]);
    assert!(json["warnings"].to_string().contains("leave --linear out"), "{}", json["warnings"]);
}

#[test]
fn the_command_writes_its_files_once_and_refuses_bad_records() {
    let folder = tempfile::tempdir().unwrap();
    let truth = with("backlash", &[0.2]);
    let (fit, check) = records(&truth);
    for (name, record) in [("sweep.csv", &fit[0]), ("check.csv", &check[0])] {
        record.write_csv(std::fs::File::create(folder.path().join(name)).unwrap()).unwrap();
    }
    std::fs::write(folder.path().join("bad.csv"), "time,command,position\n0,0,0\n0.1,NaN,0\n").unwrap();
    let run = |records: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_actuator"));
        command.current_dir(folder.path()).args(["diagnose", "--model", "te-early-unloaded", "-o", "out", "--fit"]);
        command.args(records).output().unwrap()
    };
    let refused = run(&["bad.csv", "--check", "check.csv"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("bad.csv:3"));
    assert!(!folder.path().join("out").exists());
    let done = run(&["sweep.csv", "--check", "check.csv"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(String::from_utf8_lossy(&done.stdout).contains("backlash"));
    let text = std::fs::read_to_string(folder.path().join("out/diagnosis.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["effects"][0]["name"], "backlash");
    assert_eq!(
        (&json["records"][0]["name"], &json["records"][0]["warnings"]),
        (&"sweep.csv".into(), &serde_json::json!([]))
    );
    assert!(json["gap"]["closed"].as_f64().unwrap() > 0.9);
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(!page.contains("src=") && !page.contains("href=") && !page.contains("<script "), "it opens offline");
    assert!(folder.path().join("out/model.fmu").exists() && folder.path().join("out/model.toml").exists());
    let again = run(&["sweep.csv", "--check", "check.csv"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&again.stderr).contains("--force"));
}

#[test]
fn a_campaign_says_which_of_its_models_misses_what() {
    let folder = tempfile::tempdir().unwrap();
    let mut manifest = String::new();
    for (stage, truth) in [("early", base()), ("late", with("backlash", &[0.2]))] {
        let (fit, check) = records(&truth);
        for (number, record) in fit.iter().chain(&check).enumerate() {
            let name = format!("{stage}-{number}.csv");
            record.write_csv(fs::File::create(folder.path().join(&name)).unwrap()).unwrap();
            manifest += &format!(
                "[[record]]\nfile = \"{name}\"\nsurface = \"bench\"\nstage = \"{stage}\"\nload_case = \"unloaded\"\n"
            );
        }
    }
    let path = folder.path().join("manifest.toml");
    fs::write(&path, manifest).unwrap();
    let run = || {
        let options = campaign::Options { force: false, diagnose: true };
        campaign::run(
            &Manifest::read(&path).unwrap(),
            &folder.path().join("results"),
            options,
            &Invocation::default(),
            &|_, _| {},
        )
        .unwrap()
    };
    let found = run();
    let [early, late] = found.conditions.as_slice() else { panic!("{:?}", found.conditions) };
    assert_eq!(early.missing.as_ref().unwrap().verdict, Verdict::NothingMissing, "{early:?}");
    let missing = late.missing.as_ref().unwrap();
    assert_eq!((missing.verdict, missing.records), (Verdict::Named, 3), "{missing:?} {:?}", late.result);
    assert_eq!(missing.effects[0].name, "backlash");
    assert!((missing.effects[0].parameters[0].value - 0.2).abs() < 0.01, "{missing:?}");
    let text = report::text(&found);
    assert!(
        text.contains("1 of 2 conditions") && text.contains("bench-late-unloaded: named: backlash (backlash width 0."),
        "{text}"
    );
    assert!(report::html(&found, &[], &Invocation::default()).contains("What the models miss"));
    assert_eq!(run().conditions, found.conditions, "taken over from the first run");
}
