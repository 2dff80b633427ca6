//! The FMU whose binary new models are packaged around.

use std::path::{Path, PathBuf};

use actuator_fmu::{
    Error, Result,
    fmu::{MODEL_IDENTIFIER, Settings, guid},
};
use fmu_build::Archive;

/// The default FMU: compiled from the sources this program was built from where they are, else found beside the program.
pub fn default_fmu() -> Result<PathBuf> {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR"));
    if sources.join("Cargo.toml").exists() {
        return fmu_build::build(sources, &fmu_build::Options::default()).map_err(failed);
    }
    beside_the_program().ok_or_else(|| {
        let name = format!("{MODEL_IDENTIFIER}.fmu");
        Error::new("default FMU", "none beside the program", name).remedy("name one with --from")
    })
}

/// An FMU beside the program with this program's variables, or else the default one: what a model is packaged around when the
/// binary need not be the newest.
pub fn any_fmu() -> Result<PathBuf> {
    let own = guid(&Settings::default());
    let fits = |path: &PathBuf| {
        let description = Archive::read(path).ok();
        let description = description.as_ref().and_then(|archive| archive.get("modelDescription.xml"));
        description.is_some_and(|text| String::from_utf8_lossy(text).contains(&own))
    };
    match beside_the_program().filter(fits) {
        Some(path) => Ok(path),
        None => default_fmu(),
    }
}

fn beside_the_program() -> Option<PathBuf> {
    let name = format!("{MODEL_IDENTIFIER}.fmu");
    let program = std::env::current_exe().unwrap_or_default();
    let folder = program.parent().unwrap_or(Path::new("."));
    [folder.join(&name), folder.join("../fmu").join(&name)].into_iter().find(|path| path.exists())
}

/// What the packager says, as an error of this program.
#[allow(clippy::needless_pass_by_value)] // as map_err wants it
pub fn failed(error: fmu_build::Error) -> Error {
    Error::new("FMU", error.to_string(), "an FMU archive of this program")
}
