//! Reads XML to its end, so that an error anywhere is detected before an importer meets it.
//!
//! The XML reader checks one event at a time. Conditions across events are checked here: one root element, nothing open at the end, no text
//! outside, only references defined by XML itself, and the encoding that FMI 2.0 requires.

use quick_xml::{
    Reader, XmlVersion,
    escape::resolve_predefined_entity,
    events::{BytesDecl, BytesRef, BytesStart, Event},
};
use std::collections::BTreeMap;

/// The attributes of an element, by name.
pub(super) type Attributes = BTreeMap<String, String>;

/// Calls `visit` with the depth, name and attributes of each element, or reports the line in which the text is not XML.
pub(super) fn read(xml: &str, mut visit: impl FnMut(usize, &str, &Attributes)) -> Result<(), String> {
    if let Some(position) = xml.find(is_forbidden) {
        return Err(at_line(xml, position, "a character that XML 1.0 forbids"));
    }
    let mut reader = Reader::from_str(xml);
    reader.config_mut().enable_all_checks(true);
    let (mut depth, mut roots) = (0_usize, 0_usize);
    loop {
        let start = reader.buffer_position();
        let event = reader.read_event().map_err(|problem| (reader.error_position(), problem.to_string()));
        let step = event.map_err(|(position, problem)| at_line(xml, offset(position), &problem))?;
        let here = |problem: String| at_line(xml, offset(start), &problem);
        match step {
            Event::Start(ref element) | Event::Empty(ref element) => {
                visit(depth, element.name().0, &attributes(element).map_err(here)?);
                roots += usize::from(depth == 0);
                depth += usize::from(matches!(step, Event::Start(_)));
            }
            Event::End(_) => depth -= 1, // the reader has refused an end without a start
            Event::Eof if depth > 0 => return Err(here("the text ends inside an element".into())),
            Event::Eof if roots != 1 => {
                return Err(here(format!("there are {roots} root elements, not one")));
            }
            Event::Eof => return Ok(()),
            Event::Text(text) if depth == 0 && text.chars().all(|c| c.is_ascii_whitespace() || c == '\u{feff}') => {}
            Event::Text(_) | Event::CData(_) | Event::GeneralRef(_) if depth == 0 => {
                return Err(here("text outside the root element".into()));
            }
            Event::GeneralRef(reference) => check_reference(&reference).map_err(here)?,
            Event::Decl(_) if start != 0 => {
                return Err(here("an XML declaration that is not at the very beginning".into()));
            }
            Event::Decl(declaration) => check_encoding(&declaration).map_err(here)?,
            _ => {}
        }
    }
}

/// All attributes, checked: unique, quoted, without `<`, with known references only.
fn attributes(element: &BytesStart<'_>) -> Result<Attributes, String> {
    let mut attributes = Attributes::new();
    for attribute in element.attributes() {
        let attribute = attribute.map_err(|problem| problem.to_string())?;
        let name = attribute.key.0;
        if attribute.value.contains('<') {
            return Err(format!("attribute {name} contains `<`; write &lt;"));
        }
        let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|problem| problem.to_string())?;
        attributes.insert(name.into(), value.into_owned());
    }
    Ok(attributes)
}

fn check_reference(reference: &BytesRef<'_>) -> Result<(), String> {
    match reference.resolve_char_ref() {
        Ok(Some(_)) => Ok(()),
        Ok(None) if resolve_predefined_entity(reference).is_some() => Ok(()),
        _ => Err(format!("unknown reference &{};", &**reference)),
    }
}

/// FMI 2.0.4, section 2.2: the description is encoded in UTF-8.
fn check_encoding(declaration: &BytesDecl<'_>) -> Result<(), String> {
    match declaration.encoding() {
        Some(Ok(encoding)) if !encoding.eq_ignore_ascii_case("UTF-8") => {
            Err(format!("encoding is {encoding}; FMI 2.0 allows UTF-8 only"))
        }
        Some(Err(problem)) => Err(problem.to_string()),
        _ => Ok(()),
    }
}

/// XML 1.0, production 2: no control character but tab and line ends, and no U+FFFE, U+FFFF.
fn is_forbidden(c: char) -> bool {
    c < ' ' && !matches!(c, '\t' | '\n' | '\r') || matches!(c, '\u{fffe}' | '\u{ffff}')
}

fn offset(position: u64) -> usize {
    usize::try_from(position).unwrap_or(usize::MAX)
}

fn at_line(xml: &str, position: usize, problem: &str) -> String {
    let before = xml.as_bytes().get(..position).unwrap_or(xml.as_bytes());
    let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
    format!("line {line}: {problem}")
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

    #[test]
    fn elements_come_with_their_depth_and_attributes() {
        let mut seen = Vec::new();
        read(GOOD, |depth, element, attributes| seen.push((depth, element.to_owned(), attributes.len()))).unwrap();
        let expected = [(0, "fmiModelDescription", 3), (1, "CoSimulation", 1), (1, "ModelVariables", 0), (2, "x", 1)];
        assert_eq!(seen, expected.map(|(depth, element, count)| (depth, element.to_owned(), count)));
    }

    #[test]
    fn references_in_attributes_are_resolved() {
        let mut name = None;
        read(GOOD, |_, _, attributes| name = name.take().or(attributes.get("modelName").cloned())).unwrap();
        assert_eq!(name.unwrap(), "M & N");
    }

    #[test]
    fn a_byte_order_mark_is_no_text() {
        read(&format!("\u{feff}{GOOD}"), |_, _, _| {}).unwrap();
    }

    #[test]
    fn what_is_not_well_formed_is_found_with_its_line() {
        for (from, to, line) in [
            ("</ModelVariables>", "", 6),                                    // mismatched end
            ("</fmiModelDescription>", "", 7),                               // open at the end
            ("</fmiModelDescription>", "</fmiModelDescription><again/>", 7), // two roots
            ("</fmiModelDescription>", "</fmiModelDescription>text", 6),
            ("<CoSim", "</x><CoSim", 4), // end without start
            ("modelName", "guid", 3),    // an attribute twice
            ("&lt;", "&nbsp;", 5),       // HTML, not XML
            ("&lt;", "\u{1}", 5),
            ("&amp;", "&bad;", 3),
            ("\"{1}\"", "{1}", 3), // no quotes
            ("\"{1}\"", "\"<\"", 3),
            ("UTF-8", "latin1", 1),
            ("<!-- a comment -->", "<!-- a -- comment -->", 2),
            ("<!-- a comment -->", "<?xml version='1.0'?>", 2),
        ] {
            let problem = read(&GOOD.replacen(from, to, 1), |_, _, _| {}).unwrap_err();
            assert!(problem.starts_with(&format!("line {line}:")), "{to}: {problem}");
        }
        assert!(read("", |_, _, _| {}).unwrap_err().contains("0 root elements"));
    }
}
