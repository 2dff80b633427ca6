//! Why a call was refused: the thing, what was found, what is allowed, what to do.

use std::fmt;

use crate::log::Status;

/// Result of a call that can be refused.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a call was refused. The text reaches the host's log.
///
/// One pointer, so that the result of a successful call fits in a register.
#[derive(Debug, Clone, PartialEq)]
pub struct Error(Box<Refusal>);

#[derive(Debug, Clone, PartialEq)]
struct Refusal {
    message: String,
    discarded: bool,
    reached: Option<f64>,
}

impl Error {
    /// `thing` was `found`; `allowed` names what is valid.
    #[cold]
    pub fn new(thing: impl fmt::Display, found: impl fmt::Display, allowed: impl fmt::Display) -> Self {
        Self::from_message(format!("{thing}: found {found}; allowed: {allowed}"))
    }

    /// With the message of another error.
    pub fn from_message(message: impl Into<String>) -> Self {
        Self(Box::new(Refusal { message: message.into(), discarded: false, reached: None }))
    }

    /// Adds what the reader can do about it.
    #[must_use]
    pub fn remedy(mut self, remedy: impl fmt::Display) -> Self {
        self.0.message = format!("{}; {remedy}", self.0.message);
        self
    }

    /// As `fmi2Discard`: the host may repeat the call with other values, such as a shorter step.
    #[must_use]
    pub fn discarded(mut self) -> Self {
        self.0.discarded = true;
        self
    }

    /// As `fmi2Discard` of a step that ended early, at this time \[s\]: the state is that at this time, and the host may continue from it.
    #[must_use]
    pub fn discarded_at(mut self, time: f64) -> Self {
        self.0.reached = Some(time);
        self.discarded()
    }

    pub(crate) fn reached(&self) -> Option<f64> {
        self.0.reached
    }

    pub(crate) fn status(&self) -> Status {
        if self.0.discarded { Status::Discard } else { Status::Error }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.message)
    }
}

impl std::error::Error for Error {}
