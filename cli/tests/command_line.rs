//! `actuator` from the user's point of view.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

fn actuator(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_actuator")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn every_command_helps_with_an_example() {
    let folder = tempfile::tempdir().unwrap();
    for command in [
        "sets",
        "effects",
        "build",
        "simulate",
        "excite",
        "export",
        "inspect",
        "frf",
        "fit",
        "compare",
        "campaign",
        "generate-campaign",
        "diagnose",
        "demo",
        "schema",
        "completions",
        "man",
        "render",
    ] {
        let output = actuator(folder.path(), &[command, "--help"]);
        assert!(output.status.success());
        assert!(text(&output.stdout).contains("Example"), "{command}");
    }
}

#[test]
fn the_help_names_both_kinds_of_unit() {
    let help = text(&actuator(Path::new("."), &["--help"]).stdout);
    assert!(help.starts_with("Measured actuators as FMI 2.0 units, for co-simulation and model exchange\n"), "{help}");
}

#[test]
fn sets_lists_seventeen_as_text_and_as_json() {
    let folder = tempfile::tempdir().unwrap();
    let plain = text(&actuator(folder.path(), &["sets"]).stdout);
    let sets: serde_json::Value = serde_json::from_slice(&actuator(folder.path(), &["sets", "--json"]).stdout).unwrap();
    assert_eq!(sets.as_array().unwrap().len(), 17);
    for set in sets.as_array().unwrap() {
        assert!(plain.contains(set["name"].as_str().unwrap()));
    }
    assert_eq!(sets[14]["p"]["value"], 2.97e8);
}

#[test]
fn simulate_writes_once_and_refuses_bad_input_with_code_two() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("command.csv"), "time,command\n0,1\n0.005,1\n0.01,1\n").unwrap();
    let run =
        |more: &[&str]| actuator(folder.path(), &[&["simulate", "te-early-unloaded", "command.csv"], more].concat());
    assert!(run(&["-o", "out.csv"]).status.success());
    let written = fs::read_to_string(folder.path().join("out.csv")).unwrap();
    assert!(written.starts_with("time,command,position,deflection,rate\n0,1,0,0,0\n"), "{written}");
    assert_eq!(text(&run(&[]).stdout), written);
    let again = run(&["-o", "out.csv"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("--force"));
    assert!(run(&["-o", "out.csv", "--force"]).status.success());

    // Times of a record in milliseconds.
    let rows: String = (0..300).map(|n| format!("{},{}\n", 5 * n, n % 7)).collect();
    fs::write(folder.path().join("command.csv"), format!("t_ms,command\n{rows}")).unwrap();
    let named = ["--columns", "time=t_ms", "-o", "ms.csv", "--force"];
    let said = run(&named);
    assert!(said.status.success() && text(&said.stdout).contains("--time-unit ms"), "{}", text(&said.stdout));
    let said = run(&[&named[..], &["--time-unit", "ms"]].concat());
    assert!(text(&said.stdout).starts_with("300 samples over 1.495 s; peak"), "{}", text(&said.stdout));
    assert!(!text(&said.stdout).contains("comes to rest"));

    fs::write(folder.path().join("command.csv"), "time,command\n0,1\n0.005,nonsense\n").unwrap();
    let bad = run(&["-o", "other.csv"]);
    assert_eq!(bad.status.code(), Some(2));
    assert!(text(&bad.stderr).contains("command.csv:3"));
    assert!(!folder.path().join("other.csv").exists());
    assert_eq!(actuator(folder.path(), &["simulate", "no-such-set", "command.csv"]).status.code(), Some(2));
}

