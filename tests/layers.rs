//! Rules of ARCHITECTURE.md on imports, files and unsafe code.

mod package;
mod source;

use std::{fs, path::Path};

use package::{PACKAGES, Package, shown};

/// Fails with the cycles of files that import each other, directly or indirectly.
fn assert_no_circles(package: &'static str) {
    let circles = Package::read(package).circles();
    assert!(circles.is_empty(), "{package}: files import each other:\n{}", circles.join("\n\n"));
}

/// One test for each package.
macro_rules! no_circles {
    ($($test:ident: $package:literal),+ $(,)?) => {
        $(
            #[test]
            fn $test() {
                assert_no_circles($package);
            }
        )+

        #[test]
        fn every_package_is_checked_for_circles() {
            assert_eq!([$($package),+], PACKAGES.map(|(name, _)| name));
        }
    };
}

no_circles! {
    no_circles_in_actuator_fmu: "actuator_fmu",
    no_circles_in_identification: "identification",
    no_circles_in_cli: "cli",
    no_circles_in_fmi_export: "fmi_export",
    no_circles_in_fmu_build: "fmu_build",
    no_circles_in_bact_wing: "bact_wing",
    no_circles_in_robustness: "robustness",
}

/// Modules of the actuator, from the ground up: each imports only modules before it.
const LAYERS: [&str; 11] = [
    "series",
    "error",
    "operator",
    "motion",
    "command",
    "effects",
    "parameters",
    "exponential",
    "transition",
    "actuator",
    "fmu",
];

