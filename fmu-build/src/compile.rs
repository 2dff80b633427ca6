//! Compiles a package's library as a shared library.
//!
//! The package keeps a plain `[lib]`: listing `cdylib` in its `crate-type` would disable link-time optimisation in every build. `cargo
//! rustc --lib --crate-type cdylib` requests one here only. Default features are off, so that dependencies of a command line only do not
//! end up in the FMU.

use crate::{
    cargo::{self, Messages},
    error::{Error, Result},
    folder,
    linker::Linker,
    manifest::Manifest,
    platform::{Platform, universal},
};
use serde::Deserialize;
use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

/// Compiles `package` for `platform` and returns the shared library. Cargo's own messages appear on standard error. The lock file is used
/// unchanged: an FMU is built from the versions that were tested.
pub fn shared_library(manifest: &Manifest, platform: Platform, linker: &Linker) -> Result<Vec<u8>> {
    check_targets(&[platform], linker)?;
    let compile = |target: Option<String>| {
        // Read immediately: the next build for the same target overwrites it.
        folder::read_file(&library_for(manifest, platform, target.as_deref(), linker)?)
    };
    let mut libraries = linker.targets(platform).into_iter().map(compile).collect::<Result<Vec<_>>>()?;
    match libraries.len() {
        1 => Ok(libraries.remove(0)),
        _ => universal::join(&libraries).ok_or_else(|| Error::CargoOutput {
            command: "cargo rustc".into(),
            found: format!("the libraries for {platform} cannot be joined"),
            expected: "Mach-O libraries smaller than 4 GiB".into(),
        }),
    }
}

/// Refuses platforms without an installed standard library, all in one error.
pub fn check_targets(platforms: &[Platform], linker: &Linker) -> Result<()> {
    let mut refused = (Vec::new(), Vec::new());
    for platform in platforms {
        let missing = linker.missing_targets(*platform)?;
        if !missing.is_empty() {
            refused.0.push(platform.folder());
            refused.1.extend(missing);
        }
    }
    match refused {
        (platforms, _) if platforms.is_empty() => Ok(()),
        (platforms, targets) => {
            Err(Error::TargetNotInstalled { platforms: platforms.join(", "), targets: targets.join(" ") })
        }
    }
}

fn library_for(manifest: &Manifest, platform: Platform, target: Option<&str>, linker: &Linker) -> Result<PathBuf> {
    let Manifest { manifest_path, package, features, profile, .. } = manifest;
    let arguments = arguments(manifest_path, package, platform, target, features, profile);
    let messages =
        cargo::run(linker.program(), &arguments, Messages::Shown).map_err(|cause| match (target, linker) {
            (Some(_), Linker::Native) => Error::CrossLink { platform: platform.folder(), cause: Box::new(cause) },
            _ => cause,
        })?;
    library_path(&messages, platform).map_err(|found| Error::CargoOutput {
        command: cargo::shown(&arguments),
        found,
        expected: format!("a shared library with the extension .{}", platform.extension()),
    })
}

fn arguments(
    manifest_path: &Path,
    package: &str,
    platform: Platform,
    target: Option<&str>,
    features: &[String],
    profile: &str,
) -> Vec<OsString> {
    let mut arguments: Vec<OsString> =
        ["rustc", "--lib", "--crate-type", "cdylib", "--no-default-features", "--locked"].map(Into::into).into();
    arguments.extend(["--message-format", "json-render-diagnostics"].map(Into::into));
    arguments.extend(["--profile", profile, "--package", package].map(Into::into));
    arguments.extend(["--manifest-path".into(), manifest_path.into()]);
    if !features.is_empty() {
        arguments.extend(["--features".into(), features.join(",").into()]);
    }
    if let Some(target) = target {
        arguments.extend(["--target", target].map(Into::into));
    }
    if platform.has_glibc() {
        arguments.extend(STAY_LOADED.map(Into::into));
    }
    arguments
}

/// Before glibc 2.18 destructors of thread-local data run at the end of the thread, even if the library has been unloaded. The library
/// therefore stays loaded when the host unloads it.
const STAY_LOADED: [&str; 3] = ["--", "-C", "link-arg=-Wl,-z,nodelete"];

/// Finds the library in cargo's messages, one JSON object per line. It is the last shared library reported: dependencies that are also
/// shared libraries are finished before it.
fn library_path(messages: &str, platform: Platform) -> Result<PathBuf, String> {
    #[derive(Deserialize)]
    struct Message {
        target: Target,
        filenames: Vec<PathBuf>,
    }
    #[derive(Deserialize)]
    struct Target {
        crate_types: Vec<String>,
    }
    let message = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Message>(line).ok()) // other messages have other fields
        .rfind(|message| message.target.crate_types.iter().any(|kind| kind == "cdylib"))
        .ok_or("no shared library was reported")?;
    let matches = |path: &&PathBuf| path.extension().is_some_and(|extension| extension == platform.extension());
    message.filenames.iter().find(matches).cloned().ok_or_else(|| format!("it reported {:?}", message.filenames))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MESSAGES: &str = r#"{"reason":"compiler-artifact","target":{"crate_types":["cdylib"]},"filenames":["/t/libdependency.so"]}
not JSON
{"reason":"build-script-executed","package_id":"b"}
{"reason":"compiler-artifact","target":{"crate_types":["cdylib"]},"filenames":["/t/model.dll.lib","/t/libmodel.so"]}
{"reason":"build-finished","success":true}
"#;

    #[test]
    fn the_last_shared_library_is_the_one() {
        assert_eq!(library_path(MESSAGES, Platform::Linux64).unwrap(), Path::new("/t/libmodel.so"));
    }

    #[test]
    fn what_cargo_made_instead_is_said() {
        assert!(library_path(MESSAGES, Platform::Win64).unwrap_err().contains("libmodel.so"));
        assert!(library_path("", Platform::Linux64).unwrap_err().contains("no shared library"));
    }

    #[test]
    fn features_and_target_are_passed_only_where_there_are_any() {
        let manifest = Path::new("Cargo.toml");
        let plain = cargo::shown(&arguments(manifest, "m", Platform::Win64, None, &[], "fmu"));
        assert!(
            plain.contains("--profile fmu --package m") && plain.contains("--no-default-features --locked"),
            "{plain}"
        );
        assert!(!plain.contains("--features") && !plain.contains("--target"), "{plain}");
        let features = ["a".to_owned(), "b/c".to_owned()];
        let full = cargo::shown(&arguments(manifest, "m", Platform::Linux64, Some("x-y-z"), &features, "fmu"));
        assert!(full.contains("--features a,b/c --target x-y-z"), "{full}");
    }

    #[test]
    fn linux_libraries_stay_loaded() {
        let arguments = |platform| cargo::shown(&arguments(Path::new("Cargo.toml"), "m", platform, None, &[], "fmu"));
        assert!(arguments(Platform::Linux64).ends_with("-- -C link-arg=-Wl,-z,nodelete"));
        assert!(
            !arguments(Platform::Win64).contains("nodelete") && !arguments(Platform::Darwin64).contains("nodelete")
        );
    }
}