#[test]
fn what_is_in_the_way_of_an_output_is_found_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| actuator(folder.path(), arguments);
    assert!(run(&["excite", "sweep", "-o", "sweep.csv"]).status.success());
    assert!(run(&["simulate", "us-late-loaded", "sweep.csv", "-o", "record.csv"]).status.success());
    let one = run(&["fit", "record.csv", "-o", "same", "--report", "same"]);
    assert!(one.status.code() == Some(2) && text(&one.stderr).contains("one file for the model and the page"));
    assert!(!folder.path().join("same").exists());
    let page = folder.path().join("story/diagnosis/report.html");
    fs::create_dir_all(page.parent().unwrap()).unwrap();
    fs::write(&page, "of another run").unwrap();
    assert_eq!(run(&["demo", "-o", "story"]).status.code(), Some(2));
    assert_eq!(fs::read_dir(folder.path().join("story")).unwrap().count(), 1);
}

#[cfg(target_os = "linux")]
#[test]
fn an_exit_code_is_that_of_the_run_where_standard_error_cannot_be_written_to() {
    let folder = tempfile::tempdir().unwrap();
    let code = |arguments: &[&str]| {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_actuator"));
        program.current_dir(folder.path()).args(arguments).stdout(std::process::Stdio::null()).stderr(full);
        program.status().unwrap().code()
    };
    assert_eq!(code(&["excite", "sweep"]), Some(0));
    assert_eq!(code(&["simulate", "no-such-set", "command.csv"]), Some(2));
}

#[test]
fn a_file_where_a_folder_is_to_be_is_refused_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), "kept").unwrap();
    // Missing records and models are not even searched for.
    for arguments in [
        &["diagnose", "--model", "none.toml", "--fit", "none.csv", "-o"][..],
        &["inspect", "none.csv", "-o"],
        &["compare", "none.toml", "-o"],
        &["campaign", "none.toml", "-o"],
        &["generate-campaign", "-o"],
        &["demo", "-o"],
        &["sets", "--ssv"],
    ] {
        for output in ["m.toml", "m.toml/within"] {
            let refused = actuator(folder.path(), &[arguments, &[output]].concat());
            assert_eq!((refused.status.code(), text(&refused.stdout)), (Some(2), String::new()), "{arguments:?}");
            let message = text(&refused.stderr);
            assert!(message.contains("m.toml: output folder: found a file; allowed: a folder"), "{message}");
        }
    }
    assert_eq!(fs::read(folder.path().join("m.toml")).unwrap(), b"kept");
}

#[test]
fn an_fmu_that_is_not_there_is_named_once_with_the_cause() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("command.csv"), "time,command\n0,1\n0.005,1\n").unwrap();
    for arguments in [
        &["simulate", "us-late-loaded", "command.csv", "--fmu", "none.fmu"][..],
        &["build", "--model", "us-late-loaded", "--from", "none.fmu"],
    ] {
        let refused = actuator(folder.path(), arguments);
        assert_eq!(refused.status.code(), Some(2));
        let message = text(&refused.stderr);
        assert!(
            message.starts_with("actuator: none.fmu: FMU: found ") && !message.contains("cannot read"),
            "{message}"
        );
        assert_eq!(message.matches("none.fmu").count(), 1, "{message}");
    }
}

#[test]
fn a_time_limit_below_zero_is_refused_with_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    for limit in ["-1", "-0.5", "soon"] {
        let refused =
            actuator(folder.path(), &["diagnose", "--model", "m", "--fit", "r.csv", "-o", "d", "--time-limit", limit]);
        assert_eq!(refused.status.code(), Some(2));
        let message = text(&refused.stderr);
        assert!(message.contains(&format!("'{limit}'")) && message.contains("seconds from 0 on"), "{message}");
    }
}

#[test]
fn an_export_points_to_a_measurement_only_where_there_is_one() {
    let folder = tempfile::tempdir().unwrap();
    // One folder for all of them.
    for (target, ending, hint) in [
        ("c", ".c", true),
        ("jsbsim", "-jsbsim.xml", true),
        ("mujoco", "-mujoco.xml", true),
        ("modelica", ".mo", false),
    ] {
        let said = text(&actuator(folder.path(), &["export", "us-late-loaded", "--to", target]).stdout);
        let written = fs::read_to_string(folder.path().join(format!("us-late-loaded{ending}"))).unwrap();
        for text in [said, written] {
            assert!(text.contains("not measured") && text.contains("(actuator export") == hint, "{target}: {text}");
        }
    }
}

