//! A value as an XML document: declaration, two spaces of indentation, a newline at the end.

use quick_xml::se::Serializer;
use serde::Serialize;

use actuator_fmu::error::{Error, Result};

/// The document of `root`; `name` is its name in errors.
///
/// # Errors
/// The XML writer's own: a value that XML cannot hold.
pub fn document(name: &str, root: &impl Serialize) -> Result<String> {
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let mut serializer = Serializer::new(&mut text);
    serializer.indent(' ', 2);
    root.serialize(serializer).map_err(|error| Error::new(name, error.to_string(), "values that XML can hold"))?;
    text.push('\n');
    Ok(text)
}
