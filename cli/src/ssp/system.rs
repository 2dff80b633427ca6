//! A system of FMUs as an archive (`.ssp`): the default FMU with a set applied, and the FMUs of models, each as a separate component.

use fmu_build::Archive;

use super::{
    file_name, parameter_set_files,
    structure::{self, COMPONENT, Part},
    values::summary,
};
use crate::{description, package};
use actuator_fmu::{
    error::{Error, Result},
    fmu::{MODEL_IDENTIFIER, MODEL_RESOURCE, Start},
    parameters::{Model, PositionUnit, SetName, find},
};

/// Folder of the archive, named by the standard, for the files that the description refers to.
const RESOURCES: &str = "resources";

/// Components of a system, in order: the FMU of each model, and the default FMU with a set applied.
#[derive(Debug, Clone, PartialEq)]
pub enum Component {
    /// The FMU of a model.
    Model(Box<Model>),
    /// The default FMU with this set. The system's resources contain all 17, so that another one only needs another name in
    /// `SystemStructure.ssd`.
    Set(SetName),
}

/// A system of these components around the default FMU.
///
/// # Errors
/// A set for which the report has no data; an FMU that is not the default one; an archive that cannot be created.
pub fn archive(fmu: &Archive, components: &[Component]) -> Result<Archive> {
    let model = format!("{RESOURCES}/{MODEL_RESOURCE}"); // the FMU has a folder of this name as well
    if fmu.get(&model).is_some() {
        return Err(Error::new("FMU of a system", "one that starts with a model file's values", "the default FMU")
            .remedy(
                "a set is chosen among the tabulated ones, which that FMU leaves aside; give model files with --model",
            ));
    }
    let refuse = |error: fmu_build::Error| Error::new("SSP archive", error.to_string(), "entries with different names");
    let names = component_names(components);
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    let mut descriptions = Vec::new();
    for (component, name) in components.iter().zip(&names) {
        let (fmu_path, bytes, text, unit, set) = match component {
            Component::Model(model) => {
                let bytes = package::for_model(fmu.clone(), model)?.to_bytes().map_err(refuse)?;
                let text = description::summary(&Start::from_model(model));
                (format!("{RESOURCES}/{name}.fmu"), bytes, text, model.unit(), None)
            }
            Component::Set(set) => {
                let bytes = fmu.to_bytes().map_err(refuse)?;
                let path = format!("{RESOURCES}/{MODEL_IDENTIFIER}.fmu");
                let source = format!("{RESOURCES}/{}", file_name(*set));
                (path, bytes, summary(find(*set)?), PositionUnit::Degree, Some(source))
            }
        };
        if !files.iter().any(|(path, _)| *path == fmu_path) {
            files.push((fmu_path.clone(), bytes));
        }
        descriptions.push((text, unit, fmu_path, set));
    }
    if components.iter().any(|component| matches!(component, Component::Set(_))) {
        let sets = parameter_set_files(None)?;
        files.extend(sets.into_iter().map(|(name, bytes)| (format!("{RESOURCES}/{name}"), bytes)));
    }
    let parts: Vec<Part<'_>> = names
        .iter()
        .zip(&descriptions)
        .map(|(name, (description, unit, fmu, set))| Part {
            name,
            description,
            unit: *unit,
            fmu: fmu.clone(),
            set: set.clone(),
        })
        .collect();
    let whole = parts.iter().map(|part| part.description).collect::<Vec<&str>>().join("; ");
    let mut archive = Archive::new();
    archive.insert("SystemStructure.ssd", structure::description(whole, &parts)?.into_bytes()).map_err(refuse)?;
    for (name, bytes) in files {
        archive.insert(name, bytes).map_err(refuse)?;
    }
    Ok(archive)
}

