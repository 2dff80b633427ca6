//! Why a call was refused: the thing, what was found, what is allowed, what to do.

use std::fmt;

use crate::log::Status;

/// Result of everything that can be refused.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a call was refused. The text reaches the host's log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    words: Box<str>,
    discarded: bool,
}

impl Error {
    /// `thing` was `found`; `allowed` says what would do.
    pub fn new(thing: impl fmt::Display, found: impl fmt::Display, allowed: impl fmt::Display) -> Self {
        Self::said(format!("{thing}: found {found}; allowed: {allowed}"))
    }

    /// With the words of another error.
    pub fn said(words: impl Into<String>) -> Self {
        Self { words: words.into().into_boxed_str(), discarded: false }
    }

    /// What the reader can do about it.
    #[must_use]
    pub fn remedy(self, remedy: impl fmt::Display) -> Self {
        Self { words: format!("{}; {remedy}", self.words).into_boxed_str(), ..self }
    }

    /// A call that is withdrawn (`fmi2Discard`), not refused: the host may try something else.
    #[must_use]
    pub fn discarded(self) -> Self {
        Self { discarded: true, ..self }
    }

    pub(crate) fn status(&self) -> Status {
        if self.discarded { Status::Discard } else { Status::Error }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
    }
}

impl std::error::Error for Error {}
