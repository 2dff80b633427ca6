//! Committed generated files equal those that the code generates now.

use std::path::Path;

use actuator_fmu::fmu::Start;
use cli::{
    description, references,
    report::{documentation, icon},
};

fn is_current(file: &str, now: &[u8]) {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join("modelDescription").join(file);
    let committed = std::fs::read(&path).unwrap_or_default();
    assert!(
        committed == now,
        "{} is not what the code renders; refresh it with `cargo run -- render modelDescription`",
        path.display()
    );
}

#[test]
fn the_committed_description_is_rendered_from_the_code() {
    is_current("modelDescription.xml", description::xml(&Start::default()).as_bytes());
}

#[test]
fn the_committed_documentation_is_rendered_from_the_code() {
    is_current("documentation/index.html", documentation::html().as_bytes());
}

#[test]
fn the_committed_picture_is_drawn_by_the_code() {
    is_current("model.png", &icon::png().unwrap());
}

/// Numbers of committed responses may differ by the rounding of other mathematical libraries.
const LAST_DIGITS: f64 = 1e-12;

fn is_nearly(committed: &str, now: &str) -> bool {
    let nearly = |(one, other): (&str, &str)| match (one.parse::<f64>(), other.parse::<f64>()) {
        (Ok(one), Ok(other)) => (one - other).abs() <= LAST_DIGITS * one.abs().max(1.0),
        _ => one == other,
    };
    let words = |text: &str| text.split_inclusive([',', '\n']).map(|word| word.trim().to_owned()).collect::<Vec<_>>();
    let (committed, now) = (words(committed), words(now));
    committed.len() == now.len()
        && committed
            .iter()
            .zip(&now)
            .all(|(one, other)| nearly((one.trim_end_matches(','), other.trim_end_matches(','))))
}

#[test]
fn the_committed_references_are_rendered_from_the_code_and_nothing_else_lies_there() {
    let files = references::files().unwrap();
    for (name, now) in &files {
        if name.ends_with("-response.csv") {
            let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join("modelDescription").join(name);
            let committed = std::fs::read_to_string(path).unwrap_or_default();
            assert!(
                is_nearly(&committed, &String::from_utf8_lossy(now)),
                "{name}: `cargo run -- render modelDescription`"
            );
        } else {
            is_current(name, now);
        }
    }
    let folder =
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join("modelDescription").join(references::FOLDER);
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), files.len() - 1, "one file lies in documentation/");
}
