//! The C boundary: every function of FMI 2.0 for co-simulation, and the only unsafe code of this crate.
//!
//! Every call on an instance passes through [`guarded`]: the handle is looked up, never dereferenced, so that a NULL, freed or
//! invented one is refused; a panic becomes `fmi2Fatal`; messages go to the host after the instance is released. Numbers
//! cross as C integers, never as Rust enumerations; arrays are checked for NULL, alignment and length before they become
//! slices.
#![allow(unsafe_code)]

use std::{
    any::Any,
    collections::HashMap,
    ffi::{CStr, CString},
    panic::{AssertUnwindSafe, catch_unwind},
    path::PathBuf,
    sync::{
        Arc, LazyLock, Mutex, Once, RwLock,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
};

use libc::{c_char, c_double, c_int, c_uint, c_void, size_t};

use super::{
    MODEL_RESOURCE, Settings, Slave, Value, guid,
    log::{CATEGORIES, Message, Status},
};
use crate::{
    error::{Error, Result},
    parameters::Model,
};

type Component = *mut c_void;
type SavedState = *mut c_void;
type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`. Memory management of the host is not used.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    logger: Option<Logger>,
    allocate_memory: Option<unsafe extern "C" fn(size_t, size_t) -> *mut c_void>,
    free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    component_environment: *mut c_void,
}

/// Where the messages of an instance go.
struct Host {
    name: CString,
    logger: Option<Logger>,
    environment: *mut c_void,
}

// SAFETY: the environment is never dereferenced here, only handed back to the host's own logger, and only within calls that the
// host makes, on the thread on which it makes them.
unsafe impl Send for Host {}
// SAFETY: as above.
unsafe impl Sync for Host {}

impl Host {
    fn tell(&self, messages: Vec<Message>) {
        let Some(logger) = self.logger else { return };
        for Message { status, category, text } in messages {
            // The text is a printf format for the host: a percent sign in it must not be taken for a directive.
            let text = text.replace('\0', " ").replace('%', "%%");
            if let (Ok(category), Ok(text)) = (CString::new(category), CString::new(text)) {
                // SAFETY: the host gave this function as its logger; all strings live through the call.
                unsafe {
                    logger(self.environment, self.name.as_ptr(), status as c_int, category.as_ptr(), text.as_ptr())
                };
            }
        }
    }
}

struct Instance {
    slave: Mutex<Slave>,
    lost: AtomicBool,
    host: Host,
}

/// Live instances by handle. A handle is a number, used once; the host sees it as a pointer.
static INSTANCES: LazyLock<RwLock<HashMap<usize, Arc<Instance>>>> = LazyLock::new(RwLock::default);
static NEXT_HANDLE: AtomicUsize = AtomicUsize::new(0x4000_0000);
const HANDLE_STEP: usize = 16;

/// More elements than any importer could mean; guards the multiplication by the element's size.
const LONGEST_ARRAY: usize = 1 << 28;

/// Runs one call on an instance. `refusal` is the status of an error.
fn guarded(component: Component, name: &str, refusal: Status, body: impl FnOnce(&mut Slave) -> Result<()>) -> c_int {
    let found = INSTANCES.read().ok().and_then(|instances| instances.get(&(component as usize)).cloned());
    let Some(instance) = found else { return Status::Error as c_int };
    let (status, messages) = match instance.slave.try_lock() {
        Ok(_) if instance.lost.load(Ordering::Relaxed) => (
            Status::Fatal,
            vec![failure(
                Status::Fatal,
                format!("{name}: found an instance lost in an earlier call; allowed: fmi2FreeInstance"),
            )],
        ),
        Ok(mut slave) => {
            let outcome = catch_unwind(AssertUnwindSafe(|| body(&mut slave)));
            let status = match outcome {
                Ok(Ok(())) => Status::Ok,
                Ok(Err(error)) => {
                    slave.log.add(refusal, format!("{name}: {error}"));
                    refusal
                }
                Err(panic) => {
                    instance.lost.store(true, Ordering::Relaxed);
                    slave.log.add(
                        Status::Fatal,
                        format!("{name}: internal error: {}; please report it", reason(panic.as_ref())),
                    );
                    Status::Fatal
                }
            };
            (status, slave.log.take())
        }
        Err(_) => (
            Status::Error,
            vec![failure(
                Status::Error,
                format!("{name}: found another call on this instance; allowed: one at a time"),
            )],
        ),
    };
    instance.host.tell(messages);
    status as c_int
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

fn call(component: Component, name: &str, body: impl FnOnce(&mut Slave) -> Result<()>) -> c_int {
    guarded(component, name, Status::Error, body)
}

fn check_array<T>(name: &str, start: *const T, length: usize) -> Result<()> {
    let refuse = |found: String, allowed: &str| Err(Error::new(format!("array {name}"), found, allowed));
    if start.is_null() {
        refuse("NULL".into(), "a pointer to as many elements as announced")
    } else if !start.is_aligned() {
        refuse(format!("{start:p}"), "a pointer aligned for its type")
    } else if length > LONGEST_ARRAY {
        refuse(format!("{length} elements"), &format!("at most {LONGEST_ARRAY}"))
    } else {
        Ok(())
    }
}

fn array<'a, T>(name: &str, start: *const T, length: usize) -> Result<&'a [T]> {
    if length == 0 {
        return Ok(&[]);
    }
    check_array(name, start, length)?;
    // SAFETY: not NULL, aligned, of a length that cannot overflow; that so many elements are there is the host's promise.
    Ok(unsafe { std::slice::from_raw_parts(start, length) })
}

fn array_mut<'a, T>(name: &str, start: *mut T, length: usize) -> Result<&'a mut [T]> {
    if length == 0 {
        return Ok(&mut []);
    }
    check_array(name, start, length)?;
    // SAFETY: as in `array`; the host does not use the array while we fill it.
    Ok(unsafe { std::slice::from_raw_parts_mut(start, length) })
}

fn place<'a, T>(name: &str, at: *mut T) -> Result<&'a mut T> {
    check_array(name, at, 1)?;
    // SAFETY: not NULL and aligned; that it points to a `T` is the host's promise.
    Ok(unsafe { &mut *at })
}

fn text(start: *const c_char) -> Option<String> {
    // SAFETY: not NULL; that it ends in a zero byte is the host's promise.
    (!start.is_null()).then(|| unsafe { CStr::from_ptr(start) }.to_string_lossy().into_owned())
}

/// Path of `fmuResourceLocation`: `file:/x`, `file:///x`, `file:////x`, `file://localhost/x`, or a path as it is.
fn resource_path(uri: &str) -> PathBuf {
    let Some(rest) = uri.strip_prefix("file:") else { return PathBuf::from(uri) };
    let rest = rest.strip_prefix("//localhost").unwrap_or(rest);
    let slashes = rest.len() - rest.trim_start_matches('/').len();
    let mut path = rest[slashes.saturating_sub(1)..].to_owned();
    // On Windows `file:///C:/x` is `C:/x`.
    if cfg!(windows) && path.starts_with('/') && path[1..].contains(':') {
        path.remove(0);
    }
    let bytes = path.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut index = 0;
    while index < bytes.len() {
        let hex = (bytes[index] == b'%').then(|| path.get(index + 1..index + 3)).flatten();
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                decoded.push(byte);
                index += 3;
            }
            None => {
                decoded.push(bytes[index]);
                index += 1;
            }
        }
    }
    PathBuf::from(String::from_utf8_lossy(&decoded).into_owned())
}