#[test]
fn compare_prints_numbers_and_statements_and_writes_its_folder_once() {
    let folder = tempfile::tempdir().unwrap();
    let plain = text(&actuator(folder.path(), &["compare"]).stdout);
    for part in ["7.82", "5.68", "0.432", "14.00", "contradicted", "no significant impact"] {
        assert!(plain.contains(part), "{part}");
    }
    let json: serde_json::Value =
        serde_json::from_slice(&actuator(folder.path(), &["compare", "--json", "-o", "out"]).stdout).unwrap();
    assert_eq!(json["load"].as_array().unwrap().len(), 8);
    let written: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("out/compare.json")).unwrap()).unwrap();
    assert_eq!(written, json);
    let again = actuator(folder.path(), &["compare", "-o", "out"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("--force"));
    assert!(actuator(folder.path(), &["compare", "-o", "out", "--force"]).status.success());
    let nowhere = actuator(folder.path(), &["compare", "us-late-loaded", "nowhere.toml"]);
    assert!(text(&nowhere.stderr).contains("nowhere.toml: model file: found no such file"));
    let one = actuator(folder.path(), &["compare", "us-late-loaded", "-o", "one"]);
    assert_eq!((one.status.code(), folder.path().join("one").exists()), (Some(2), false));
    assert!(text(&one.stderr).contains("found one, `us-late-loaded`; allowed: two or more"), "{}", text(&one.stderr));
}

