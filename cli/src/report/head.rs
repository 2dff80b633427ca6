//! The head of every page: the verdict in one sentence, and inputs and command line, so that a reader can repeat it.

use std::path::Path;

use identification::{digits::significant, signal::record::Record};

use super::page::{Cell, Page, Tone};
use crate::invocation::Invocation;

/// The beginning of a page.
pub struct Head<'a> {
    /// Subject of the page.
    pub title: String,
    /// State of the verdict.
    pub tone: Tone,
    /// The verdict in a word or two.
    pub verdict: String,
    /// The verdict in one sentence.
    pub sentence: String,
    /// Basis of the verdict; may be empty.
    pub evidence: String,
    /// Given or generated models, in words.
    pub model: String,
    /// Records, or models that were compared.
    pub files: Vec<FileRow>,
    /// The command line.
    pub invocation: &'a Invocation,
}

/// A record or a model in the list of inputs of a page.
#[derive(Debug, Clone, PartialEq)]
pub struct FileRow {
    /// Name without folder.
    pub name: String,
    /// Role.
    pub role: String,
    /// Number of samples, for a record that was read.
    pub samples: Option<usize>,
    /// Length \[s\], for a record that was read.
    pub duration_s: Option<f64>,
    /// SHA-256 of the file.
    pub sha256: Option<String>,
}

impl FileRow {
    /// For a record.
    #[must_use]
    pub fn of(record: &Record, role: &str) -> Self {
        Self {
            name: file_name(record.source()),
            role: role.to_owned(),
            samples: Some(record.len()),
            duration_s: Some(record.duration_s()),
            sha256: Some(record.sha256().to_owned()),
        }
    }

    fn cells(&self) -> Vec<Cell> {
        let or_none = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        vec![
            Cell::text(&self.name),
            Cell::text(&self.role),
            Cell::number(or_none(self.samples.map(|samples| samples.to_string()))),
            Cell::number(or_none(self.duration_s.map(|duration| significant(duration, 5)))),
            Cell::text(or_none(self.sha256.clone())),
        ]
    }
}

/// A path without its folder.
#[must_use]
pub fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

impl Head<'_> {
    /// A page with this head.
    #[must_use]
    pub fn page(self) -> Page {
        let Invocation { options, .. } = self.invocation;
        let options = if options.is_empty() { "none: all have their defaults".to_owned() } else { options.join(" ") };
        let verdict = (self.tone, self.verdict, self.sentence, self.evidence, String::new());
        let facts = [
            ("model", self.model),
            ("options", options),
            ("version", format!("actuator {}", env!("CARGO_PKG_VERSION"))),
        ];
        let mut page = Page::new(self.title).verdicts(&[verdict]).facts(&facts);
        if !self.invocation.command.is_empty() {
            page = page.command(&self.invocation.shell());
        }
        if self.files.is_empty() {
            return page;
        }
        let rows: Vec<Vec<Cell>> = self.files.iter().map(FileRow::cells).collect();
        page.long_table(&["file", "role", "samples", "duration, s", "SHA-256"], &rows)
    }
}
