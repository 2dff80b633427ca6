//! What never happens where (ARCHITECTURE.md), kept.

use std::{fs, path::Path};

/// Text of a module and of everything below it, each file up to its tests.
fn source(module: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(module);
    below(&path.with_extension("rs")) + &below(&path)
}

fn below(path: &Path) -> String {
    if let Ok(entries) = fs::read_dir(path) {
        return entries.map(|entry| below(&entry.unwrap().path())).collect();
    }
    let text = if path.exists() { fs::read_to_string(path).unwrap() } else { String::new() };
    text.split("#[cfg(test)]").next().unwrap_or_default().to_owned()
}

#[test]
fn dependencies_point_one_way() {
    for (module, never) in [
        (
            "parameters",
            ["actuator_fmu::transition", "actuator_fmu::actuator", "actuator_fmu::fmu", "identification::signal"]
                .as_slice(),
        ),
        ("transition", &["actuator_fmu::actuator", "actuator_fmu::fmu", "identification::signal"]),
        ("effects", &["actuator_fmu::actuator", "actuator_fmu::fmu", "identification::signal"]),
        ("motion", &["actuator_fmu::actuator", "actuator_fmu::effects", "actuator_fmu::fmu"]),
        ("command", &["actuator_fmu::actuator", "actuator_fmu::effects", "actuator_fmu::fmu"]),
        ("series", &["crate::"]),
        ("actuator", &["actuator_fmu::fmu", "identification::signal", "identification::frequency"]),
        ("signal", &["identification::frequency", "identification::estimate", "actuator_fmu::fmu", "cli::report"]),
        ("frequency", &["identification::estimate", "actuator_fmu::fmu", "cli::report"]),
        ("least_squares", &["crate::"]),
        ("estimate", &["actuator_fmu::fmu", "cli::report"]),
        ("diagnose", &["actuator_fmu::fmu", "cli::report", "cli::campaign", "cli::files"]),
        ("compare", &["actuator_fmu::fmu", "cli::report", "cli::campaign", "cli::files"]),
        ("generated", &["cli::campaign", "cli::report", "cli::files", "identification::estimate"]),
        ("campaign", &["actuator_fmu::fmu", "cli::report", "cli::importer"]),
        ("ssp", &["identification::signal", "cli::report", "cli::importer", "cli::references", "std::fs"]),
        ("references", &["cli::report", "cli::importer", "std::fs"]),
        ("fmu", &["identification::signal", "cli::report", "cli::importer", "identification::frequency"]),
    ] {
        for word in never {
            assert!(!source(module).contains(word), "src/{module}.rs and below must not use {word}");
        }
    }
}

#[test]
fn the_core_opens_no_file_prints_nothing_and_reads_no_clock() {
    for module in [
        "parameters",
        "transition",
        "effects",
        "command",
        "motion",
        "actuator",
        "frequency",
        "least_squares",
        "estimate",
        "compare",
    ] {
        for word in ["std::fs", "println!", "std::time", "Instant", "rand::"] {
            assert!(!source(module).contains(word), "src/{module}.rs and below must not use {word}");
        }
    }
}

#[test]
fn unsafe_code_stands_at_the_c_boundary_only() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let allowed = ["abi/arrays.rs", "abi/host.rs", "export.rs"].map(|file| root.join("fmi-export/src").join(file));
    let mut folders = ["src", "fmi-export/src", "fmu-build/src"].map(|folder| root.join(folder)).to_vec();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") && !allowed.contains(&path) {
                let text = fs::read_to_string(&path).unwrap();
                let found = ["unsafe {", "unsafe impl", "unsafe(", "allow(unsafe_code"]
                    .iter()
                    .find(|word| text.contains(**word));
                assert!(found.is_none(), "{}: {}", path.display(), found.unwrap_or(&""));
            }
        }
    }
}

#[test]
fn the_c_boundary_has_never_heard_of_actuators() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("fmi-export");
    let text = below(&root.join("src")) + &fs::read_to_string(root.join("Cargo.toml")).unwrap();
    for word in ["actuator", "Bact", "deflection", "nalgebra"] {
        assert!(!text.contains(word), "{word}");
    }
}
