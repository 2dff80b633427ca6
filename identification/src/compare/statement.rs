//! A statement of the report, and how it stands against the tables.

use serde::Serialize;

/// How a statement stands against the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The tables bear it out.
    Agrees,
    /// The tables say otherwise, at least in part.
    Contradicted,
    /// The tables cannot settle it.
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

/// One statement of the report and how it stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Statement {
    /// A name for it.
    pub name: &'static str,
    /// Section of the report.
    pub section: &'static str,
    /// What it says, in other words.
    pub claim: &'static str,
    /// What the tables give.
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
