//! `actuator`: arguments -> one library call -> text -> exit code.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
