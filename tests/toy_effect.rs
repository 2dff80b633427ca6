//! A new effect is one file and one word in the list of the chain.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

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

/// The manifest of a workspace of these two packages alone, without dependencies of tests. Without profiles as well: the proof takes a moment,
/// and optimising what it runs would take a minute.
fn without_other_packages(manifest: &str) -> String {
    let mut section = "";
    let mut lines = Vec::new();
    for line in manifest.lines() {
        section = if line.starts_with('[') { line } else { section };
        match line.split(' ').next() {
            Some("members") => lines.push("members = [\".\", \"fmi-export\"]"),
            Some("default-members") => {}
            _ if section == "[dev-dependencies]" || section.starts_with("[profile") => {}
            _ => lines.push(line),
        }
    }
    lines.join("\n")
}

#[test]
fn one_file_and_one_word_make_an_effect() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    let copied = folder.path();
    for name in ["Cargo.lock", "src", "fmi-export"] {
        copy(&sources.join(name), &copied.join(name));
    }
    let manifest = fs::read_to_string(sources.join("Cargo.toml")).unwrap();
    fs::write(copied.join("Cargo.toml"), without_other_packages(&manifest)).unwrap();
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
    let target = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("toy_effect");
    let output = Command::new(env!("CARGO"))
        .args(["run", "--quiet", "--offline", "--no-default-features", "--bin", "proof"])
        .current_dir(copied)
        .env("CARGO_TARGET_DIR", target)
        .env("CARGO_PROFILE_DEV_DEBUG", "false")
        .output()
        .unwrap();
    let (printed, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    // 8.1584 deg at rest, of which half becomes its cube root: (2.0131 - 8.1584) / 2.
    assert_eq!(printed, "parameter true\nvariable true\nfile -3.0726\n", "{errors}");
}
