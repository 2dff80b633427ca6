//! The command line on a real shared library: a crate is written to a temporary folder, cargo compiles it, and the FMU
//! is opened again. Nothing here needs a network.

#![allow(clippy::unwrap_used)]

use fmu_build::{Archive, Linker, Platform};
use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

const DESCRIPTION: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Tiny" guid="{tiny}">
  <CoSimulation modelIdentifier="Tiny"/>
  <ModelVariables/>
  <ModelStructure/>
</fmiModelDescription>
"#;

/// A package without dependencies, so that it compiles without a network.
fn write_tiny_crate(folder: &Path) {
    let files = [
        (
            "Cargo.toml",
            r#"[package]
name = "tiny-model"
version = "0.1.0"
edition = "2024"

[workspace]

[features]
default = ["cli"]
cli = []
answer = []

[profile.fmu]
inherits = "release"
strip = true

[package.metadata.fmu]
model-identifier = "Tiny"
description = "modelDescription.xml"
documentation = "doc"
extra = "extra"
licenses = ["LICENSE"]
profile = "fmu"
features = ["answer"]
"#,
        ),
        ("Cargo.lock", "version = 4\n\n[[package]]\nname = \"tiny-model\"\nversion = \"0.1.0\"\n"),
        (
            "src/lib.rs",
            r#"#[cfg(feature = "cli")]
compile_error!("default features must be off");
#[cfg(feature = "answer")]
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersionOfTiny() -> i32 { 42 }
"#,
        ),
        ("modelDescription.xml", DESCRIPTION),
        ("doc/index.html", "<html></html>"),
        ("LICENSE", "Permission is hereby granted"),
        ("extra/org.example/data.csv", "1,2"),
    ];
    for (name, text) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
}

