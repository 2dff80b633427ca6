//! A parameter set file: SSP 1.0, SystemStructureParameterValues.

use serde::Serialize;

use crate::xml;
use actuator_fmu::{
    error::{Error, Result},
    parameters::{Base, ParameterSet, table},
};

/// Namespace of the format.
const NAMESPACE: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";

/// The variable that selects a set and that every importer can set.
const SELECTOR: &str = "set_number";

#[derive(Serialize)]
#[serde(rename = "ssv:ParameterSet")]
struct Document {
    #[serde(rename = "@xmlns:ssv")]
    namespace: &'static str,
    #[serde(rename = "@version")]
    version: &'static str,
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@description")]
    description: String,
    #[serde(rename = "@generationTool")]
    generation_tool: &'static str,
    #[serde(rename = "ssv:Parameters")]
    parameters: Parameters,
}

#[derive(Serialize)]
struct Parameters {
    #[serde(rename = "ssv:Parameter")]
    one: Parameter,
}

#[derive(Serialize)]
struct Parameter {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "ssv:Integer")]
    value: Integer,
}

#[derive(Serialize)]
struct Integer {
    #[serde(rename = "@value")]
    value: usize,
}

/// The file of one set. With a `prefix`, `prefix.` precedes the name of the parameter.
///
/// # Errors
/// A set that is not in the table; those of the XML writer.
pub fn parameter_set(set: &ParameterSet, prefix: Option<&str>) -> Result<String> {
    let index = table().iter().position(|other| other.name == set.name);
    let number = index.map(|index| index + 1).ok_or_else(|| {
        Error::new("parameter set", set.name.to_string(), "one of the tabulated sets, which have a number")
    })?;
    let name = match prefix {
        Some(prefix) => format!("{prefix}.{SELECTOR}"),
        None => SELECTOR.into(),
    };
    let document = Document {
        namespace: NAMESPACE,
        version: "1.0",
        name: set.name.to_string(),
        description: summary(set),
        generation_tool: GENERATION_TOOL,
        parameters: Parameters { one: Parameter { name, value: Integer { value: number } } },
    };
    xml::document("parameter set", &document)
}

/// Generating tool.
pub(super) const GENERATION_TOOL: &str = concat!("actuator-fmu ", env!("CARGO_PKG_VERSION"));

/// The set in words and numbers, for a reader of the file.
#[must_use]
pub fn summary(set: &ParameterSet) -> String {
    let values: Vec<String> = Base::PARAMETERS
        .iter()
        .zip(set.base.values())
        .map(|(parameter, value)| match parameter.unit {
            "1" => format!("{} = {value}", parameter.name),
            unit => format!("{} = {value} {unit}", parameter.name),
        })
        .collect();
    let name = set.name;
    format!(
        "{}, {}, {}: {} ({})",
        name.surface.name(),
        name.stage.name(),
        name.load_case.name(),
        values.join(", "),
        set.source()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_selects_its_row_by_number_under_a_plain_or_a_prefixed_name() {
        let set = &table()[14];
        let plain = parameter_set(set, None).unwrap();
        for words in [
            "name=\"us-late-loaded\"",
            "<ssv:Parameter name=\"set_number\">",
            "<ssv:Integer value=\"15\"/>",
            "p = 297000000 1/s",
            "table 2, row 6",
        ] {
            assert!(plain.contains(words), "{words} in {plain}");
        }
        let prefixed = parameter_set(set, Some("actuator")).unwrap();
        assert_eq!(prefixed, plain.replace("\"set_number\"", "\"actuator.set_number\""));
    }
}
