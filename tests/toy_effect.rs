//! A new effect is one file and one word in the list of the chain.

use std::{fs, path::Path, process::Command};

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

#[test]
fn one_file_and_one_word_make_an_effect() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    let copied = folder.path();
    for name in [
        "Cargo.toml",
        "Cargo.lock",
        "src",
        "cli",
        "fmi-export",
        "fmu-build",
        "identification",
        "tests",
        "benches",
        "examples",
    ] {
        copy(&sources.join(name), &copied.join(name));
    }
    // The file.
    fs::copy(sources.join("tests/toy_effect/cube_root.rs"), copied.join("src/effects/cube_root.rs")).unwrap();
    // The word.
    let chain = copied.join("src/effects.rs");
    let text = fs::read_to_string(&chain).unwrap();
    let with_word = text.replacen("    quantisation,\n", "    cube_root,\n    quantisation,\n", 1);
    assert_eq!(with_word.lines().count(), text.lines().count() + 1);
    fs::write(&chain, with_word).unwrap();
    // The proof.
    fs::create_dir_all(copied.join("src/bin")).unwrap();
    fs::copy(sources.join("tests/toy_effect/proof.rs"), copied.join("src/bin/proof.rs")).unwrap();
    // That of this test, in which the dependencies lie compiled.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let output = Command::new(env!("CARGO"))
        .args(["run", "--quiet", "--offline", "--package", "actuator-fmu", "--bin", "proof"])
        .current_dir(copied)
        .env("CARGO_TARGET_DIR", target)
        .output()
        .unwrap();
    let (printed, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    // 8.1584 deg at rest, of which half becomes its cube root: (2.0131 - 8.1584) / 2.
    assert_eq!(printed, "parameter true\nvariable true\nfile -3.0726\n", "{errors}");
}
