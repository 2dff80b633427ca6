//! Log messages: collected during a call and passed to the host after it, so that the logger of a host may call the instance.

use std::sync::{
    Arc,
    atomic::{AtomicU8, Ordering},
};

/// The standard log categories of FMI 2.0 that instances use, with their meaning.
pub const CATEGORIES: [(&str, &str); 6] = [
    ("logEvents", "changes of state of the slave"),
    ("logStatusWarning", "messages of calls that return fmi2Warning"),
    ("logStatusDiscard", "messages of calls that return fmi2Discard"),
    ("logStatusError", "messages of calls that return fmi2Error"),
    ("logStatusFatal", "messages of calls that return fmi2Fatal"),
    ("logAll", "all messages"),
];

/// FMI status with its number in C.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Done, with a restriction that the message states.
    Warning = 1,
    /// Not available.
    Discard = 2,
    /// Refused; nothing changed.
    Error = 3,
    /// The instance is no longer usable.
    Fatal = 4,
}

impl Status {
    /// Place of the category of a message with this status in [`CATEGORIES`].
    fn index(self) -> usize {
        self as usize
    }

    /// Category of a message with this status.
    fn category(self) -> &'static str {
        CATEGORIES[self.index()].0
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

/// Messages passed to the host, one bit for each category. It may be queried during a call on the instance.
#[derive(Debug)]
pub struct Filter(AtomicU8);

const ALL: u8 = u8::MAX;

impl Filter {
    /// As `loggingOn` of `fmi2Instantiate`: with false, errors only.
    pub fn new(logging_on: bool) -> Self {
        let errors = [Status::Error, Status::Fatal].iter().fold(0, |bits, status| bits | 1 << status.index());
        Self(AtomicU8::new(if logging_on { ALL } else { errors }))
    }

    /// As `fmi2SetDebugLogging`: no category means all of them.
    fn set(&self, logging_on: bool, categories: &[String]) {
        let bit = |name: &String| CATEGORIES.iter().position(|(category, _)| category == name).map_or(0, |at| 1 << at);
        let bits = match (logging_on, categories) {
            (false, _) => 0,
            (true, []) => ALL,
            (true, some) if some.iter().any(|name| name == "logAll") => ALL,
            (true, some) => some.iter().fold(0, |bits, name| bits | bit(name)),
        };
        self.0.store(bits, Ordering::Relaxed);
    }

    /// The message, if it passes.
    pub fn message(&self, status: Status, text: impl FnOnce() -> String) -> Option<Message> {
        let passes = self.0.load(Ordering::Relaxed) & 1 << status.index() != 0;
        passes.then(|| Message { status, category: status.category(), text: text() })
    }
}

/// Filter of the host, and messages not yet passed to it.
#[derive(Debug)]
pub struct Log {
    filter: Arc<Filter>,
    pending: Vec<Message>,
    /// The present call has warned, whether the message passes the filter or not.
    has_warned: bool,
    /// It has warned, or a message is pending.
    has_news: bool,
}

impl Log {
    /// As `loggingOn` of `fmi2Instantiate`.
    pub fn new(logging_on: bool) -> Self {
        Self { filter: Arc::new(Filter::new(logging_on)), pending: Vec::new(), has_warned: false, has_news: false }
    }

    /// Its filter.
    pub fn filter(&self) -> Arc<Filter> {
        Arc::clone(&self.filter)
    }

    /// As `fmi2SetDebugLogging`: no category means all of them.
    pub fn set(&mut self, logging_on: bool, categories: &[String]) {
        self.filter.set(logging_on, categories);
    }

    /// Adds a message that passes the filter.
    pub fn add(&mut self, status: Status, text: impl FnOnce() -> String) {
        if let Some(message) = self.filter.message(status, text) {
            self.pending.push(message);
            self.has_news = true;
        }
    }

    /// Adds a warning: the call then returns `fmi2Warning`.
    #[cold]
    pub fn warn(&mut self, text: impl FnOnce() -> String) {
        (self.has_warned, self.has_news) = (true, true);
        self.add(Status::Warning, text);
    }

    /// True if there is nothing to report.
    #[inline]
    pub fn is_empty(&self) -> bool {
        !self.has_news
    }

    /// Status of a call that succeeded.
    pub fn take_status(&mut self) -> Status {
        if std::mem::take(&mut self.has_warned) { Status::Warning } else { Status::Ok }
    }

    /// Takes the pending messages.
    pub fn take(&mut self) -> Vec<Message> {
        self.has_news = false;
        std::mem::take(&mut self.pending)
    }
}
