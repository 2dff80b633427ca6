//! Running cargo and reading its metadata.

use crate::error::{Error, Result};
use serde::Deserialize;
use std::{
    ffi::OsString,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
};

/// The environment variable by which cargo passes its own path to programs that it starts.
const CARGO: &str = "CARGO";

/// Handling of cargo's standard error.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Messages {
    /// Shown to the user: progress, warnings, errors.
    Shown,
    /// Captured, and part of the error if there is one.
    Captured,
}

/// Runs cargo, or the program `instead` with cargo's arguments, to completion and returns its standard output.
pub(crate) fn run(instead: Option<&Path>, arguments: &[OsString], messages: Messages) -> Result<String> {
    let stderr = match messages {
        Messages::Shown => Stdio::inherit(),
        Messages::Captured => Stdio::piped(),
    };
    let program = instead.map_or_else(|| program(CARGO, "cargo"), Into::into);
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stderr(stderr);
    let output = output(&mut command, CARGO)?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        let mut detail = String::from_utf8_lossy(&output.stderr).trim_end().to_owned();
        if !detail.is_empty() {
            detail.insert_str(0, ":\n");
        }
        Err(Error::Cargo { command: shown(arguments), status: output.status, detail })
    }
}

/// The folder for build products of the workspace that this manifest belongs to.
pub(crate) fn target_directory(manifest_path: &Path) -> Result<PathBuf> {
    #[derive(Deserialize)]
    struct Metadata {
        target_directory: PathBuf,
    }
    let mut arguments: Vec<OsString> =
        ["metadata", "--no-deps", "--format-version", "1", "--manifest-path"].map(Into::into).into();
    arguments.push(manifest_path.into());
    let text = run(None, &arguments, Messages::Captured)?;
    let metadata: Metadata = serde_json::from_str(&text).map_err(|problem| Error::CargoOutput {
        command: shown(&arguments),
        found: format!("its output cannot be read ({problem})"),
        expected: "the target directory as JSON".into(),
    })?;
    Ok(metadata.target_directory)
}

/// Whether the standard library for a target is installed, wherever this compiler keeps it.
pub(crate) fn target_is_installed(target: &str) -> Result<bool> {
    const RUSTC: &str = "RUSTC";
    let mut command = Command::new(program(RUSTC, "rustc"));
    command.args(["--print", "target-libdir", "--target", target]).stderr(Stdio::null());
    let output = output(&mut command, RUSTC)?;
    let folder = String::from_utf8_lossy(&output.stdout);
    Ok(output.status.success() && Path::new(folder.trim_end()).is_dir())
}

/// A command line, for messages.
pub(crate) fn shown(arguments: &[OsString]) -> String {
    arguments.iter().fold("cargo".into(), |line, argument| format!("{line} {}", argument.display()))
}

fn program(variable: &str, default: &str) -> OsString {
    std::env::var_os(variable).unwrap_or_else(|| default.into())
}

fn output(command: &mut Command, variable: &'static str) -> Result<Output> {
    command.output().map_err(|cause| Error::Start {
        command: command.get_program().display().to_string(),
        cause,
        variable,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_host_target_is_installed_and_an_invented_one_is_not() {
        assert!(target_is_installed(crate::platform::Platform::host().unwrap().target()).unwrap());
        assert!(!target_is_installed("pdp11-unknown-none").unwrap());
    }

    #[test]
    fn what_cargo_says_is_part_of_the_error_where_it_was_not_shown() {
        let message = target_directory(Path::new("no/such/Cargo.toml")).unwrap_err().to_string();
        assert!(
            message.contains("`cargo metadata") && message.contains("no/such/Cargo.toml` does not exist"),
            "{message}"
        );
    }
}