/// Start values of the model with this GUID: our own, or those of the model file in the resources.
fn start_values(wanted: Option<String>, resources: Option<String>) -> Result<Settings> {
    let own = Settings::default();
    let wanted = wanted.ok_or_else(|| Error::new("fmuGUID", "NULL", guid(&own)))?;
    if wanted == guid(&own) {
        return Ok(own);
    }
    let remedy = "take binary and modelDescription.xml from the same FMU";
    let refuse = |found: String| Error::new("fmuGUID", found, guid(&own)).remedy(remedy);
    let folder = resources.ok_or_else(|| refuse(format!("{wanted} and no fmuResourceLocation")))?;
    let file = resource_path(&folder).join(MODEL_RESOURCE);
    let text =
        std::fs::read_to_string(&file).map_err(|error| refuse(format!("{wanted}, and {}: {error}", file.display())))?;
    let start = Settings::from_model(&Model::parse(&text).map_err(|error| error.at(&file, None))?);
    if guid(&start) == wanted {
        Ok(start)
    } else {
        Err(Error::new("fmuGUID", wanted, format!("{} or {}", guid(&own), guid(&start))).remedy(remedy).at(file, None))
    }
}

const CO_SIMULATION: c_int = 1;

fn instantiate(
    name: *const c_char,
    kind: c_int,
    guid: *const c_char,
    resources: *const c_char,
    callbacks: *const CallbackFunctions,
    logging_on: bool,
) -> Component {
    static QUIET: Once = Once::new();
    // A panic is reported through the host's logger; the default hook would write to the host's standard error.
    QUIET.call_once(|| std::panic::set_hook(Box::new(|_| {})));
    let callbacks = array("functions", callbacks, 1).ok().and_then(|some| some.first().copied());
    let name_given = text(name).filter(|name| !name.is_empty());
    let host = Host {
        name: CString::new(name_given.clone().unwrap_or_default().replace('\0', "")).unwrap_or_default(),
        logger: callbacks.and_then(|callbacks| callbacks.logger),
        environment: callbacks.map_or(std::ptr::null_mut(), |callbacks| callbacks.component_environment),
    };
    let made = (|| {
        if name_given.is_none() {
            return Err(Error::new("instanceName", "NULL or nothing", "a name"));
        }
        if kind != CO_SIMULATION {
            return Err(Error::new("fmuType", kind.to_string(), "1 (fmi2CoSimulation)"));
        }
        start_values(text(guid), text(resources))
    })();
    match made {
        Ok(start) => {
            let handle = NEXT_HANDLE.fetch_add(HANDLE_STEP, Ordering::Relaxed);
            let instance =
                Instance { slave: Mutex::new(Slave::new(start, logging_on)), lost: AtomicBool::new(false), host };
            let Ok(mut instances) = INSTANCES.write() else { return std::ptr::null_mut() };
            instances.insert(handle, Arc::new(instance));
            handle as Component
        }
        Err(error) => {
            host.tell(vec![failure(Status::Error, format!("fmi2Instantiate: {error}"))]);
            std::ptr::null_mut()
        }
    }
}

