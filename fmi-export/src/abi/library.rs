//! The file from which this library was loaded.
#![allow(unsafe_code)]

use std::path::PathBuf;

/// Its path, if the system provides it.
#[cfg(unix)]
pub fn path() -> Option<PathBuf> {
    use std::{ffi::CStr, os::unix::ffi::OsStrExt};

    let mut found = std::mem::MaybeUninit::<libc::Dl_info>::zeroed();
    let here = path as fn() -> Option<PathBuf>;
    // SAFETY: an address in this library, and space for the answer, for which all zeros is a valid value.
    let info = unsafe {
        if libc::dladdr(here as *const libc::c_void, found.as_mut_ptr()) == 0 {
            return None;
        }
        found.assume_init()
    };
    if info.dli_fname.is_null() {
        return None;
    }
    // SAFETY: a path that ends in a zero byte and lives as long as the library is loaded.
    let name = unsafe { CStr::from_ptr(info.dli_fname) };
    Some(PathBuf::from(std::ffi::OsStr::from_bytes(name.to_bytes())))
}

/// Its path, if the system provides it.
#[cfg(windows)]
pub fn path() -> Option<PathBuf> {
    use std::os::windows::ffi::OsStringExt;

    #[link(name = "kernel32")]
    unsafe extern "system" {
        fn GetModuleHandleExW(flags: u32, address: *const u16, module: *mut *mut libc::c_void) -> i32;
        fn GetModuleFileNameW(module: *mut libc::c_void, name: *mut u16, size: u32) -> u32;
    }
    const FROM_ADDRESS: u32 = 4;
    const UNCHANGED_COUNT: u32 = 2;
    const LONGEST: usize = 32_768;

    let mut module = std::ptr::null_mut();
    let mut name = vec![0_u16; LONGEST];
    let here = path as fn() -> Option<PathBuf>;
    // SAFETY: an address in this library, and space for the answers with its size.
    let length = unsafe {
        if GetModuleHandleExW(FROM_ADDRESS | UNCHANGED_COUNT, here as *const u16, &raw mut module) == 0 {
            return None;
        }
        GetModuleFileNameW(module, name.as_mut_ptr(), LONGEST as u32) as usize
    };
    let name = name.get(..length).filter(|name| !name.is_empty())?;
    Some(PathBuf::from(std::ffi::OsString::from_wide(name)))
}

/// Its path, if the system provides it.
#[cfg(not(any(unix, windows)))]
pub fn path() -> Option<PathBuf> {
    None
}
