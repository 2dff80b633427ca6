//! `actuator`: arguments -> one library call -> text -> exit code.

use std::process::ExitCode;

/// Keeps the arrays of records, which come and go by the thousand, from being returned to the system each time.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    cli::commands::run()
}
