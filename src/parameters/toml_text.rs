//! Reads tables from untrusted TOML text.

use serde::de::DeserializeOwned;
use toml_parser::{Source, lexer::TokenKind};

use crate::error::{Error, Result};

/// Maximum nesting depth of arrays and inline tables. Files of this program need three; the parser recurses for each level, and its own
/// limit does not apply where brackets do not match, so that a text of some megabytes would overflow the stack.
const DEEPEST: usize = 64;

/// Reads a text; `thing` and `allowed` appear in the error, with the line.
///
/// # Errors
/// Not TOML, brackets that do not match or are nested more than 64 deep, or tables other than those of `T`.
pub fn read_toml<T: DeserializeOwned>(text: &str, thing: &str, allowed: &str) -> Result<T> {
    let line = |place: usize| 1 + text.bytes().take(place).filter(|byte| *byte == b'\n').count();
    let refused = |found: String| Error::new(thing, found, allowed).remedy("correct or remove what is named");
    check_brackets(text).map_err(|(place, found)| refused(found).at_line(line(place)))?;
    toml::from_str(text).map_err(|error| {
        let refused = refused(error.message().trim().replace('\n', " "));
        error.span().map_or(refused.clone(), |place| refused.at_line(line(place.start)))
    })
}

/// Refuses brackets that are nested too deep or do not match, with their place.
fn check_brackets(text: &str) -> std::result::Result<(), (usize, String)> {
    let mut open: Vec<(&str, &str)> = Vec::new();
    for token in Source::new(text).lex() {
        let place = token.span().start();
        match token.kind() {
            TokenKind::LeftSquareBracket => open.push(("[", "]")),
            TokenKind::LeftCurlyBracket => open.push(("{", "}")),
            closer @ (TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket) => {
                let found = if closer == TokenKind::RightSquareBracket { "]" } else { "}" };
                match open.pop() {
                    Some((_, expected)) if expected == found => {}
                    Some((opened, _)) => return Err((place, format!("`{found}` after an open `{opened}`"))),
                    None => return Err((place, format!("`{found}` where nothing is open"))),
                }
            }
            _ => {}
        }
        if open.len() > DEEPEST {
            return Err((place, format!("more than {DEEPEST} open brackets")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The message; empty if nothing is refused.
    fn refusal(text: &str) -> String {
        let read = read_toml::<toml::Table>(text, "file", "tables");
        read.err().map(|error| error.to_string()).unwrap_or_default()
    }

    /// Each of these opens more than it closes, or closes another bracket: the parser would recurse for each line.
    #[test]
    fn brackets_without_end_are_refused_with_their_line() {
        for line in ["a = { b = { c = 1 }\n[d]\n", "a = { b = [ }\n] ,\n", "a = [[]\n", "a = {b = {}, c = {}, d = {\n"]
        {
            let message = refusal(&line.repeat(200_000));
            assert!(message.starts_with("line ") && message.contains("open"), "{message}");
        }
        assert!(refusal(&format!("\na = {}", "[".repeat(65))).contains("more than 64 open brackets"));
        assert!(refusal("a = 1\nb = [}\n").contains("`}` after an open `[`"));
        assert!(refusal("a = 1]\n").contains("`]` where nothing is open"));
    }

    #[test]
    fn brackets_in_texts_and_comments_do_not_count() -> Result<()> {
        let text = format!("a = \"{}\" # {}\nb = '''\n{}'''\n", "[".repeat(99), "{".repeat(99), "}\n".repeat(99));
        let table: toml::Table = read_toml(&text, "file", "tables")?;
        assert_eq!(table.len(), 2);
        let deepest = format!("a = {}{}", "[".repeat(DEEPEST), "]".repeat(DEEPEST));
        read_toml::<toml::Table>(&deepest, "file", "tables").map(drop)
    }

    #[test]
    fn what_the_parser_refuses_keeps_its_line() {
        let message = refusal("a = 1\n\na = 2\n");
        assert!(message.starts_with("line 3: file: found duplicate key"), "{message}");
    }
}
