//! The callbacks of the host, and messages to its logger.
//!
//! The logger may be written in C++ and throw: the exception passes through the C function that logged, whose work is done by then, to
//! the host's own handler. Rust cannot hold an exception of another language, so that nothing on this way catches.
#![allow(unsafe_code)]

use std::{ffi::CString, sync::Arc};

use libc::{c_char, c_int, c_void};

use crate::log::{Filter, Message};

type Logger = unsafe extern "C-unwind" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`. Memory management of the host is not used.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    logger: Option<Logger>,
    allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    component_environment: *mut c_void,
}

/// The logger of the host of an instance, with the filter that the host has set.
pub(super) struct Host {
    name: CString,
    logger: Option<Logger>,
    environment: *mut c_void,
    pub filter: Arc<Filter>,
}

// SAFETY: the environment is never dereferenced here, only handed back to the host's own logger, and only within calls that the
// host makes, on the thread on which it makes them.
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

    pub fn log(&self, messages: impl IntoIterator<Item = Message>) {
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
