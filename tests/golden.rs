//! Generated files are those that the code generates now.

use std::path::Path;

use actuator_fmu::{
    fmu::{Settings, description},
    report::{documentation, icon},
};

fn is_current(file: &str, now: &[u8]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("modelDescription").join(file);
    let committed = std::fs::read(&path).unwrap_or_default();
    assert!(
        committed == now,
        "{} is not what the code renders; refresh it with `cargo run -- render modelDescription`",
        path.display()
    );
}

#[test]
fn the_committed_description_is_rendered_from_the_code() {
    is_current("modelDescription.xml", description::xml(&Settings::default()).unwrap().as_bytes());
}

#[test]
fn the_committed_documentation_is_rendered_from_the_code() {
    is_current("documentation/index.html", documentation::html().as_bytes());
}

#[test]
fn the_committed_picture_is_drawn_by_the_code() {
    is_current("model.png", &icon::png().unwrap());
}
