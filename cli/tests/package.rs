//! The FMU itself: built, rebuilt, converted to that of a model, and stepped through an importer.

use std::{path::PathBuf, sync::OnceLock};

use actuator_fmu::{
    effects::Effects,
    parameters::{Base, Model, Order, table},
};
use cli::{importer, package};
use fmu_build::{Archive, Options, Overwrite};
use identification::{
    signal::{Command, Interpolation},
    simulate::simulate,
};

/// The default FMU, compiled if it is not up to date.
fn default_fmu() -> &'static PathBuf {
    static FMU: OnceLock<PathBuf> = OnceLock::new();
    FMU.get_or_init(|| fmu_build::build(concat!(env!("CARGO_MANIFEST_DIR"), "/.."), &Options::default()).unwrap())
}

fn command() -> Command {
    let time: Vec<f64> = (0..200).map(|index| 0.005 * f64::from(index)).collect();
    let command = time.iter().map(|time| 4.0 * (30.0 * time * (1.0 + time)).sin()).collect();
    Command { time, command }
}

#[test]
fn a_second_build_gives_the_same_bytes() {
    let first = std::fs::read(default_fmu()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let second = folder.path().join("again.fmu");
    fmu_build::build(
        concat!(env!("CARGO_MANIFEST_DIR"), "/.."),
        &Options { output: Some(second.clone()), ..Options::default() },
    )
    .unwrap();
    assert!(first == std::fs::read(second).unwrap());
}

#[test]
fn the_fmu_of_every_set_moves_as_the_internal_model_to_the_bit() {
    for set in table() {
        let model = Model::from_set(set);
        let through = importer::simulate(default_fmu(), &model, &command(), Interpolation::Held).unwrap();
        assert_eq!(through.parameters_set, 6 + Effects::default().values().len());
        assert_eq!(through.response, simulate(&model, &command(), Interpolation::Held).unwrap(), "{}", set.name);
    }
}

#[test]
fn the_fmu_of_a_model_file_starts_with_its_values() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.fmu");
    let model = Model::new(Base::new(0.9, 300.0, 120.0, 1.3).unwrap(), Order::Second);
    let archive = package::for_model(Archive::read(default_fmu()).unwrap(), &model).unwrap();
    assert!(
        !archive.names().any(|name| name.contains("fmi-ls-ref/")),
        "references of the tabulated sets are not its own"
    );
    archive.write(&path, Overwrite::Refuse).unwrap();
    let own = importer::simulate_as_it_is(&path, &command(), Interpolation::Held).unwrap();
    assert_eq!(own, simulate(&model, &command(), Interpolation::Held).unwrap());
}

#[test]
fn a_model_file_that_does_not_match_its_description_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tampered.fmu");
    let model = Model::from_set(&table()[3]);
    let mut archive = package::for_model(Archive::read(default_fmu()).unwrap(), &model).unwrap();
    let text = model.to_toml().unwrap().replace("164.0", "164.5");
    archive.replace("resources/model.toml", text).unwrap();
    archive.write(&path, Overwrite::Refuse).unwrap();
    assert!(importer::simulate_as_it_is(&path, &command(), Interpolation::Held).is_err());
}
