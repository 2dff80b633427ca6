//! Text and JSON on standard output, lines on standard error.

use std::io::{ErrorKind, Write};

use actuator_fmu::{Error, Result};
use serde::Serialize;

/// Writes to standard output. A reader that stopped reading (`| head`) is not an error.
///
/// # Errors
/// The system's own.
pub fn print(text: &str) -> Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::new("standard output", error.to_string(), "a place that can be written to"))
        }
        _ => Ok(()),
    }
}

/// Writes a table to standard output and its summary to standard error, so that the table can be piped.
///
/// # Errors
/// As [`print()`].
pub fn print_with_summary(csv: &[u8], summary: &str) -> Result<()> {
    print(&String::from_utf8_lossy(csv))?;
    remark(summary);
    Ok(())
}

/// Writes a line to standard error. If that fails, the run and its exit code are unaffected.
pub fn remark(line: &str) {
    // In one call, so that lines of several threads do not mix.
    let _ = std::io::stderr().write_all(format!("{line}\n").as_bytes());
}

/// A value as JSON, indented.
///
/// # Errors
/// A value that JSON cannot hold.
pub fn to_json(value: &impl Serialize) -> Result<String> {
    serde_json::to_string_pretty(value)
        .map_err(|error| Error::new("JSON", error.to_string(), "values that JSON can hold"))
}

/// Writes a value as JSON to standard output.
///
/// # Errors
/// As [`to_json`] and [`print()`].
pub fn print_json(value: &impl Serialize) -> Result<()> {
    print(&format!("{}\n", to_json(value)?))
}
