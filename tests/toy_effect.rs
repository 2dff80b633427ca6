//! A new effect is one file and one word in the list of the chain.

use std::{fs, path::Path, process::Command};

/// All files and folders that the manifest refers to.
const MEMBERS: [&str; 10] = [
    "Cargo.lock",
    "src",
    "tests",
    "cli",
    "fmi-export",
    "fmu-build",
    "identification",
    "robustness",
    "benches",
    "examples",
];

fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(from).unwrap() {
            let entry = entry.unwrap();
            copy(&entry.path(), &to.join(entry.file_name()));
        }
    } else {
        fs::copy(from, to).unwrap();
    }
}

/// The manifest of the same workspace, so that dependencies are those already compiled by this build. Only these two packages are recompiled, without
/// optimisation, since the proof is short.
fn not_optimised(manifest: &str) -> String {
    let mut lines = Vec::new();
    let mut own = false;
    for line in manifest.lines() {
        if line.starts_with('[') {
            own = line == "[profile.dev]" || line == "[profile.dev.package.actuator-fmu]";
        }
        lines.push(if own && line.starts_with("opt-level") { "opt-level = 0" } else { line });
    }
    lines.join("\n")
}

#[test]
#[ignore = "slow"]
fn one_file_and_one_word_make_an_effect() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR"));
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    // In the same place each time, so that earlier build products are replaced.
    let copied = &target.join("tmp/toy_effect");
    let _ = fs::remove_dir_all(copied);
    fs::create_dir_all(copied).unwrap();
    let manifest = fs::read_to_string(sources.join("Cargo.toml")).unwrap();
    for name in MEMBERS {
        copy(&sources.join(name), &copied.join(name));
    }
    fs::write(copied.join("Cargo.toml"), not_optimised(&manifest)).unwrap();
    // The file.
    fs::copy(sources.join("tests/toy_effect/cube_root.rs"), copied.join("src/effects/cube_root.rs")).unwrap();
    // The word.
    let chain = copied.join("src/effects.rs");
    let text = fs::read_to_string(&chain).unwrap();
    let with_word = text.replacen("quantisation,\n", "cube_root,\n            quantisation,\n", 1);
    assert_eq!(with_word.lines().count(), text.lines().count() + 1);
    fs::write(&chain, with_word).unwrap();
    // The proof.
    fs::create_dir_all(copied.join("src/bin")).unwrap();
    fs::copy(sources.join("tests/toy_effect/proof.rs"), copied.join("src/bin/proof.rs")).unwrap();
    let built = Command::new(env!("CARGO"))
        .args(["build", "--quiet", "--offline", "--workspace", "--bin", "proof"])
        .current_dir(copied)
        .env("CARGO_TARGET_DIR", target)
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let output = Command::new(target.join("debug/proof")).output().unwrap();
    let (printed, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    // 8.1584 deg at rest, of which half becomes its cube root: (2.0131 - 8.1584) / 2.
    assert_eq!(printed, "parameter true\nvariable true\nfile -3.0726\n", "{errors}");
}