fn get<T>(
    component: Component,
    name: &str,
    references: *const c_uint,
    n: size_t,
    values: *mut T,
    pick: impl Fn(&Slave, u32) -> Result<T>,
) -> c_int {
    call(component, name, |slave| {
        let (references, values) = (array("vr", references, n)?, array_mut("value", values, n)?);
        for (value, reference) in values.iter_mut().zip(references) {
            *value = pick(slave, *reference)?;
        }
        Ok(())
    })
}

fn set<T: Copy>(
    component: Component,
    name: &str,
    references: *const c_uint,
    n: size_t,
    values: *const T,
    wrap: impl Fn(T) -> Value + Clone,
) -> c_int {
    call(component, name, |slave| {
        let (references, values) = (array("vr", references, n)?, array("value", values, n)?);
        slave.set(references.iter().copied().zip(values.iter().map(|value| wrap(*value))))
    })
}

/// Strings: this model has none, so that every reference is a wrong one.
fn none_of_type(component: Component, name: &str, references: *const c_uint, n: size_t) -> c_int {
    call(component, name, |_| match array("vr", references, n)?.first() {
        None => Ok(()),
        Some(reference) => {
            Err(Error::new("value reference", reference.to_string(), "none: the model has no variable of this type"))
        }
    })
}

fn handle(state: SavedState) -> Option<usize> {
    (!state.is_null()).then_some(state as usize)
}

