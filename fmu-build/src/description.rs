//! The checks on `modelDescription.xml` that concern packaging: it is well-formed, it is FMI 2.0, it has a GUID, and it names the binary as
//! it is packaged. The variables are left to a validator.

mod well_formed;

use well_formed::Attributes;

/// "fmiVersion" of FMI 2.0.4, section 2.2.1: exactly this, without a patch number.
const FMI_VERSION: &str = "2.0";

/// The parts of a description needed for packaging.
#[derive(Default)]
struct Description {
    root: String,
    fmi_version: Option<String>,
    guid: Option<String>,
    /// `CoSimulation` and `ModelExchange` elements with their `modelIdentifier`.
    interfaces: Vec<(String, Option<String>)>,
}

/// All problems, one sentence each.
pub(crate) fn problems(xml: &str, model_identifier: &str) -> Vec<String> {
    let mut description = Description::default();
    match well_formed::read(xml, |depth, element, attributes| description.note(depth, element, attributes)) {
        Ok(()) => description.problems(model_identifier),
        Err(problem) => vec![format!("modelDescription.xml is not well-formed XML: {problem}")],
    }
}

impl Description {
    fn note(&mut self, depth: usize, element: &str, attributes: &Attributes) {
        let value = |name: &str| attributes.get(name).cloned();
        match (depth, element) {
            (0, _) => {
                self.root = element.into();
                self.fmi_version = value("fmiVersion");
                self.guid = value("guid");
            }
            (1, "CoSimulation" | "ModelExchange") => self.interfaces.push((element.into(), value("modelIdentifier"))),
            _ => {}
        }
    }

    fn problems(&self, model_identifier: &str) -> Vec<String> {
        let mut problems = Vec::new();
        if self.root != "fmiModelDescription" {
            problems.push(format!("the root element is <{}>; it must be <fmiModelDescription>", self.root));
        }
        if self.fmi_version.as_deref() != Some(FMI_VERSION) {
            let found = shown(&self.fmi_version);
            problems.push(format!("fmiVersion is {found}; it must be exactly \"{FMI_VERSION}\""));
        }
        if self.guid.as_deref().is_none_or(|guid| guid.trim().is_empty()) {
            problems.push(format!("guid is {}; give it the text that the binary expects", shown(&self.guid)));
        }
        if self.interfaces.is_empty() {
            problems
                .push("there is neither <CoSimulation> nor <ModelExchange>; add the one that the binary offers".into());
        }
        for (element, found) in &self.interfaces {
            if found.as_deref() != Some(model_identifier) {
                problems.push(format!(
                    "modelIdentifier of <{element}> is {}; the binary is packaged as \"{model_identifier}\": make \
                     them equal",
                    shown(found)
                ));
            }
        }
        problems.into_iter().map(|problem| format!("modelDescription.xml: {problem}")).collect()
    }
}

fn shown(attribute: &Option<String>) -> String {
    attribute.as_ref().map_or("missing".into(), |value| format!("\"{value}\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<!-- a comment -->
<fmiModelDescription fmiVersion="2.0" modelName="M &amp; N" guid="{1}">
  <CoSimulation modelIdentifier="M"/>
  <ModelVariables>&#65; &lt; B<x y='"'/></ModelVariables>
</fmiModelDescription>
"#;

    fn only_problem(xml: &str) -> String {
        let problems = problems(xml, "M");
        assert_eq!(problems.len(), 1, "{problems:?}");
        problems[0].clone()
    }

    #[test]
    fn a_good_description_has_no_problems() {
        assert_eq!(problems(GOOD, "M"), Vec::<String>::new());
        assert_eq!(problems(&format!("\u{feff}{GOOD}"), "M"), Vec::<String>::new());
    }

    #[test]
    fn a_version_that_only_looks_like_2_is_refused() {
        for version in ["2.0.4", "2", "3.0", ""] {
            let problem = only_problem(&GOOD.replace("\"2.0\"", &format!("\"{version}\"")));
            assert!(problem.contains(&format!("\"{version}\"")) && problem.contains("exactly \"2.0\""), "{problem}");
        }
    }

    #[test]
    fn each_interface_must_name_the_binary() {
        let both = GOOD.replace("<ModelVar", "<ModelExchange modelIdentifier='N'/><ModelVar");
        assert!(only_problem(&both).contains("<ModelExchange> is \"N\""));
        assert!(only_problem(&GOOD.replace("CoSimulation", "Other")).contains("neither <CoSimulation>"));
    }

    #[test]
    fn a_guid_must_be_there_and_not_blank() {
        assert!(only_problem(&GOOD.replace("guid=\"{1}\"", "guid=' '")).contains("guid is \" \""));
        assert!(only_problem(&GOOD.replace("guid=\"{1}\"", "")).contains("guid is missing"));
    }

    #[test]
    fn all_problems_of_a_well_formed_description_come_together() {
        assert_eq!(problems("<model/>", "M").len(), 4);
    }
}
