//! Log messages: collected during a call, handed to the host after it, so that a host may do in its logger what it likes.

/// The standard log categories of FMI 2.0 that instances use, with their meaning.
pub const CATEGORIES: [(&str, &str); 6] = [
    ("logEvents", "changes of state of the slave"),
    ("logStatusWarning", "messages of calls that return fmi2Warning"),
    ("logStatusDiscard", "messages of calls that return fmi2Discard"),
    ("logStatusError", "messages of calls that return fmi2Error"),
    ("logStatusFatal", "messages of calls that return fmi2Fatal"),
    ("logAll", "all messages"),
];

/// FMI status with the number it has in C.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Not available.
    Discard = 2,
    /// Refused; nothing has changed.
    Error = 3,
    /// The instance is lost.
    Fatal = 4,
}

impl Status {
    /// Category of a message with this status.
    fn category(self) -> &'static str {
        match self {
            Self::Ok => "logEvents",
            Self::Discard => "logStatusDiscard",
            Self::Error => "logStatusError",
            Self::Fatal => "logStatusFatal",
        }
    }
}

/// A message for the host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Status of the call.
    pub status: Status,
    /// Standard category.
    pub category: &'static str,
    /// What happened.
    pub text: String,
}

/// Which messages the host wants, and those that wait for it.
#[derive(Debug, Default)]
pub struct Log {
    wanted: Wanted,
    waiting: Vec<Message>,
}

#[derive(Debug, Default, PartialEq)]
enum Wanted {
    /// Before the host says anything, and with `loggingOn = false` at instantiation: only what failed.
    #[default]
    Failures,
    Nothing,
    All,
    Some(Vec<String>),
}

impl Log {
    /// As `loggingOn` of `fmi2Instantiate`.
    pub fn new(logging_on: bool) -> Self {
        Self { wanted: if logging_on { Wanted::All } else { Wanted::Failures }, waiting: Vec::new() }
    }

    /// As `fmi2SetDebugLogging`: no category means all of them.
    pub fn set(&mut self, logging_on: bool, categories: &[String]) {
        self.wanted = match (logging_on, categories) {
            (false, _) => Wanted::Nothing,
            (true, []) => Wanted::All,
            (true, some) if some.iter().any(|name| name == "logAll") => Wanted::All,
            (true, some) => Wanted::Some(some.to_vec()),
        };
    }

    /// Adds a message if the host wants it.
    pub fn add(&mut self, status: Status, text: impl Into<String>) {
        let category = status.category();
        let wanted = match &self.wanted {
            Wanted::Nothing => false,
            Wanted::Failures => status >= Status::Error,
            Wanted::All => true,
            Wanted::Some(names) => names.iter().any(|name| name == category),
        };
        if wanted {
            self.waiting.push(Message { status, category, text: text.into() });
        }
    }

    /// Takes what waits.
    pub fn take(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.waiting)
    }
}
