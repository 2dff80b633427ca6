//! Log messages: collected during a call and passed to the host after it, so that the logger of a host may call the instance.

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
    /// Refused; nothing changed.
    Error = 3,
    /// The instance is no longer usable.
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

/// Filter of the host, and messages not yet passed to it.
#[derive(Debug, Default)]
pub struct Log {
    filter: Filter,
    pending: Vec<Message>,
}

#[derive(Debug, Default, PartialEq)]
/// Which messages are passed to the host.
enum Filter {
    /// Initially, with `loggingOn = false` at instantiation: errors only.
    #[default]
    Failures,
    Nothing,
    All,
    Some(Vec<String>),
}

impl Log {
    /// As `loggingOn` of `fmi2Instantiate`.
    pub fn new(logging_on: bool) -> Self {
        Self { filter: if logging_on { Filter::All } else { Filter::Failures }, pending: Vec::new() }
    }

    /// As `fmi2SetDebugLogging`: no category means all of them.
    pub fn set(&mut self, logging_on: bool, categories: &[String]) {
        self.filter = match (logging_on, categories) {
            (false, _) => Filter::Nothing,
            (true, []) => Filter::All,
            (true, some) if some.iter().any(|name| name == "logAll") => Filter::All,
            (true, some) => Filter::Some(some.to_vec()),
        };
    }

    /// Adds a message that passes the filter.
    pub fn add(&mut self, status: Status, text: impl Into<String>) {
        let category = status.category();
        let passes = match &self.filter {
            Filter::Nothing => false,
            Filter::Failures => status >= Status::Error,
            Filter::All => true,
            Filter::Some(names) => names.iter().any(|name| name == category),
        };
        if passes {
            self.pending.push(Message { status, category, text: text.into() });
        }
    }

    /// Takes the pending messages.
    pub fn take(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.pending)
    }
}
