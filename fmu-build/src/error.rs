//! All errors of packaging. A message names the thing, what was found, what is allowed, and what to do; it is complete in itself, so the
//! cause is part of the text and not a second error to unwrap.

use std::{io, path::PathBuf};

/// The result of all fallible functions here.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why an FMU could not be made, read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file or folder could not be read.
    #[error("cannot read {path}: {cause}; check that it exists and that you may read it")]
    Read {
        /// What was to be read.
        path: PathBuf,
        /// Cause given by the operating system.
        cause: io::Error,
    },
    /// A file could not be written; nothing was left behind.
    #[error("cannot write {path}: {cause}; check that its folder may be written to and that it is not a folder itself")]
    Write {
        /// What was to be written.
        path: PathBuf,
        /// Cause given by the operating system.
        cause: io::Error,
    },
    /// The output already exists and may not be replaced.
    #[error(
        "{path} already exists and is not written over; choose another output, or allow it (`--force` of the programs)"
    )]
    Exists {
        /// The file in the way.
        path: PathBuf,
    },
    /// A folder contains something that cannot be archived.
    #[error("{path} {problem}; only regular files and folders with UTF-8 names can be packaged: replace or rename it")]
    Unpackable {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong with it.
        problem: &'static str,
    },

    /// The name of an archive entry would not unpack everywhere, or would unpack outside the archive's folder.
    #[error(
        "archive entry `{name}`: the name {problem}; use a relative name with forward slashes, such as \
         `resources/data.csv`"
    )]
    EntryName {
        /// The refused name.
        name: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// An archive entry exists twice, possibly in another case.
    #[error(
        "archive entry `{name}`: there is already an entry `{existing}`, and names must differ in more than case; \
         rename one, or replace it"
    )]
    DuplicateEntry {
        /// The refused name.
        name: String,
        /// The entry in the way.
        existing: String,
    },
    /// An archive entry to be replaced does not exist.
    #[error("archive entry `{name}`: there is no such entry to replace; insert it, or take one of: {available}")]
    MissingEntry {
        /// The name looked for.
        name: String,
        /// The existing names.
        available: String,
    },
    /// The bytes are not an archive that can be read in full.
    #[error(
        "{archive} is not a readable FMU: {cause}; an FMU is a zip archive of stored or deflated files: export it again"
    )]
    NotAnArchive {
        /// The file, or `these bytes`.
        archive: String,
        /// Cause given by the zip reader.
        cause: String,
    },
    /// The archive could not be created.
    #[error("cannot write the archive entry `{entry}`: {cause}; an entry must be smaller than 4 GiB")]
    Zip {
        /// The entry being written.
        entry: String,
        /// Cause given by the zip writer.
        cause: String,
    },

    /// The content of an FMU violates rules; all violations are listed.
    #[error("cannot package `{model_identifier}`, {} to solve:{}", count(problems), list(problems))]
    Package {
        /// The FMU concerned.
        model_identifier: String,
        /// One sentence each.
        problems: Vec<String>,
    },

    /// `Cargo.toml` is invalid; the text has line, key, what was found and what is allowed.
    #[error("{path}: {cause}\ncorrect this line, or take it out")]
    ManifestSyntax {
        /// The `Cargo.toml`.
        path: PathBuf,
        /// Cause given by the TOML reader.
        cause: String,
    },
    /// A key of `Cargo.toml` is missing or has a value that cannot be used.
    #[error("{path}: `{key}` is {found}, allowed is {allowed}; {remedy}")]
    Manifest {
        /// The `Cargo.toml`.
        path: PathBuf,
        /// The key concerned.
        key: &'static str,
        /// The value found.
        found: String,
        /// The allowed values.
        allowed: &'static str,
        /// What to do.
        remedy: String,
    },

    /// Cargo could not be started.
    #[error(
        "cannot run `{command}`: {cause}; install Rust from https://rustup.rs, or name the program in the environment \
         variable {variable}"
    )]
    Start {
        /// The command line.
        command: String,
        /// Cause given by the operating system.
        cause: io::Error,
        /// Which environment variable names the program.
        variable: &'static str,
    },
    /// Cargo ended with an error, which it has already printed.
    #[error(
        "`{command}` ended with {status}{detail}; cargo names the reason above: correct it and run this command again \
         to see it alone"
    )]
    Cargo {
        /// The command line.
        command: String,
        /// Its exit status.
        status: std::process::ExitStatus,
        /// Its messages, unless already shown.
        detail: String,
    },
    /// Cargo succeeded without reporting what was expected.
    #[error(
        "`{command}` ended well, but {found}; expected {expected}: check that the package has a library and that no \
         other build target is set in the environment or in .cargo/config.toml"
    )]
    CargoOutput {
        /// The command line.
        command: String,
        /// What was found in its output.
        found: String,
        /// What was looked for.
        expected: String,
    },
    /// The standard library for other platforms is not installed.
    #[error(
        "{platforms}: a Rust target is not installed; run `rustup target add {targets}`, or leave these platforms out"
    )]
    TargetNotInstalled {
        /// Folder names of the platforms.
        platforms: String,
        /// The compiler targets.
        targets: String,
    },
    /// Cargo ended with an error while it compiled for another platform with its own linker.
    #[error(
        "{cause}\nif the linker is the reason: to link for {platform} from here, `pip install ziglang cargo-zigbuild` and \
         put `cargo-zigbuild` on the PATH"
    )]
    CrossLink {
        /// Folder name of the platform.
        platform: &'static str,
        /// What went wrong.
        cause: Box<Error>,
    },
    /// A word that is not a platform.
    #[error("platform `{found}` is not known; allowed are {allowed}")]
    UnknownPlatform {
        /// The word.
        found: String,
        /// All platforms.
        allowed: String,
    },
    /// FMI 2.0 has no folder for this kind of computer.
    #[error("this computer ({found}) has no FMI platform of its own; name the platforms to build for, among {allowed}")]
    UnknownHost {
        /// Operating system and processor.
        found: String,
        /// All platforms.
        allowed: String,
    },
}

fn count(problems: &[String]) -> String {
    match problems.len() {
        1 => "1 problem".into(),
        n => format!("{n} problems"),
    }
}

fn list(problems: &[String]) -> String {
    problems.iter().map(|problem| format!("\n  - {problem}")).collect()
}
