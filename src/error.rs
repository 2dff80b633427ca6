//! The one error type: it names the thing, what was found, what is allowed and what to do.

use std::{fmt, path::PathBuf};

/// Result of everything in this crate that can be refused.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why something was refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error(Box<Parts>); // boxed, to keep Result small

#[derive(Debug, Clone, PartialEq, Eq)]
struct Parts {
    file: Option<PathBuf>,
    line: Option<usize>,
    thing: String,
    found: String,
    allowed: String,
    remedy: String,
}

/// Maximum length of a quoted part in characters; more would only repeat the file.
const LONGEST_PART: usize = 2000;

/// Text from a file for use in a message: without control characters, which a terminal would execute, and truncated.
fn shown(text: String) -> String {
    let is_control = |letter: char| letter.is_control() && letter != '\n';
    if text.len() <= LONGEST_PART && !text.contains(is_control) {
        return text;
    }
    let letters = text.chars().take(LONGEST_PART).flat_map(|letter| {
        let escaped = is_control(letter).then(|| letter.escape_default());
        let plain = escaped.is_none().then_some(letter);
        escaped.into_iter().flatten().chain(plain)
    });
    let more = if text.chars().nth(LONGEST_PART).is_some() { "..." } else { "" };
    letters.chain(more.chars()).collect()
}

impl Error {
    /// `thing` was `found`; `allowed` names what is valid.
    pub fn new(thing: impl Into<String>, found: impl Into<String>, allowed: impl Into<String>) -> Self {
        let (thing, found, allowed) = (shown(thing.into()), shown(found.into()), shown(allowed.into()));
        Self(Box::new(Parts { file: None, line: None, thing, found, allowed, remedy: String::new() }))
    }

    /// Adds what the reader can do about it.
    #[must_use]
    pub fn remedy(mut self, remedy: impl AsRef<str>) -> Self {
        if !self.0.remedy.is_empty() {
            self.0.remedy.push_str("; ");
        }
        self.0.remedy.push_str(remedy.as_ref());
        self
    }

    /// The file, and the line if known. An earlier line is kept if none is given now.
    #[must_use]
    pub fn at(mut self, file: impl Into<PathBuf>, line: Option<usize>) -> Self {
        self.0.file = Some(file.into());
        self.0.line = line.or(self.0.line);
        self
    }

    /// The line, for a text whose file the caller knows.
    #[must_use]
    pub fn at_line(mut self, line: usize) -> Self {
        self.0.line = Some(line);
        self
    }
}

impl Error {
    /// As [`Error::at`], unless a place was given before.
    #[must_use]
    pub fn or_at(self, file: impl Into<PathBuf>) -> Self {
        if self.0.file.is_some() { self } else { self.at(file, None) }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.0.file, self.0.line) {
            (Some(file), Some(line)) => write!(f, "{}:{line}: ", file.display())?,
            (Some(file), None) => write!(f, "{}: ", file.display())?,
            (None, Some(line)) => write!(f, "line {line}: ")?,
            (None, None) => {}
        }
        write!(f, "{}: found {}; allowed: {}", self.0.thing, self.0.found, self.0.allowed)?;
        if !self.0.remedy.is_empty() {
            write!(f, "; {}", self.0.remedy)?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_repeats_no_file_and_commands_no_terminal() {
        let message = Error::new("row", "\u{1b}[2J".repeat(10_000), "numbers").to_string();
        assert!(message.len() < 10_000 && message.contains("...; allowed"), "{message}");
        assert!(message.contains("\\u{1b}[2J") && !message.contains('\u{1b}'), "{message}");
    }

    #[test]
    fn a_message_names_place_thing_found_allowed_and_remedy() {
        let error =
            Error::new("column `position`", "NaN", "finite numbers").remedy("remove the row").at("record.csv", Some(7));
        assert_eq!(
            error.to_string(),
            "record.csv:7: column `position`: found NaN; allowed: finite numbers; remove the row"
        );
    }
}
