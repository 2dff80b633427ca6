//! The default FMU, whose binary is used in the FMUs of models: how the program finds it.
//!
//! The program compiles nothing. It uses the given FMU, otherwise the first of these that exists:
//!
//! 1. the one that the environment variable `ACTUATOR_FMU` names,
//! 2. `BactActuator.fmu` beside the program,
//! 3. `share/actuator-fmu/BactActuator.fmu` beside the program's folder: the location in a wheel,
//! 4. `fmu/BactActuator.fmu` in the folder of build products that contains the program (`target` of a checkout).

use std::path::{Path, PathBuf};

use actuator_fmu::{
    error::{Error, Result},
    fmu::{MODEL_IDENTIFIER, Start, guid},
};
use fmu_build::Archive;

/// Environment variable that names the default FMU.
pub const VARIABLE: &str = "ACTUATOR_FMU";

/// Remedy if there is none.
const REMEDY: &str = "name one with --from or ACTUATOR_FMU, or put it beside the program; in a checkout `cargo run -p fmu-build` makes it";

/// The archive of the default FMU: from `from` if given, otherwise searched for.
///
/// # Errors
/// The named FMU does not exist, or none is found; one that is not the default FMU of this version of the program.
pub fn read(from: Option<&Path>) -> Result<Archive> {
    let path = match from {
        Some(path) => path.to_owned(),
        None => find()?,
    };
    let archive = Archive::read(&path).map_err(refused)?;
    if from.is_none() && !is_of_this_program(&archive) {
        return Err(Error::new("default FMU", "one of another version", "that of this version of the program")
            .remedy(REMEDY)
            .at(path, None));
    }
    Ok(archive)
}

fn find() -> Result<PathBuf> {
    let name = format!("{MODEL_IDENTIFIER}.fmu");
    if let Some(path) = std::env::var_os(VARIABLE) {
        return Ok(path.into());
    }
    let program = std::env::current_exe().unwrap_or_default();
    let folder = program.parent().unwrap_or(Path::new("."));
    // target/PROFILE/actuator, and target/PROFILE/deps/TEST or target/TRIPLE/PROFILE/actuator.
    let places = ["", "../share/actuator-fmu", "../fmu", "../../fmu"].map(|place| folder.join(place).join(&name));
    places
        .into_iter()
        .find(|path| path.exists())
        .ok_or_else(|| Error::new("default FMU", "none", format!("{name} of this version")).remedy(REMEDY))
}

/// The description of the default FMU has the GUID of this program's variables.
fn is_of_this_program(archive: &Archive) -> bool {
    let own = guid(&Start::default());
    archive.get("modelDescription.xml").is_some_and(|text| String::from_utf8_lossy(text).contains(&own))
}

/// An error of the packager as an error of this program.
#[allow(clippy::needless_pass_by_value)] // signature required by map_err
#[must_use]
pub fn refused(error: fmu_build::Error) -> Error {
    let refuse = |found: String| Error::new("FMU", found, "an FMU archive of this program");
    match error {
        fmu_build::Error::Read { path, cause } => {
            refuse(cause.to_string()).remedy("check that it exists and that you may read it").at(path, None)
        }
        other => refuse(other.to_string()),
    }
}
