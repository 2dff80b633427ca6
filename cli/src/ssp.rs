//! The 17 sets for tools that speak SSP 1.0 (System Structure and Parameterization): one parameter set file each (`.ssv`), and a
//! system of one component with one of them applied (`.ssp`).
//!
//! What the files hold is what the importers read. libcosim and Ecos end at the first parameter or connector that is an
//! enumeration, and fmpy takes the item's name for a number; all three set integers. So a set is its `set_number`, not its
//! `surface`, `stage` and `load_case`, and the input `failure` has no connector.

mod structure;
mod values;

use fmu_build::Archive;

use actuator_fmu::{
    error::{Error, Result},
    fmu::{MODEL_IDENTIFIER, MODEL_RESOURCE},
    parameters::{SetName, find, table},
};
pub use structure::COMPONENT;
pub use values::{parameter_set, summary};

/// Folder of the archive, named by the standard, for what the description refers to.
const RESOURCES: &str = "resources";

/// The 17 files of [`parameter_set`] with their names.
///
/// # Errors
/// None in practice; the XML writer's own.
pub fn parameter_set_files(prefix: Option<&str>) -> Result<Vec<(String, Vec<u8>)>> {
    table().iter().map(|set| Ok((file_name(set.name), parameter_set(set, prefix)?.into_bytes()))).collect()
}

/// A system of one component around the default FMU, in which `chosen` is applied. All 17 sets lie in its resources, so that another
/// one is another name in `SystemStructure.ssd`.
///
/// # Errors
/// A set for which the report has no data; the FMU of a model file; an archive that cannot be made.
pub fn archive(fmu: &Archive, chosen: SetName) -> Result<Archive> {
    let chosen = find(chosen)?;
    let model = format!("{RESOURCES}/{MODEL_RESOURCE}"); // the FMU has a folder of this name as well
    if fmu.get(&model).is_some() {
        return Err(Error::new("FMU of a system", "one that starts with a model file's values", "the default FMU")
            .remedy("a set is chosen among the tabulated ones, which that FMU leaves aside"));
    }
    let refuse = |error: fmu_build::Error| Error::new("SSP archive", error.to_string(), "entries with different names");
    let mut archive = Archive::new();
    let mut add = |name: String, bytes: Vec<u8>| archive.insert(name, bytes).map_err(refuse);
    let component = format!("{RESOURCES}/{MODEL_IDENTIFIER}.fmu");
    let set = format!("{RESOURCES}/{}", file_name(chosen.name));
    add("SystemStructure.ssd".into(), structure::description(chosen, &component, &set)?.into_bytes())?;
    add(component, fmu.to_bytes().map_err(refuse)?)?;
    for (name, bytes) in parameter_set_files(None)? {
        add(format!("{RESOURCES}/{name}"), bytes)?;
    }
    Ok(archive)
}

fn file_name(set: SetName) -> String {
    format!("{set}.ssv")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_holds_its_fmu_and_all_sets_and_comes_out_the_same_every_time() {
        let mut fmu = Archive::new();
        fmu.insert("modelDescription.xml", "<fmiModelDescription/>").unwrap();
        let name = "us-late-loaded".parse().unwrap();
        let system = archive(&fmu, name).unwrap();
        assert_eq!(system.names().filter(|name| name.ends_with(".ssv")).count(), 17);
        assert_eq!(system.get("resources/BactActuator.fmu").unwrap(), fmu.to_bytes().unwrap());
        let description = String::from_utf8_lossy(system.get("SystemStructure.ssd").unwrap()).into_owned();
        assert!(description.contains("source=\"resources/us-late-loaded.ssv\""), "{description}");
        assert_eq!(system.to_bytes().unwrap(), archive(&fmu, name).unwrap().to_bytes().unwrap());
    }

    #[test]
    fn the_fmu_of_a_model_file_would_not_take_the_set_and_is_refused() {
        let mut fmu = Archive::new();
        fmu.insert("resources/model.toml", "[base]").unwrap();
        let message = archive(&fmu, "us-late-loaded".parse().unwrap()).unwrap_err().to_string();
        assert!(message.contains("model file") && message.contains("default FMU"), "{message}");
    }
}
