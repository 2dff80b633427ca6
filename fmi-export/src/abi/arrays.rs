//! Arrays of the host, checked for NULL, alignment and length before they become slices.
#![allow(unsafe_code)]

use std::ffi::CStr;

use libc::c_char;

use crate::error::{Error, Result};

/// Maximum number of elements: far more than any importer uses, and small enough that the size in bytes cannot overflow.
const LONGEST_ARRAY: usize = 1 << 28;

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

pub(super) fn array<'a, T>(name: &str, start: *const T, length: usize) -> Result<&'a [T]> {
    if length == 0 {
        return Ok(&[]);
    }
    check_array(name, start, length)?;
    // SAFETY: not NULL, aligned, of a length that cannot overflow; that so many elements are there is guaranteed by the host.
    Ok(unsafe { std::slice::from_raw_parts(start, length) })
}

pub(super) fn array_mut<'a, T>(name: &str, start: *mut T, length: usize) -> Result<&'a mut [T]> {
    if length == 0 {
        return Ok(&mut []);
    }
    check_array(name, start, length)?;
    // SAFETY: as in `array`; the host does not use the array while we fill it.
    Ok(unsafe { std::slice::from_raw_parts_mut(start, length) })
}

pub(super) fn place<'a, T>(name: &str, at: *mut T) -> Result<&'a mut T> {
    check_array(name, at, 1)?;
    // SAFETY: not NULL and aligned; that it points to a `T` is guaranteed by the host.
    Ok(unsafe { &mut *at })
}

pub(super) fn text(start: *const c_char) -> Option<String> {
    // SAFETY: not NULL; that it ends in a zero byte is guaranteed by the host.
    (!start.is_null()).then(|| unsafe { CStr::from_ptr(start) }.to_string_lossy().into_owned())
}