#[test]
fn a_campaign_is_generated_run_and_taken_over() {
    let folder = tempfile::tempdir().unwrap();
    let generate = |more: &[&str]| {
        actuator(
            folder.path(),
            &[&["generate-campaign", "-o", "bact", "--seed", "3", "--duration", "25"], more].concat(),
        )
    };
    assert!(text(&generate(&[]).stdout).contains("34 records, seed 3"));
    let again = generate(&[]);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("--force"));
    assert_eq!(generate(&["--noise", "-1", "--force"]).status.code(), Some(2));

    // Two conditions are sufficient here.
    let manifest = folder.path().join("bact/manifest.toml");
    let whole = fs::read_to_string(&manifest).unwrap();
    let few: Vec<&str> = whole.split("\n[[record]]").take(5).collect();
    fs::write(&manifest, few.join("\n[[record]]")).unwrap();
    let run = || actuator(folder.path(), &["campaign", "bact/manifest.toml", "-o", "results", "--json"]);
    let reused = |output: &Output| -> Vec<bool> {
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        json["records"].as_array().unwrap().iter().map(|record| record["reused"].as_bool().unwrap()).collect()
    };
    let first = run();
    assert!(first.status.success() && first.stderr.is_empty(), "{}", text(&first.stderr));
    assert_eq!(reused(&first), [false; 4]);
    assert_eq!(reused(&run()), [true; 4]);
    for name in
        ["report.html", "campaign.json", "models/te-early-unloaded.toml", "records/te-early-unloaded-sweep.json"]
    {
        assert!(folder.path().join("results").join(name).exists(), "{name}");
    }
    let model = "te-early-unloaded=results/models/te-early-unloaded.toml";
    let compared = actuator(folder.path(), &["compare", "te-early-unloaded", model]);
    assert!(text(&compared.stdout).contains("0 of 1 exceed"), "{}", text(&compared.stderr));

    fs::write(&manifest, "[[record]]\nfile = \"none.csv\"\nsurface = \"a\"\nstage = \"b\"\nload_case = \"loaded\"\n")
        .unwrap();
    let none = actuator(folder.path(), &["campaign", "bact/manifest.toml", "-o", "other"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(text(&none.stdout).contains("none.csv") && text(&none.stdout).contains("1 failed"));
}

#[test]
fn the_program_alone_in_a_folder_takes_the_fmu_beside_it_and_says_what_to_do_without() {
    let checkout = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let default = fmu_build::build(checkout, &fmu_build::Options::default()).unwrap();
    let built = fs::read(&default).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("actuator");
    fs::copy(env!("CARGO_BIN_EXE_actuator"), &program).unwrap();
    fs::write(folder.path().join("command.csv"), "time,command\n0,0\n0.005,1\n0.2,1\n").unwrap();
    let run = |arguments: &[&str]| {
        Command::new(&program).current_dir(folder.path()).env_remove("ACTUATOR_FMU").args(arguments).output().unwrap()
    };
    let build = ["build", "--model", "us-late-loaded"];
    let without = run(&build);
    assert_eq!(without.status.code(), Some(2));
    let message = text(&without.stderr);
    assert!(message.contains("--from") && message.contains("ACTUATOR_FMU"), "{message}");
    fs::copy(&default, folder.path().join("BactActuator.fmu")).unwrap();
    assert!(run(&build).status.success());
    assert!(run(&["simulate", "us-late-loaded", "command.csv", "--fmu", "us-late-loaded.fmu"]).status.success());
    // By its bytes: another test may package the same FMU again meanwhile.
    assert!(fs::read(&default).unwrap() == built, "the checkout is untouched");
}

#[test]
fn excitation_to_model_through_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let output = actuator(folder.path(), arguments);
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    run(&["excite", "random", "--duration", "25", "--seed", "5", "-o", "command.csv"]);
    run(&["simulate", "us-middle-unloaded", "command.csv", "-o", "record.csv"]);
    let frf = run(&["frf", "record.csv", "-o", "frf.csv"]);
    assert!(frf.contains("excited from"), "{frf}");
    assert!(fs::read_to_string(folder.path().join("frf.csv")).unwrap().starts_with("frequency_hz,magnitude,phase_deg"));
    let json: serde_json::Value =
        serde_json::from_str(&run(&["fit", "record.csv", "-o", "model.toml", "--date", "1995-02-01", "--json"]))
            .unwrap();
    assert_eq!(json["converged"], true);
    let omega = json["estimates"].as_array().unwrap().iter().find(|estimate| estimate["name"] == "omega").unwrap();
    assert!((omega["value"].as_f64().unwrap() / 142.02 - 1.0).abs() < 1e-6, "{omega}");
    assert!(omega["interval_95"].is_array() && omega["std_error"].is_number());
    let again = actuator(folder.path(), &["fit", "record.csv", "-o", "model.toml"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("--force"));
    let model = fs::read_to_string(folder.path().join("model.toml")).unwrap();
    assert!(model.contains("records = [\"record.csv\"]") && model.contains("date = \"1995-02-01\""), "{model}");
    run(&["simulate", "model.toml", "command.csv", "-o", "again.csv"]);
    let checked = run(&["fit", "record.csv", "--check", "again.csv", "--check", "record.csv", "-o", "checked.toml"]);
    assert!(
        checked.contains("predicts again.csv: ")
            && checked.contains("deg rms, 0.00 % of the position")
            && checked.contains("predicts record.csv")
    );
    assert!(fs::read_to_string(folder.path().join("checked.toml")).unwrap().contains("predicts again.csv to "));
    let report = run(&["fit", "record.csv", "--method", "report", "-o", "report.toml", "--report", "report.html"]);
    assert!(report.contains("100 % converged") && report.contains("not identifiable: p:"), "{report}");
    // It estimates no noise, and reports nothing about its colour.
    assert!(
        report.lines().any(|line| line.starts_with("residual ") && line.ends_with(" deg rms"))
            && !report.contains("white"),
        "{report}"
    );
    assert!(!fs::read_to_string(folder.path().join("report.html")).unwrap().contains("samples of white noise"));
}
