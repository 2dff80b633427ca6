//! The FMU of a model: the archive of the default FMU with a different description and documentation, and the model file in its resources.

use fmu_build::Archive;

use crate::{
    description,
    references::{EXPLANATION, FOLDER, NO_REFERENCES},
    report::documentation::model as documentation,
};
use actuator_fmu::{
    error::{Error, Result},
    fmu::{MODEL_RESOURCE, Start},
    parameters::Model,
};

/// Path of the page that describes the FMU.
const DOCUMENTATION: &str = "documentation/index.html";

/// Turns the archive of the default FMU into that of `model`. The binary is unchanged: it reads its start values from the model file if the
/// GUID is not its own.
///
/// # Errors
/// An archive that is not our FMU; a model that cannot be written.
pub fn for_model(mut archive: Archive, model: &Model) -> Result<Archive> {
    let text = model.to_toml()?;
    // The binary reads the file, so that the description must match the file.
    let model = Model::parse(&text)?;
    let refuse =
        |error: fmu_build::Error| Error::new("FMU archive", error.to_string(), "the default FMU of this program");
    let description = description::xml(&Start::from_model(&model));
    archive.replace("modelDescription.xml", description.into_bytes()).map_err(refuse)?;
    if archive.remove(DOCUMENTATION).is_some() {
        archive.insert(DOCUMENTATION, documentation::html(&model).into_bytes()).map_err(refuse)?;
    }
    // They are valid for the tabulated sets, which this FMU does not select.
    let references: Vec<String> = archive.names().filter(|name| name.starts_with(FOLDER)).map(str::to_owned).collect();
    for name in &references {
        archive.remove(name);
    }
    if archive.remove(EXPLANATION).is_some() {
        archive.insert(EXPLANATION, NO_REFERENCES).map_err(refuse)?; // path required by the layered standard
    }
    archive.insert(format!("resources/{MODEL_RESOURCE}"), text.into_bytes()).map_err(refuse)?;
    Ok(archive)
}