fn given(state: SavedState) -> Result<usize> {
    handle(state).ok_or_else(|| Error::new("FMUstate", "NULL", "a saved state"))
}

/// Declares exported functions: name, arguments, result, body. The bodies are safe code.
macro_rules! export {
    ($($name:ident($($argument:ident: $kind:ty),* $(,)?) -> $result:ty $body:block)+) => {
        $(
            #[doc = concat!("FMI 2.0 `", stringify!($name), "`")]
            #[allow(non_snake_case)]
            // SAFETY: the names are those of FMI 2.0, which nothing else in this library defines.
            #[unsafe(no_mangle)]
            pub extern "C" fn $name($($argument: $kind),*) -> $result $body
        )+
    };
}

export! {
    fmi2GetTypesPlatform() -> *const c_char { c"default".as_ptr() }

    fmi2GetVersion() -> *const c_char { c"2.0".as_ptr() }

    fmi2Instantiate(name: *const c_char, kind: c_int, guid: *const c_char, resources: *const c_char, functions: *const CallbackFunctions, _visible: c_int, logging_on: c_int) -> Component {
        catch_unwind(|| instantiate(name, kind, guid, resources, functions, logging_on != 0)).unwrap_or(std::ptr::null_mut())
    }

    fmi2FreeInstance(component: Component) -> () {
        let removed = INSTANCES.write().ok().and_then(|mut instances| instances.remove(&(component as usize)));
        drop(removed);
    }

    fmi2SetDebugLogging(component: Component, logging_on: c_int, n: size_t, categories: *const *const c_char) -> c_int {
        call(component, "fmi2SetDebugLogging", |slave| {
            let names: Vec<String> = array("categories", categories, n)?.iter().map(|name| text(*name).unwrap_or_default()).collect();
            let known = CATEGORIES.map(|(name, _)| name);
            if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
                return Err(Error::new("log category", format!("`{name}`"), known.join(", ")));
            }
            slave.log.set(logging_on != 0, &names);
            Ok(())
        })
    }

    fmi2SetupExperiment(component: Component, _tolerance_defined: c_int, _tolerance: c_double, start: c_double, stop_defined: c_int, stop: c_double) -> c_int {
        call(component, "fmi2SetupExperiment", |slave| slave.setup_experiment(start, (stop_defined != 0).then_some(stop)))
    }

    fmi2EnterInitializationMode(component: Component) -> c_int {
        call(component, "fmi2EnterInitializationMode", Slave::enter_initialization_mode)
    }

    fmi2ExitInitializationMode(component: Component) -> c_int {
        call(component, "fmi2ExitInitializationMode", Slave::exit_initialization_mode)
    }

    fmi2Terminate(component: Component) -> c_int { call(component, "fmi2Terminate", Slave::terminate) }

    fmi2Reset(component: Component) -> c_int { call(component, "fmi2Reset", Slave::reset) }

    fmi2GetReal(component: Component, references: *const c_uint, n: size_t, values: *mut c_double) -> c_int {
        get(component, "fmi2GetReal", references, n, values, Slave::get_real)
    }

    fmi2GetInteger(component: Component, references: *const c_uint, n: size_t, values: *mut c_int) -> c_int {
        get(component, "fmi2GetInteger", references, n, values, Slave::get_integer)
    }

    fmi2GetBoolean(component: Component, references: *const c_uint, n: size_t, values: *mut c_int) -> c_int {
        get(component, "fmi2GetBoolean", references, n, values, |slave, reference| slave.get_boolean(reference).map(c_int::from))
    }

    fmi2GetString(component: Component, references: *const c_uint, n: size_t, _values: *mut *const c_char) -> c_int {
        none_of_type(component, "fmi2GetString", references, n)
    }

    fmi2SetReal(component: Component, references: *const c_uint, n: size_t, values: *const c_double) -> c_int {
        set(component, "fmi2SetReal", references, n, values, Value::Real)
    }

    fmi2SetInteger(component: Component, references: *const c_uint, n: size_t, values: *const c_int) -> c_int {
        set(component, "fmi2SetInteger", references, n, values, Value::Integer)
    }

    fmi2SetBoolean(component: Component, references: *const c_uint, n: size_t, values: *const c_int) -> c_int {
        set(component, "fmi2SetBoolean", references, n, values, |value| Value::Boolean(value != 0))
    }

    fmi2SetString(component: Component, references: *const c_uint, n: size_t, _values: *const *const c_char) -> c_int {
        none_of_type(component, "fmi2SetString", references, n)
    }

    fmi2GetFMUstate(component: Component, state: *mut SavedState) -> c_int {
        call(component, "fmi2GetFMUstate", |slave| {
            let state = place("FMUstate", state)?;
            *state = slave.save(handle(*state))? as SavedState;
            Ok(())
        })
    }

    fmi2SetFMUstate(component: Component, state: SavedState) -> c_int {
        call(component, "fmi2SetFMUstate", |slave| slave.restore(given(state)?))
    }

    fmi2FreeFMUstate(component: Component, state: *mut SavedState) -> c_int {
        call(component, "fmi2FreeFMUstate", |slave| {
            // The standard: freeing NULL, or what a NULL pointer would point to, does nothing.
            if state.is_null() {
                return Ok(());
            }
            let state = place("FMUstate", state)?;
            if let Some(handle) = handle(*state) {
                slave.free(handle)?;
                *state = std::ptr::null_mut();
            }
            Ok(())
        })
    }

    fmi2SerializedFMUstateSize(component: Component, state: SavedState, size: *mut size_t) -> c_int {
        call(component, "fmi2SerializedFMUstateSize", |slave| {
            *place("size", size)? = slave.serialize(given(state)?)?.len();
            Ok(())
        })
    }

    fmi2SerializeFMUstate(component: Component, state: SavedState, bytes: *mut c_char, size: size_t) -> c_int {
        call(component, "fmi2SerializeFMUstate", |slave| {
            let written = slave.serialize(given(state)?)?;
            if size < written.len() {
                return Err(Error::new("size", size.to_string(), format!("{} or more", written.len())));
            }
            array_mut("serializedState", bytes.cast::<u8>(), size)?[..written.len()].copy_from_slice(&written);
            Ok(())
        })
    }

    fmi2DeSerializeFMUstate(component: Component, bytes: *const c_char, size: size_t, state: *mut SavedState) -> c_int {
        call(component, "fmi2DeSerializeFMUstate", |slave| {
            let state = place("FMUstate", state)?;
            let bytes = array("serializedState", bytes.cast::<u8>(), size)?;
            *state = slave.deserialize(bytes, handle(*state))? as SavedState;
            Ok(())
        })
    }

    fmi2GetDirectionalDerivative(component: Component, unknowns: *const c_uint, n_unknowns: size_t, knowns: *const c_uint, n_knowns: size_t, seed: *const c_double, sensitivity: *mut c_double) -> c_int {
        call(component, "fmi2GetDirectionalDerivative", |slave| {
            let (unknowns, knowns) = (array("vUnknown_ref", unknowns, n_unknowns)?, array("vKnown_ref", knowns, n_knowns)?);
            let (seed, sensitivity) = (array("dvKnown", seed, n_knowns)?, array_mut("dvUnknown", sensitivity, n_unknowns)?);
            for (sum, unknown) in sensitivity.iter_mut().zip(unknowns) {
                *sum = 0.0;
                for (known, seed) in knowns.iter().zip(seed) {
                    *sum += slave.partial_derivative(*unknown, *known)? * seed;
                }
            }
            Ok(())
        })
    }

    fmi2SetRealInputDerivatives(component: Component, references: *const c_uint, n: size_t, orders: *const c_int, values: *const c_double) -> c_int {
        call(component, "fmi2SetRealInputDerivatives", |slave| {
            let (references, orders, values) = (array("vr", references, n)?, array("order", orders, n)?, array("value", values, n)?);
            let items: Vec<_> = references.iter().zip(orders).zip(values).map(|((reference, order), value)| (*reference, *order, *value)).collect();
            slave.set_input_derivatives(&items)
        })
    }

    fmi2GetRealOutputDerivatives(component: Component, references: *const c_uint, n: size_t, orders: *const c_int, values: *mut c_double) -> c_int {
        call(component, "fmi2GetRealOutputDerivatives", |slave| {
            let (references, orders, values) = (array("vr", references, n)?, array("order", orders, n)?, array_mut("value", values, n)?);
            for (value, (reference, order)) in values.iter_mut().zip(references.iter().zip(orders)) {
                *value = slave.output_derivative(*reference, *order)?;
            }
            Ok(())
        })
    }

    fmi2DoStep(component: Component, current: c_double, duration: c_double, _no_set_state_prior: c_int) -> c_int {
        call(component, "fmi2DoStep", |slave| slave.do_step(current, duration))
    }

    fmi2CancelStep(component: Component) -> c_int { call(component, "fmi2CancelStep", |slave| slave.cancel_step()) }

    fmi2GetStatus(component: Component, kind: c_int, value: *mut c_int) -> c_int {
        status(component, "fmi2GetStatus", kind, DO_STEP_STATUS, value, |_| Ok(Status::Ok as c_int))
    }

    fmi2GetRealStatus(component: Component, kind: c_int, value: *mut c_double) -> c_int {
        status(component, "fmi2GetRealStatus", kind, LAST_SUCCESSFUL_TIME, value, Slave::last_successful_time)
    }

    fmi2GetIntegerStatus(component: Component, kind: c_int, value: *mut c_int) -> c_int {
        status(component, "fmi2GetIntegerStatus", kind, NO_STATUS, value, |_| Ok(0))
    }

    fmi2GetBooleanStatus(component: Component, kind: c_int, value: *mut c_int) -> c_int {
        status(component, "fmi2GetBooleanStatus", kind, TERMINATED, value, |_| Ok(0))
    }

    fmi2GetStringStatus(component: Component, kind: c_int, value: *mut *const c_char) -> c_int {
        status(component, "fmi2GetStringStatus", kind, PENDING_STATUS, value, |_| Ok(c"".as_ptr()))
    }
}

const NO_STATUS: c_int = -1;
const DO_STEP_STATUS: c_int = 0;
const PENDING_STATUS: c_int = 1;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

/// Steps are never pending, so that each kind of status has one answer; another kind is discarded.
fn status<T>(
    component: Component,
    name: &str,
    kind: c_int,
    answered: c_int,
    value: *mut T,
    answer: impl FnOnce(&Slave) -> Result<T>,
) -> c_int {
    guarded(component, name, Status::Discard, |slave| {
        if kind != answered {
            let allowed = if answered == NO_STATUS { "none of this type".to_owned() } else { answered.to_string() };
            return Err(Error::new("fmi2StatusKind", kind.to_string(), allowed));
        }
        *place("value", value)? = answer(slave)?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resource_locations_of_all_importers_are_understood() {
        for (uri, path) in [
            ("file:///a/b", "/a/b"),
            ("file:/a/b", "/a/b"),
            ("file:////a/b", "/a/b"),
            ("file://localhost/a%20b/", "/a b/"),
            ("/a/b", "/a/b"),
            ("file:///a/50%", "/a/50%"),
            ("", ""),
            ("file:", ""),
        ] {
            assert_eq!(resource_path(uri), PathBuf::from(path), "{uri}");
        }
    }
}
