//! Arrays of the host, read and written element by element through raw pointers: no reference to the host's memory is ever made, so that it
//! may be uninitialised where it is written, and arrays of one call may overlap. NULL, alignment and length are checked first.
#![allow(unsafe_code)]

use std::ffi::CStr;

use libc::c_char;

use crate::error::{Error, Result};

/// Maximum number of elements: far more than any importer uses, and small enough that the size in bytes cannot overflow.
const LONGEST_ARRAY: usize = 1 << 28;

#[inline]
fn check_array<T>(name: &str, start: *const T, length: usize) -> Result<()> {
    if !start.is_null() && start.is_aligned() && length <= LONGEST_ARRAY || length == 0 {
        return Ok(());
    }
    Err(refusal(name, start, length))
}

#[cold]
#[inline(never)]
fn refusal<T>(name: &str, start: *const T, length: usize) -> Error {
    let refuse = |found: String, allowed: &str| Error::new(format!("array {name}"), found, allowed);
    if start.is_null() {
        refuse("NULL".into(), "a pointer to as many elements as announced")
    } else if !start.is_aligned() {
        refuse(format!("{start:p}"), "a pointer aligned for its type")
    } else {
        refuse(format!("{length} elements"), &format!("at most {LONGEST_ARRAY}"))
    }
}

/// An array filled by the host.
#[derive(Clone, Copy)]
pub(super) struct Input<T> {
    start: *const T,
    length: usize,
}

impl<T: Copy> Input<T> {
    /// Refuses NULL, a misaligned pointer, an impossible length.
    #[inline]
    pub fn new(name: &str, start: *const T, length: usize) -> Result<Self> {
        check_array(name, start, length).map(|()| Self { start, length })
    }

    /// The elements, each read on demand.
    #[inline]
    pub fn iter(self) -> impl Iterator<Item = T> + Clone {
        // SAFETY: `check_array` has checked that the pointer is not NULL and aligned, and that the length does not overflow; the host
        // guarantees that this many elements exist and are initialised.
        (0..self.length).map(move |index| unsafe { self.start.add(index).read() })
    }
}

/// An array to be filled for the host; its previous content is irrelevant.
#[derive(Clone, Copy)]
pub(super) struct Output<T> {
    start: *mut T,
    length: usize,
}

impl<T: Copy> Output<T> {
    /// Refuses NULL, a misaligned pointer, an impossible length.
    #[inline]
    pub fn new(name: &str, start: *mut T, length: usize) -> Result<Self> {
        check_array(name, start, length).map(|()| Self { start, length })
    }

    /// Writes one element; nothing beyond the end.
    #[inline]
    pub fn write(self, index: usize, value: T) {
        if index < self.length {
            // SAFETY: as for `Input::iter`, and within the length; nothing is read, and no reference is made.
            unsafe { self.start.add(index).write(value) };
        }
    }

    /// Writes all of these, from the start.
    pub fn write_all(self, values: &[T]) {
        values.iter().enumerate().for_each(|(index, value)| self.write(index, *value));
    }
}

/// One variable of the host.
#[derive(Clone, Copy)]
pub(super) struct Place<T>(*mut T);

impl<T: Copy> Place<T> {
    /// Refuses NULL and a misaligned pointer.
    #[inline]
    pub fn new(name: &str, at: *mut T) -> Result<Self> {
        check_array(name, at, 1).map(|()| Self(at))
    }

    #[inline]
    pub fn write(self, value: T) {
        // SAFETY: not NULL and aligned; the host guarantees that it points to space for a `T`.
        unsafe { self.0.write(value) };
    }

    /// The value written by the host.
    #[inline]
    pub fn read(self) -> T {
        // SAFETY: not NULL and aligned; the host guarantees that it has written a `T` there.
        unsafe { self.0.read() }
    }
}

pub(super) fn text(start: *const c_char) -> Option<String> {
    // SAFETY: not NULL; the host guarantees that it ends in a zero byte.
    (!start.is_null()).then(|| unsafe { CStr::from_ptr(start) }.to_string_lossy().into_owned())
}
