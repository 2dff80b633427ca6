//! The linker of a binary: this computer's own linker, or zig's through `cargo-zigbuild`.
//!
//! Binaries linked by this computer need a glibc as new as its own. Zig links for an old one, and for other systems. Both come from PyPI:
//! `pip install ziglang cargo-zigbuild`, with `cargo-zigbuild` on the `PATH`.

use crate::{cargo, error::Result, platform::Platform};
use std::{
    env,
    path::{Path, PathBuf},
};

/// Available on every Linux of the last ten years (`RHEL` 7, 2014; manylinux2014).
const OLDEST_GLIBC: &str = "2.17";

/// The linker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Linker {
    /// Cargo's default linker for the target.
    Native,
    /// Zig's; the path of `cargo-zigbuild`.
    Zig(PathBuf),
}

impl Linker {
    /// Zig's, if `cargo-zigbuild` is on the `PATH`: for binaries to be run on other computers.
    #[must_use]
    pub fn for_other_computers() -> Self {
        let name = format!("cargo-zigbuild{}", env::consts::EXE_SUFFIX);
        let path = env::var_os("PATH").unwrap_or_default();
        let found = env::split_paths(&path).map(|folder| folder.join(&name)).find(|program| program.is_file());
        found.map_or(Self::Native, Self::Zig)
    }

    /// The program to run instead of cargo.
    pub(crate) fn program(&self) -> Option<&Path> {
        match self {
            Self::Native => None,
            Self::Zig(path) => Some(path),
        }
    }

    /// The targets to compile for in turn; `None` is this computer's own.
    pub(crate) fn targets(&self, platform: Platform) -> Vec<Option<String>> {
        match self {
            Self::Native if Platform::host().ok() == Some(platform) => vec![None],
            Self::Native => vec![Some(platform.target().into())],
            Self::Zig(_) => platform
                .targets()
                .iter()
                .map(|target| {
                    Some(if platform.has_glibc() { format!("{target}.{OLDEST_GLIBC}") } else { (*target).into() })
                })
                .collect(),
        }
    }

    /// The Rust targets among them whose standard library is not installed.
    pub(crate) fn missing_targets(&self, platform: Platform) -> Result<Vec<&'static str>> {
        let needed = self.targets(platform).into_iter().flatten();
        let mut missing = Vec::new();
        for target in needed {
            // The suffix is zig's.
            let name = platform.targets().iter().find(|name| target.starts_with(**name));
            if let Some(name) = name
                && !cargo::target_is_installed(name)?
            {
                missing.push(*name);
            }
        }
        Ok(missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zig_links_for_an_old_glibc_and_for_both_kinds_of_mac() {
        let zig = Linker::Zig("cargo-zigbuild".into());
        assert_eq!(zig.targets(Platform::Linux64), [Some("x86_64-unknown-linux-gnu.2.17".into())]);
        assert_eq!(zig.targets(Platform::Win64), [Some("x86_64-pc-windows-gnu".into())]);
        assert_eq!(zig.targets(Platform::Darwin64).len(), 2);
        assert_eq!(Linker::Native.targets(Platform::host().unwrap()), [None]);
    }
}