#[test]
fn imports_are_found_in_every_form_and_resolved_from_the_root() {
    let text = r##"
        //! crate::comment::X
        use crate::{a::{self, B}, c as d};
        use super::e::*;
        pub use child::F;
        mod written_out { fn f() { super::g(); } }
        fn f<'a>(text: &'a str) -> [char; 2] { a::h(); d::i::j(); child::k(r#"crate::literal::X"#); ['"', '\\''] }
        macro_rules! m { ($name:ident) => { $crate::l::M; super::$name::N } }
        #[cfg(test)]
        mod tests { use crate::tests::X; }
        fn last() { std::fs::read() }
    "##;
    let file = tempfile::NamedTempFile::new().unwrap();
    fs::write(file.path(), text).unwrap();
    let module = ["parent", "file"].map(String::from).to_vec();
    let exists = |path: &source::ItemPath| path.join("::") == "parent::file::child";
    let found = source::paths(&source::tokens(file.path()), "p", &module, exists);
    let found: Vec<String> = found.iter().map(|path| path.join("::")).collect();
    let expected = ["a", "a::B", "c", "parent::e::*", "parent::file::child::F", "parent::file::g", "a::h", "c::i::j"]
        .into_iter()
        .chain(["parent::file::child::k", "l::M"])
        .map(|path| format!("p::{path}"))
        .chain(["std::fs::read".to_owned()]);
    assert_eq!(found, expected.collect::<Vec<_>>());
}

#[test]
fn layers_of_the_actuator_import_only_those_below() {
    let package = Package::read("actuator_fmu");
    let mut listed = LAYERS.to_vec();
    listed.sort_unstable();
    assert_eq!(package.modules().into_iter().collect::<Vec<_>>(), listed);
    for (index, layer) in LAYERS.iter().enumerate() {
        for above in &LAYERS[index + 1..] {
            assert_never_imports(&package, layer, &format!("actuator_fmu::{above}"));
        }
    }
}

#[test]
fn dependencies_between_packages_and_modules_point_one_way() {
    let rules: [(&str, &str, &[&str]); 12] = [
        ("actuator_fmu", "", &["identification", "cli", "fmu_build"]),
        ("identification", "", &["actuator_fmu::fmu", "fmi_export", "fmu_build", "cli", "std::fs"]),
        ("identification", "signal", &["identification::frequency", "identification::estimate"]),
        ("identification", "frequency", &["identification::estimate"]),
        ("identification", "least_squares", &["identification::signal", "identification::estimate", "actuator_fmu"]),
        ("identification", "generated", &["identification::estimate"]),
        ("cli", "campaign", &["actuator_fmu::fmu", "cli::report::campaign", "cli::importer"]),
        ("cli", "ssp", &["identification::signal", "cli::report", "cli::importer", "cli::references", "std::fs"]),
        ("cli", "references", &["cli::report", "cli::importer", "std::fs"]),
        ("fmi_export", "", &["actuator_fmu", "identification", "cli", "fmu_build", "std::fs"]),
        ("fmu_build", "", &["actuator_fmu", "identification", "cli", "fmi_export"]),
        ("bact_wing", "", &["actuator_fmu", "identification", "cli", "fmu_build", "std::fs"]),
    ];
    for (package, module, never) in rules {
        let package = Package::read(package);
        never.iter().for_each(|path| assert_never_imports(&package, module, path));
    }
}

/// Fails if a file of the module, or below it, refers to something in `forbidden`.
fn assert_never_imports(package: &Package, module: &str, forbidden: &str) {
    let prefix: Vec<&str> = forbidden.split("::").collect();
    for file in package.below(module) {
        let found =
            file.names.iter().find(|path| path.iter().zip(&prefix).filter(|(a, b)| a == b).count() == prefix.len());
        assert!(found.is_none(), "{} must not use {forbidden}: {}", shown(&file.path), found.unwrap().join("::"));
    }
}

#[test]
fn the_core_opens_no_file_prints_nothing_reads_no_clock_and_draws_no_random_number() {
    let of_actuator = LAYERS.iter().filter(|layer| **layer != "fmu").map(|module| ("actuator_fmu", *module));
    let of_identification =
        ["frequency", "least_squares", "estimate", "compare"].map(|module| ("identification", module));
    for (package, module) in of_actuator.chain(of_identification) {
        let package = Package::read(package);
        for path in ["std::fs", "std::time", "rand"] {
            assert_never_imports(&package, module, path);
        }
        for file in package.below(module) {
            let prints = file
                .tokens
                .windows(2)
                .find(|pair| pair[1] == "!" && ["print", "println", "eprint", "eprintln", "dbg"].contains(&&*pair[0]));
            assert!(prints.is_none(), "{} must not print", shown(&file.path));
        }
    }
}

#[test]
fn no_source_depends_on_a_feature() {
    for (name, _) in PACKAGES {
        for file in Package::read(name).below("") {
            let tests_feature = file.tokens.windows(2).any(|pair| pair[0] == "feature" && pair[1] == "=");
            assert!(!tests_feature, "{} must not contain cfg(feature = ..)", shown(&file.path));
        }
    }
}

#[test]
fn unsafe_code_is_at_the_c_boundary_only() {
    let allowed = [
        "abi/arrays.rs",
        "abi/barrier.rs",
        "abi/exclusive.rs",
        "abi/host.rs",
        "abi/library.rs",
        "abi/thread.rs",
        "export.rs",
    ]
    .map(|file| format!("fmi-export/src/{file}"));
    // The host side, which loads a library as a host does.
    let allowed = [&allowed[..], &["robustness/src/functions.rs".to_owned()]].concat();
    for (name, _) in PACKAGES {
        for file in Package::read(name).below("").filter(|file| !allowed.contains(&shown(&file.path))) {
            let found = file.tokens.iter().any(|token| token == "unsafe");
            let allows = file.tokens.windows(3).any(|three| three[0] == "allow" && three[2] == "unsafe_code");
            assert!(!found && !allows, "{} must not contain unsafe code", shown(&file.path));
        }
    }
}

#[test]
fn the_c_boundary_knows_nothing_of_actuators() {
    let cargo_toml = Path::new(env!("CARGO_MANIFEST_DIR")).join("fmi-export/Cargo.toml");
    let package = Package::read("fmi_export");
    let texts = package.below("").map(|file| file.path.as_path()).chain([cargo_toml.as_path()]);
    for path in texts {
        let text = fs::read_to_string(path).unwrap();
        for word in ["actuator", "Bact", "deflection", "nalgebra"] {
            assert!(!text.contains(word), "{}: {word}", shown(path));
        }
    }
}
