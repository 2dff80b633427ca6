//! Misuse of the FMU and the program: calls in any order with any arguments, files with any bytes, many instances on many threads.
//! Everything is drawn from a seed, so that a failed case can be rerun alone.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::missing_panics_doc)] // a failed check ends the run

pub mod calls;
pub mod functions;
pub mod host;
pub mod many;
pub mod memory;
pub mod readers;
pub mod watchdog;

/// Calls with arbitrary handles may hit instances of other tests.
#[cfg(test)]
fn alone() -> std::sync::MutexGuard<'static, ()> {
    static ALONE: std::sync::Mutex<()> = std::sync::Mutex::new(());
    ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
