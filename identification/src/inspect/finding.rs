//! One thing to say of a record: what it is, where it is, what to do.

use serde::Serialize;

/// What a finding means for the use of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// A property, neither good nor bad.
    Note,
    /// Usable, with care: results carry it.
    Warning,
    /// Not usable: nothing is estimated from it.
    Refusal,
}

/// What was found in a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// For machines, in snake case.
    pub kind: &'static str,
    /// What it means.
    pub severity: Severity,
    /// For people: what was found.
    pub sentence: String,
    /// For people: what to do; empty where nothing is to be done.
    pub remedy: String,
    /// First sample concerned, counted from 0.
    pub sample: Option<usize>,
    /// Its time [s].
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

    /// Where it begins.
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
