//! A finding on a record: what, where, and remedy.

use serde::Serialize;

/// Consequence of a finding for the use of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// A property, without a judgement.
    Note,
    /// Usable with care: results carry the warning.
    Warning,
    /// Not usable for any estimate.
    Refusal,
}

/// A finding on a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Identifier for machines, in snake case.
    pub kind: &'static str,
    /// Severity.
    pub severity: Severity,
    /// Text: what was found.
    pub sentence: String,
    /// Text: what to do; empty if nothing.
    pub remedy: String,
    /// First sample concerned, counted from 0.
    pub sample: Option<usize>,
    /// Its time \[s\].
    pub time_s: Option<f64>,
}

impl Finding {
    /// A property.
    pub fn note(kind: &'static str, sentence: impl Into<String>) -> Self {
        Self::new(kind, Severity::Note, sentence, "")
    }

    /// Usable, with care.
    pub fn warning(kind: &'static str, sentence: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(kind, Severity::Warning, sentence, remedy)
    }

    /// Not usable.
    pub fn refusal(kind: &'static str, sentence: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(kind, Severity::Refusal, sentence, remedy)
    }

    fn new(kind: &'static str, severity: Severity, sentence: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { kind, severity, sentence: sentence.into(), remedy: remedy.into(), sample: None, time_s: None }
    }

    /// With its first sample.
    #[must_use]
    pub fn at(mut self, sample: usize, time: &[f64]) -> Self {
        self.sample = Some(sample);
        self.time_s = time.get(sample).copied();
        self
    }

    /// Sentence, place and remedy in one line.
    #[must_use]
    pub fn text(&self) -> String {
        let place = match (self.sample, self.time_s) {
            (Some(sample), Some(time)) => format!(" (sample {sample}, {time:.6} s)"),
            _ => String::new(),
        };
        let remedy = if self.remedy.is_empty() { String::new() } else { format!("; {}", self.remedy) };
        format!("{}{place}{remedy}", self.sentence)
    }
}
