//! `actuator`: arguments -> one library call -> text -> exit code.

use std::process::ExitCode;

/// Keeps the memory of records, allocated and freed by the thousand, from being returned to the system each time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    cli::commands::run()
}
