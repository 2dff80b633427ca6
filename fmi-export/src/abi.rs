//! The C boundary.
//!
//! Every call on an instance passes through `Instances::guarded`: the handle is looked up, never dereferenced (`table`), so that a NULL,
//! freed or invalid one is refused; a concurrent call on an instance is refused (`exclusive`); a panic becomes `fmi2Fatal`; messages go to
//! the host after the call (`host`). Instances share no lock unless there is a message. Numbers cross as C integers, never as Rust
//! enumerations; arrays are checked, and read and written element by element (`arrays`). The functions of the standard are in
//! [`functions`], one for one; [`export!`](crate::export) gives them their C symbols.

mod arrays;
mod barrier;
mod exclusive;
pub mod functions;
mod host;
pub(crate) mod library;
mod table;
mod thread;

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Once},
};

use libc::{c_char, c_int, c_void};

use arrays::{Place, text};
pub use host::CallbackFunctions;
use host::Host;
use table::{Absent, Entered, Table};

use crate::{
    calls::Kind,
    error::{Error, Result},
    instance::Instance,
    log::{Filter, Status},
    model::Model,
    request::Request,
};

/// `fmi2Component`: a number that identifies an instance.
pub type Component = *mut c_void;
/// `fmi2FMUstate`: a number that identifies a saved state.
pub type SavedState = *mut c_void;

struct Guarded<M: Model> {
    instance: Instance<M>,
    host: Arc<Host>,
}

/// Instances by handle. A handle is a unique number that the host receives as a pointer.
pub struct Instances<M: Model>(Table<Guarded<M>, Host>);

impl<M: Model> Default for Instances<M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<M: Model> Instances<M> {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self(Table::new())
    }

    /// Runs one call on an instance. An error becomes its status.
    #[inline(never)]
    fn guarded(&self, component: Component, name: &str, body: impl FnOnce(&mut Instance<M>) -> Result<()>) -> c_int {
        let mut entered = match self.0.enter(component as usize) {
            Ok(entered) => entered,
            Err(absent) => return refused(absent, name),
        };
        let Some(Guarded { instance, .. }) = entered.get() else { return Status::Error as c_int };
        let outcome = catch_unwind(AssertUnwindSafe(|| body(instance)));
        if matches!(outcome, Ok(Ok(()))) && instance.log.is_empty() {
            return Status::Ok as c_int;
        }
        ended(entered, name, outcome)
    }

    /// As above in a few instructions, for frequent calls: if this thread owns the instance and no call is active. Otherwise `None`, with
    /// nothing done; the general path is then taken.
    #[inline(always)]
    fn guarded_as_owner(
        &self,
        component: Component,
        name: &'static str,
        body: impl FnOnce(&mut Instance<M>) -> Result<()>,
    ) -> Option<c_int> {
        let mut entered = self.0.enter_as_owner(component as usize)?;
        let Guarded { instance, .. } = entered.get()?;
        let outcome = catch_unwind(AssertUnwindSafe(|| body(instance)));
        if matches!(outcome, Ok(Ok(()))) && instance.log.is_empty() {
            return Some(Status::Ok as c_int);
        }
        Some(ended(entered.into(), name, outcome))
    }

    fn instantiate(
        &self,
        name: *const c_char,
        kind: c_int,
        guid: *const c_char,
        resources: *const c_char,
        callbacks: *const CallbackFunctions,
        logging_on: bool,
    ) -> Component {
        static REPLACE_HOOK: Once = Once::new();
        // A panic is reported through the host's logger; the default hook would write to the host's standard error.
        REPLACE_HOOK.call_once(|| std::panic::set_hook(Box::new(|_| {})));
        let callbacks = Place::new("functions", callbacks.cast_mut()).ok().map(Place::read);
        let name = text(name).filter(|name| !name.is_empty());
        let given = name.clone();
        let made = catch_unwind(AssertUnwindSafe(|| {
            let name = given.ok_or_else(|| Error::new("instanceName", "NULL or nothing", "a name"))?;
            let kind = kind_of::<M>(kind)?;
            let start = M::start(&Request { name, kind, guid: text(guid), resources: text(resources) })?;
            Ok(Box::new(Instance::of_kind(kind, start, logging_on)))
        }));
        let refusal: Error = match made {
            Ok(Ok(instance)) => {
                let host = Arc::new(Host::new(name.as_deref(), callbacks, instance.log.filter()));
                let guarded = Guarded { instance: *instance, host: Arc::clone(&host) };
                match self.0.insert(Box::new(guarded), host) {
                    Some(handle) => return handle as Component,
                    None => Error::new("instances", "as many as there are handles", "fewer"),
                }
            }
            Ok(Err(error)) => error,
            Err(panic) => Error::from_message(internal_error(panic.as_ref())),
        };
        let host = Arc::new(Host::new(name.as_deref(), callbacks, Arc::new(Filter::new(logging_on))));
        host::defer(&host, host.filter.message(Status::Error, || format!("fmi2Instantiate: {refusal}")));
        std::ptr::null_mut()
    }

    fn free(&self, component: Component) {
        drop(self.0.remove(component as usize));
    }
}

