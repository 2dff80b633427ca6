//! The callbacks of the host, and messages to its logger.
//!
//! The logger may be written in C++ and throw: the exception passes to the host's own handler. Rust cannot catch a foreign exception, and a
//! library with its own unwinder cannot clean up after one, so that no frame on its way has anything to clean up: messages are queued
//! ([`defer`]) until the call has returned, and delivered by [`log_deferred`] and the C function alone.
#![allow(unsafe_code)]

use std::{
    collections::VecDeque,
    ffi::CString,
    sync::{Arc, Mutex, PoisonError},
};

use libc::{c_char, c_int, c_void};

use super::thread;
use crate::log::{Filter, Message};

type Logger = unsafe extern "C-unwind" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`. The host's memory management is not used.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    logger: Option<Logger>,
    allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    component_environment: *mut c_void,
}

/// The host's logger of an instance, with the filter set by the host.
pub(super) struct Host {
    name: CString,
    logger: Option<Logger>,
    environment: *mut c_void,
    pub filter: Arc<Filter>,
}

// SAFETY: the environment is never dereferenced here, only passed back to the host's own logger, and only within calls by the host, on the
// thread on which it makes them.
unsafe impl Send for Host {}
// SAFETY: as above.
unsafe impl Sync for Host {}

impl Host {
    pub fn new(name: Option<&str>, callbacks: Option<CallbackFunctions>, filter: Arc<Filter>) -> Self {
        Self {
            name: CString::new(name.unwrap_or_default().replace('\0', "")).unwrap_or_default(),
            logger: callbacks.and_then(|callbacks| callbacks.logger),
            environment: callbacks.map_or(std::ptr::null_mut(), |callbacks| callbacks.component_environment),
            filter,
        }
    }
}

/// Messages waiting for the end of the call, per thread.
static DEFERRED: Mutex<VecDeque<(usize, Arc<Host>, Message)>> = Mutex::new(VecDeque::new());

/// Queues messages for [`log_deferred`] on this thread; true if there are any for a logger.
pub(super) fn defer(host: &Arc<Host>, messages: impl IntoIterator<Item = Message>) -> bool {
    if host.logger.is_none() {
        return false;
    }
    let mut deferred = DEFERRED.lock().unwrap_or_else(PoisonError::into_inner);
    let before = deferred.len();
    deferred.extend(messages.into_iter().map(|message| (thread::number(), Arc::clone(host), message)));
    deferred.len() > before
}

/// One call of a logger: plain pointers, so that an exception leaves nothing to clean up. Their memory is leaked then.
#[derive(Clone, Copy)]
struct LoggerCall {
    host: *const Host,
    logger: Logger,
    status: c_int,
    category: *mut c_char,
    text: *mut c_char,
}

/// The oldest message of this thread.
#[inline(never)]
fn take() -> Option<LoggerCall> {
    let mut deferred = DEFERRED.lock().unwrap_or_else(PoisonError::into_inner);
    let own = deferred.iter().position(|(number, ..)| *number == thread::number())?;
    let (_, host, Message { status, category, text }) = deferred.remove(own)?;
    // The text is a printf format for the host: a percent sign in it must not be taken for a directive.
    let text = CString::new(text.replace('\0', " ").replace('%', "%%")).unwrap_or_default();
    let category = CString::new(category).unwrap_or_default();
    let logger = host.logger?;
    Some(LoggerCall {
        host: Arc::into_raw(host),
        logger,
        status: status as c_int,
        category: category.into_raw(),
        text: text.into_raw(),
    })
}

#[inline(never)]
fn release(call: LoggerCall) {
    // SAFETY: made by `take`, each once, and passed here once.
    unsafe {
        drop(Arc::from_raw(call.host));
        drop(CString::from_raw(call.category));
        drop(CString::from_raw(call.text));
    }
}

/// Delivers the deferred messages of this thread to their loggers, after the call that made them.
#[cold]
#[inline(never)]
pub fn log_deferred() {
    while let Some(call) = take() {
        // SAFETY: the host gave this function as its logger; host and strings live until `release`.
        unsafe {
            let Host { name, environment, .. } = &*call.host;
            (call.logger)(*environment, name.as_ptr(), call.status, call.category, call.text);
        }
        release(call);
    }
}
