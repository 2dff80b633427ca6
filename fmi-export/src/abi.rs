//! The C boundary.
//!
//! Every call on an instance passes through [`Instances::guarded`]: the handle is looked up, never dereferenced, so that a NULL,
//! freed or invented one is refused; a panic becomes `fmi2Fatal`; messages go to the host after the instance is released.
//! Numbers cross as C integers, never as Rust enumerations; arrays are checked before they become slices (`arrays`). The
//! functions of the standard are in [`functions`], one for one; [`export!`](crate::export) gives them their C symbols.

mod arrays;
pub mod functions;
mod host;

use std::{
    any::Any,
    collections::BTreeMap,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Arc, LazyLock, Mutex, Once, RwLock,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
};

use libc::{c_char, c_int, c_void};

use arrays::{array, text};
pub use host::CallbackFunctions;
use host::Host;

use crate::{
    calls::Kind,
    error::{Error, Result},
    instance::Instance,
    log::{Message, Status},
    model::Model,
    request::Request,
};

/// `fmi2Component`: a number that stands for an instance.
pub type Component = *mut c_void;
/// `fmi2FMUstate`: a number that stands for a saved state.
pub type SavedState = *mut c_void;

struct Guarded<M: Model> {
    instance: Mutex<Instance<M>>,
    /// A panic has left it in an unknown state.
    is_unusable: AtomicBool,
    host: Host,
}

/// A tree, since a hash map needs random numbers at start-up, on Windows from a library that not every wine has.
type InstanceTable<M> = RwLock<BTreeMap<usize, Arc<Guarded<M>>>>;

/// Instances by handle. A handle is a unique number that the host receives as a pointer.
pub struct Instances<M: Model>(LazyLock<InstanceTable<M>>);

static NEXT_HANDLE: AtomicUsize = AtomicUsize::new(0x4000_0000);
const HANDLE_STEP: usize = 16;

impl<M: Model> Default for Instances<M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<M: Model> Instances<M> {
    /// None yet.
    #[must_use]
    pub const fn new() -> Self {
        Self(LazyLock::new(RwLock::default))
    }

    /// Runs one call on an instance. An error becomes its status.
    fn guarded(&self, component: Component, name: &str, body: impl FnOnce(&mut Instance<M>) -> Result<()>) -> c_int {
        let found = self.0.read().ok().and_then(|instances| instances.get(&(component as usize)).cloned());
        let Some(guarded) = found else { return Status::Error as c_int };
        let (status, messages) = match guarded.instance.try_lock() {
            Ok(_) if guarded.is_unusable.load(Ordering::Relaxed) => (
                Status::Fatal,
                vec![failure(
                    Status::Fatal,
                    format!("{name}: found an instance lost in an earlier call; allowed: fmi2FreeInstance"),
                )],
            ),
            Ok(mut instance) => {
                let outcome = catch_unwind(AssertUnwindSafe(|| body(&mut instance)));
                let status = match outcome {
                    Ok(Ok(())) => Status::Ok,
                    Ok(Err(error)) => {
                        instance.log.add(error.status(), format!("{name}: {error}"));
                        error.status()
                    }
                    Err(panic) => {
                        guarded.is_unusable.store(true, Ordering::Relaxed);
                        instance.log.add(
                            Status::Fatal,
                            format!("{name}: internal error: {}; please report it", reason(panic.as_ref())),
                        );
                        Status::Fatal
                    }
                };
                (status, instance.log.take())
            }
            Err(_) => (
                Status::Error,
                vec![failure(
                    Status::Error,
                    format!("{name}: found another call on this instance; allowed: one at a time"),
                )],
            ),
        };
        guarded.host.log(messages);
        status as c_int
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
        let callbacks = array("functions", callbacks, 1).ok().and_then(|some| some.first().copied());
        let name = text(name).filter(|name| !name.is_empty());
        let host = Host::new(name.as_deref(), callbacks);
        let made = (|| {
            let name = name.ok_or_else(|| Error::new("instanceName", "NULL or nothing", "a name"))?;
            let kind = kind_of::<M>(kind)?;
            let start = M::start(&Request { name, kind, guid: text(guid), resources: text(resources) })?;
            Ok(Instance::of_kind(kind, start, logging_on))
        })();
        match made {
            Ok(instance) => {
                let handle = NEXT_HANDLE.fetch_add(HANDLE_STEP, Ordering::Relaxed);
                let guarded = Guarded { instance: Mutex::new(instance), is_unusable: AtomicBool::new(false), host };
                let Ok(mut instances) = self.0.write() else { return std::ptr::null_mut() };
                instances.insert(handle, Arc::new(guarded));
                handle as Component
            }
            Err(error) => {
                let error: Error = error;
                host.log(vec![failure(Status::Error, format!("fmi2Instantiate: {error}"))]);
                std::ptr::null_mut()
            }
        }
    }

    fn free(&self, component: Component) {
        let removed = self.0.write().ok().and_then(|mut instances| instances.remove(&(component as usize)));
        drop(removed);
    }
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

fn failure(status: Status, text: String) -> Message {
    let category = if status == Status::Fatal { "logStatusFatal" } else { "logStatusError" };
    Message { status, category, text }
}

fn reason(panic: &(dyn Any + Send)) -> &str {
    panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no reason given")
}