/// Added to a status if messages wait for the logger.
const HAS_MESSAGES: c_int = 1 << 16;

fn with_messages(status: Status, has_messages: bool) -> c_int {
    status as c_int | if has_messages { HAS_MESSAGES } else { 0 }
}

/// Return value of a function of the standard, once the logger of the host has its messages. Neither this function nor its caller has
/// anything to clean up after an exception of that logger.
pub trait Returned: Copy {
    /// The value for the host.
    fn delivered(self) -> Self;
}

impl Returned for c_int {
    #[inline]
    fn delivered(self) -> Self {
        if self & HAS_MESSAGES == 0 {
            return self;
        }
        host::log_deferred();
        self & !HAS_MESSAGES
    }
}

impl Returned for Component {
    fn delivered(self) -> Self {
        host::log_deferred();
        self
    }
}

impl Returned for *const c_char {
    fn delivered(self) -> Self {
        self
    }
}

impl Returned for () {
    fn delivered(self) {}
}

/// Ends a call that did not simply succeed: its status, with its messages queued for the host.
#[cold]
#[inline(never)]
fn ended<M: Model>(
    mut entered: Entered<'_, Guarded<M>>,
    name: &str,
    outcome: std::thread::Result<Result<()>>,
) -> c_int {
    let Some(Guarded { instance, host }) = entered.get() else { return Status::Error as c_int };
    let host = Arc::clone(host);
    let status = match outcome {
        Ok(Ok(())) => instance.log.take_status(),
        Ok(Err(error)) => {
            instance.log.add(error.status(), || format!("{name}: {error}"));
            error.status()
        }
        Err(panic) => {
            instance.log.add(Status::Fatal, || format!("{name}: {}", internal_error(panic.as_ref())));
            Status::Fatal
        }
    };
    let messages = instance.log.take();
    if status == Status::Fatal {
        // The panic has left it in an unknown state, in which its destructor may panic as well.
        let lost = entered.lose();
        drop(catch_unwind(AssertUnwindSafe(|| drop(lost))));
    }
    drop(entered);
    with_messages(status, host::defer(&host, messages))
}

/// The status of a call on an instance that does not exist, is busy or is lost.
#[cold]
fn refused(absent: Absent<Host>, name: &str) -> c_int {
    let (status, host, found, allowed) = match absent {
        Absent::Unknown => return Status::Error as c_int,
        Absent::Busy(host) => (Status::Error, host, "another call on this instance", "one at a time"),
        Absent::Lost(host) => (Status::Fatal, host, "an instance lost in an earlier call", "fmi2FreeInstance"),
    };
    let text = || format!("{name}: found {found}; allowed: {allowed}");
    with_messages(status, host::defer(&host, host.filter.message(status, text)))
}

/// Numbers and names of `fmi2Type`.
const KINDS: [(c_int, Kind, &str); 2] =
    [(0, Kind::ModelExchange, "fmi2ModelExchange"), (1, Kind::CoSimulation, "fmi2CoSimulation")];

fn kind_of<M: Model>(number: c_int) -> Result<Kind> {
    let offered = || KINDS.iter().filter(|(_, kind, _)| M::KINDS.contains(kind));
    offered().find(|(other, ..)| *other == number).map(|(_, kind, _)| *kind).ok_or_else(|| {
        let allowed: Vec<String> = offered().map(|(number, _, name)| format!("{number} ({name})")).collect();
        Error::new("fmuType", number, allowed.join(", "))
    })
}

fn internal_error(panic: &(dyn Any + Send)) -> String {
    let reason = panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no reason given");
    format!("internal error: {reason}; please report it")
}
