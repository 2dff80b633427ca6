//! A statement of the report, and its verdict from the tables.

use serde::Serialize;

/// Verdict of the tables on a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The tables confirm it.
    Agrees,
    /// The tables contradict it, at least in part.
    Contradicted,
    /// The tables are inconclusive.
    CannotBeChecked,
}

impl Verdict {
    /// In words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Contradicted => "contradicted",
            Self::CannotBeChecked => "cannot be checked",
        }
    }
}

/// One statement of the report and its verdict.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Statement {
    /// A name for it.
    pub name: &'static str,
    /// Section of the report.
    pub section: &'static str,
    /// The statement, paraphrased.
    pub claim: &'static str,
    /// The finding from the tables.
    pub finding: String,
    /// The outcome.
    pub verdict: Verdict,
}

impl Statement {
    pub(super) fn judged(
        section: &'static str,
        name: &'static str,
        claim: &'static str,
        holds: bool,
        finding: String,
    ) -> Self {
        let verdict = if holds { Verdict::Agrees } else { Verdict::Contradicted };
        Self { name, section, claim, finding, verdict }
    }

    pub(super) fn unchecked(section: &'static str, name: &'static str, claim: &'static str, why: &'static str) -> Self {
        Self { name, section, claim, finding: why.into(), verdict: Verdict::CannotBeChecked }
    }
}
