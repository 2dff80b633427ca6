//! Platforms: the folder of a binary in FMI 2.0, its file extension, and the Rust target that builds it.
//!
//! FMI 2.0.4, section 2.3, names `linux64`, `win64`, `darwin64` and their 32-bit counterparts and leaves other names to the exporter. For
//! 64-bit ARM Linux we use the name of FMI 3.0, `aarch64-linux`. `darwin64` serves both kinds of Mac: it contains a universal binary if
//! both targets are available; its ARM part is in `aarch64-darwin` as well.

use crate::error::{Error, Result};
use std::{fmt, str::FromStr};

mod format;
pub mod glibc;
pub(crate) mod universal;

/// A platform an FMU can carry a binary for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Platform {
    /// Linux on x86-64.
    Linux64,
    /// Windows on x86-64.
    Win64,
    /// macOS; with zig a universal binary for x86-64 and ARM; without zig on a Mac for that Mac, elsewhere for x86-64.
    Darwin64,
    /// Linux on 32-bit x86.
    Linux32,
    /// Windows on 32-bit x86.
    Win32,
    /// Linux on 64-bit ARM.
    Aarch64Linux,
}

impl Platform {
    /// Every platform, the common ones first.
    pub const ALL: [Self; 6] =
        [Self::Linux64, Self::Win64, Self::Darwin64, Self::Linux32, Self::Win32, Self::Aarch64Linux];

    /// Common platforms: the meaning of `all` on the command line.
    pub const COMMON: [Self; 4] = [Self::Linux64, Self::Win64, Self::Darwin64, Self::Aarch64Linux];

    /// The folder below `binaries/`.
    #[must_use]
    pub const fn folder(self) -> &'static str {
        match self {
            Self::Linux64 => "linux64",
            Self::Win64 => "win64",
            Self::Darwin64 => "darwin64",
            Self::Linux32 => "linux32",
            Self::Win32 => "win32",
            Self::Aarch64Linux => "aarch64-linux",
        }
    }

    /// The extension of a shared library, without the dot.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Linux64 | Self::Linux32 | Self::Aarch64Linux => "so",
            Self::Win64 | Self::Win32 => "dll",
            Self::Darwin64 => "dylib",
        }
    }

    /// The Rust target to cross-compile for. Windows is the GNU flavour: its linker runs anywhere.
    #[must_use]
    pub const fn target(self) -> &'static str {
        self.targets()[0]
    }

    /// All Rust targets whose libraries make up the binary, if the linker can link for all of them.
    #[must_use]
    pub const fn targets(self) -> &'static [&'static str] {
        match self {
            Self::Linux64 => &["x86_64-unknown-linux-gnu"],
            Self::Win64 => &["x86_64-pc-windows-gnu"],
            Self::Darwin64 => &["x86_64-apple-darwin", "aarch64-apple-darwin"],
            Self::Linux32 => &["i686-unknown-linux-gnu"],
            Self::Win32 => &["i686-pc-windows-gnu"],
            Self::Aarch64Linux => &["aarch64-unknown-linux-gnu"],
        }
    }

    /// Whether its binaries are linked against glibc.
    #[must_use]
    pub const fn has_glibc(self) -> bool {
        matches!(self, Self::Linux64 | Self::Linux32 | Self::Aarch64Linux)
    }

    /// Path of a model's binary in the archive, e.g. `binaries/linux64/Pendulum.so`.
    #[must_use]
    pub fn entry(self, model_identifier: &str) -> String {
        format!("binaries/{}/{model_identifier}.{}", self.folder(), self.extension())
    }

    /// Additional path of a binary, and the part of it there: importers on Macs with an ARM processor look in `aarch64-darwin`, the name of
    /// FMI 3.0, some of them nowhere else.
    #[must_use]
    pub fn other_entry<'a>(self, model_identifier: &str, binary: &'a [u8]) -> Option<(String, &'a [u8])> {
        let part = if self == Self::Darwin64 { universal::for_arm(binary) } else { None };
        part.map(|part| (format!("binaries/aarch64-darwin/{model_identifier}.{}", self.extension()), part))
    }

    /// The platform of this computer.
    pub fn host() -> Result<Self> {
        match (std::env::consts::OS, std::env::consts::ARCH) {
            ("linux", "x86_64") => Ok(Self::Linux64),
            ("linux", "x86") => Ok(Self::Linux32),
            ("linux", "aarch64") => Ok(Self::Aarch64Linux),
            ("windows", "x86_64") => Ok(Self::Win64),
            ("windows", "x86") => Ok(Self::Win32),
            ("macos", _) => Ok(Self::Darwin64),
            (system, processor) => {
                Err(Error::UnknownHost { found: format!("{system} on {processor}"), allowed: all_names() })
            }
        }
    }
}

impl fmt::Display for Platform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.folder())
    }
}

impl FromStr for Platform {
    type Err = Error;

    fn from_str(word: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|platform| platform.folder() == word)
            .ok_or_else(|| Error::UnknownPlatform { found: word.into(), allowed: all_names() })
    }
}

fn all_names() -> String {
    Platform::ALL.map(Platform::folder).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_platform_is_read_back_from_its_folder_name() {
        for platform in Platform::ALL {
            assert_eq!(platform.folder().parse::<Platform>().unwrap(), platform);
        }
    }

    #[test]
    fn an_unknown_word_is_answered_with_the_known_ones() {
        let message = "linux".parse::<Platform>().unwrap_err().to_string();
        assert!(message.contains("`linux`") && message.contains("linux64, win64, darwin64"), "{message}");
    }

    #[test]
    fn a_binary_lies_in_its_platform_folder_under_the_model_identifier() {
        assert_eq!(Platform::Linux64.entry("M"), "binaries/linux64/M.so");
        assert_eq!(Platform::Win64.entry("M"), "binaries/win64/M.dll");
        assert_eq!(Platform::Darwin64.entry("M"), "binaries/darwin64/M.dylib");
    }
}