/// Unique names of components: those of the models, in the characters that importers accept in the name of a component (`.` separates a
/// component from its variable).
#[must_use]
pub fn component_names(components: &[Component]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for component in components {
        let name = match component {
            Component::Model(model) => model.identity.name.as_deref().map_or_else(|| COMPONENT.to_owned(), identifier),
            Component::Set(_) => COMPONENT.to_owned(),
        };
        let taken = |name: &str| names.iter().any(|other| other.eq_ignore_ascii_case(name));
        let unlike = (2..).map(|number| format!("{name}_{number}")).find(|other| !taken(other));
        let is_free = !taken(&name);
        names.push(if is_free { name } else { unlike.unwrap_or(name) });
    }
    names
}

/// Letters, digits, `_` and `-` of a name, beginning with a letter.
fn identifier(name: &str) -> String {
    let letter = |letter: char| if letter.is_ascii_alphanumeric() || letter == '-' { letter } else { '_' };
    let name: String = name.trim().chars().map(letter).collect();
    if name.starts_with(|first: char| first.is_ascii_alphabetic()) { name } else { format!("{COMPONENT}_{name}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use actuator_fmu::parameters::table;

    fn default_fmu() -> Archive {
        let mut fmu = Archive::new();
        fmu.insert("modelDescription.xml", "<fmiModelDescription/>").unwrap();
        fmu
    }

    fn named(name: &str, unit: PositionUnit) -> Component {
        let mut model = Model::from_set(&table()[0]);
        model.identity.name = Some(name.into());
        model.identity.unit = unit;
        Component::Model(Box::new(model))
    }

    #[test]
    fn a_system_holds_its_fmu_and_all_sets_and_comes_out_the_same_every_time() {
        let fmu = default_fmu();
        let chosen = [Component::Set("us-late-loaded".parse().unwrap())];
        let system = archive(&fmu, &chosen).unwrap();
        assert_eq!(system.names().filter(|name| name.ends_with(".ssv")).count(), 17);
        assert_eq!(system.get("resources/BactActuator.fmu").unwrap(), fmu.to_bytes().unwrap());
        let description = String::from_utf8_lossy(system.get("SystemStructure.ssd").unwrap()).into_owned();
        assert!(description.contains("source=\"resources/us-late-loaded.ssv\""), "{description}");
        assert_eq!(system.to_bytes().unwrap(), archive(&fmu, &chosen).unwrap().to_bytes().unwrap());
    }

    #[test]
    fn models_are_components_of_their_own_with_their_names_and_units() {
        let components = [named("Rudder, new", PositionUnit::Millimetre), named("Elevator", PositionUnit::Radian)];
        let system = archive(&default_fmu(), &components).unwrap();
        let description = String::from_utf8_lossy(system.get("SystemStructure.ssd").unwrap()).into_owned();
        for words in [
            "name=\"Rudder__new\"",
            "source=\"resources/Elevator.fmu\"",
            "unit=\"mm/s\"",
            "unit=\"rad/s\"",
            "name=\"mm\"",
        ] {
            assert!(description.contains(words), "{words} in {description}");
        }
        assert!(!description.contains("deg"), "{description}");
        assert!(system.get("resources/Rudder__new.fmu").is_some());
        assert_eq!(system.names().filter(|name| name.ends_with(".ssv")).count(), 0);
    }

    #[test]
    fn components_of_one_name_are_told_apart() {
        let unit = PositionUnit::Degree;
        let components = [named("a b", unit), named("A.b", unit), named("7", unit), Component::Set(table()[0].name)];
        assert_eq!(component_names(&components), ["a_b", "A_b_2", "actuator_7", "actuator"]);
    }

    #[test]
    fn the_fmu_of_a_model_file_would_not_take_the_set_and_is_refused() {
        let mut fmu = Archive::new();
        fmu.insert("resources/model.toml", "[base]").unwrap();
        let chosen = [Component::Set("us-late-loaded".parse().unwrap())];
        let message = archive(&fmu, &chosen).unwrap_err().to_string();
        assert!(message.contains("model file") && message.contains("default FMU"), "{message}");
    }
}
