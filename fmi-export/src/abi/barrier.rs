//! An asymmetric pair of memory barriers: the light one only constrains the order of compiled code, the heavy one makes every other thread
//! of the process pass a full barrier.
//!
//! If one thread does `write A; light; read B` and another `write B; heavy; read A`, at least one of them sees what the other wrote.
#![allow(unsafe_code)]

use std::sync::atomic::{Ordering, compiler_fence};

/// The frequent side. Requires [`is_available`].
#[inline]
pub(super) fn light() {
    compiler_fence(Ordering::SeqCst);
    #[cfg(miri)]
    std::sync::atomic::fence(Ordering::SeqCst);
}

/// The rare side: some microseconds.
pub(super) fn heavy() {
    system::heavy();
}

/// Whether the system has a heavy barrier.
pub(super) fn is_available() -> bool {
    static AVAILABLE: std::sync::OnceLock<bool> = std::sync::OnceLock::new();
    *AVAILABLE.get_or_init(system::prepare)
}

/// Miri does not support the system call: two full fences are equivalent.
#[cfg(miri)]
mod system {
    pub fn prepare() -> bool {
        true
    }

    pub fn heavy() {
        std::sync::atomic::fence(std::sync::atomic::Ordering::SeqCst);
    }
}

#[cfg(all(target_os = "linux", not(miri)))]
mod system {
    const PRIVATE_EXPEDITED: libc::c_int = 1 << 3;
    const REGISTER_PRIVATE_EXPEDITED: libc::c_int = 1 << 4;

    fn membarrier(command: libc::c_int) -> bool {
        // SAFETY: membarrier(2) takes three integers and accesses no memory of the process.
        unsafe { libc::syscall(libc::SYS_membarrier, command, 0, 0) == 0 }
    }

    pub fn prepare() -> bool {
        membarrier(REGISTER_PRIVATE_EXPEDITED)
    }

    pub fn heavy() {
        // A registered process is never refused; without the barrier two calls could be active in one instance.
        assert!(membarrier(PRIVATE_EXPEDITED), "membarrier(2) refused after it was granted");
    }
}

#[cfg(all(windows, not(miri)))]
mod system {
    #[link(name = "kernel32")]
    unsafe extern "system" {
        fn FlushProcessWriteBuffers();
    }

    pub fn prepare() -> bool {
        true
    }

    pub fn heavy() {
        // SAFETY: takes and returns nothing.
        unsafe { FlushProcessWriteBuffers() };
    }
}

#[cfg(not(any(miri, target_os = "linux", windows)))]
mod system {
    pub fn prepare() -> bool {
        false
    }

    /// Never reached: without this side nothing uses the light one.
    pub fn heavy() {}
}