/// Runs the command line in a folder, with build products in its own `target`.
fn fmu_build(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fmu-build"))
        .current_dir(folder)
        .args(arguments)
        .env_remove("CARGO_BUILD_TARGET")
        .env("CARGO_TARGET_DIR", folder.join("target"))
        .output()
        .unwrap()
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

fn assert_refused(output: &Output, words: &[&str]) {
    let text = said(output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(words.iter().all(|word| text.contains(word)), "{words:?} in {text}");
}

#[test]
fn a_real_library_is_compiled_packaged_and_built_again_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    write_tiny_crate(folder.path());
    let host = Platform::host().unwrap();
    let fmu = folder.path().join("target/fmu/Tiny.fmu");

    let output = fmu_build(folder.path(), &[]);
    assert!(output.status.success(), "{}", said(&output));
    let summary = said(&output);
    for words in ["Tiny.fmu", "platforms", host.folder(), "entries    5"] {
        assert!(summary.contains(words), "{words} in {summary}");
    }
    let archive = Archive::read(&fmu).unwrap();
    let binary_entry = host.entry("Tiny");
    assert_eq!(
        archive.names().collect::<Vec<_>>(),
        [
            "modelDescription.xml",
            &binary_entry,
            "documentation/index.html",
            "documentation/licenses/LICENSE",
            "extra/org.example/data.csv"
        ]
    );
    let binary = archive.get(&binary_entry).unwrap();
    assert!(host.recognises(binary));
    assert!(binary.windows(20).any(|part| part == b"fmi2GetVersionOfTiny"), "the feature `answer` exports a function");

    // The default output is a build product: building again replaces it, with the same bytes.
    let first = fs::read(&fmu).unwrap();
    assert!(fmu_build(folder.path(), &[]).status.success());
    assert!(fs::read(&fmu).unwrap() == first);

    // A named output is a user's file: it is replaced only with --force.
    let named = ["Cargo.toml", "-o", "out/T.fmu", "--platform", host.folder()];
    assert!(fmu_build(folder.path(), &named).status.success());
    assert_refused(&fmu_build(folder.path(), &named), &["out/T.fmu", "already exists", "--force"]);
    assert!(fmu_build(folder.path(), &[&named[..], &["--force"]].concat()).status.success());
    if Linker::for_other_computers() == Linker::Native {
        assert!(fs::read(folder.path().join("out/T.fmu")).unwrap() == first); // zig's binary is another one
    }

    let listing = said(&fmu_build(folder.path(), &["inspect", "out/T.fmu"]));
    assert!(archive.names().all(|name| listing.contains(name)) && listing.contains("unpacked"), "{listing}");
}

/// Only where `cargo-zigbuild` is on the PATH (`pip install ziglang cargo-zigbuild`).
#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[test]
fn a_named_linux_platform_runs_on_old_systems_where_zig_links_it() {
    use fmu_build::platform::glibc;
    if Linker::for_other_computers() == Linker::Native {
        eprintln!("skipped: cargo-zigbuild is not on the PATH");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    write_tiny_crate(folder.path());
    let host = Platform::host().unwrap();
    let output = fmu_build(folder.path(), &["--platform", host.folder(), "-o", "T.fmu"]);
    assert!(output.status.success(), "{}", said(&output));
    let archive = Archive::read(folder.path().join("T.fmu")).unwrap();
    let needed = glibc::needed(archive.get(&host.entry("Tiny")).unwrap());
    assert!(needed <= Some(glibc::Version { major: 2, minor: 17 }), "{needed:?}");
    assert!(said(&output).contains("needs glibc 2."), "{}", said(&output));
}

#[test]
fn a_broken_library_ends_in_cargos_own_words_and_no_archive() {
    let folder = tempfile::tempdir().unwrap();
    write_tiny_crate(folder.path());
    fs::write(folder.path().join("src/lib.rs"), "fn broken( {}").unwrap();
    let output = fmu_build(folder.path(), &[]);
    assert_refused(&output, &["src/lib.rs:1", "cargo rustc --lib --crate-type cdylib", "ended with exit status: 101"]);
    assert!(!folder.path().join("target/fmu/Tiny.fmu").exists());
}

#[test]
fn an_unknown_key_is_refused_with_line_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    write_tiny_crate(folder.path());
    let path = folder.path().join("Cargo.toml");
    fs::write(&path, fs::read_to_string(&path).unwrap().replace("licenses =", "licences =")).unwrap();
    let words = ["line 22", "unknown field `licences`", "correct this line", "`licenses`, `resources`, `extra`"];
    assert_refused(&fmu_build(folder.path(), &[]), &words);
}

#[test]
fn bad_usage_is_answered_with_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    assert_refused(&fmu_build(folder.path(), &[]), &["Cargo.toml", "check that it exists"]);
    assert_refused(&fmu_build(folder.path(), &["--platform", "beos"]), &["beos", "linux64", "aarch64-linux"]);
    assert_refused(&fmu_build(folder.path(), &["inspect", "no.fmu"]), &["no.fmu", "check that it exists"]);
    fs::write(folder.path().join("text.fmu"), "text").unwrap();
    assert_refused(&fmu_build(folder.path(), &["inspect", "text.fmu"]), &["text.fmu", "zip archive"]);
}

#[test]
fn a_platform_whose_target_is_missing_says_how_to_install_it() {
    let folder = tempfile::tempdir().unwrap();
    write_tiny_crate(folder.path());
    let host = Platform::host().unwrap();
    let is_missing = |platform: &Platform| {
        let arguments = ["--print", "target-libdir", "--target", platform.target()];
        let output = Command::new("rustc").args(arguments).output().unwrap();
        *platform != host && !Path::new(String::from_utf8(output.stdout).unwrap().trim()).is_dir()
    };
    let Some(platform) = Platform::ALL.into_iter().find(is_missing) else {
        return; // nothing to test on a computer that has them all
    };
    let output = fmu_build(folder.path(), &["--platform", platform.folder()]);
    assert_refused(&output, &[platform.folder(), "rustup target add", platform.target()]);
}
