//! The glibc version required by a Linux binary: the highest of the versions that it names.
//!
//! A binary names the versions of the symbols that it uses from glibc (`GLIBC_2.14`) in its dynamic string table, each terminated by a zero
//! (System V ABI, section "Symbol versioning"); no loader accepts it with an older glibc. An accidental match in the data would raise the
//! answer, never lower it.

use std::fmt;

const PREFIX: &[u8] = b"GLIBC_";

/// A version of glibc, `2.14`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version {
    /// `2` of `2.14`.
    pub major: u16,
    /// `14` of `2.14`.
    pub minor: u16,
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

/// The oldest glibc with everything that the binary requires; `None` if it names no version.
#[must_use]
pub fn needed(binary: &[u8]) -> Option<Version> {
    let starts = binary.windows(PREFIX.len()).enumerate().filter(|(_, window)| *window == PREFIX);
    starts.filter_map(|(start, _)| version(binary.get(start + PREFIX.len()..)?)).max()
}

/// The version at the start of these bytes, up to a zero; a patch level (`2.2.5`) is ignored.
fn version(bytes: &[u8]) -> Option<Version> {
    const LONGEST: usize = 12;
    let end = bytes.iter().take(LONGEST).position(|byte| *byte == 0)?;
    let text = std::str::from_utf8(bytes.get(..end)?).ok()?;
    let mut numbers = text.split('.').map(str::parse);
    let (major, minor) = (numbers.next()?.ok()?, numbers.next()?.ok()?);
    numbers.all(|number| number.is_ok()).then_some(Version { major, minor })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_version_counts_as_numbers_not_as_text() {
        let binary = b"\x7fELF..\0GLIBC_2.2.5\0GLIBC_2.14\0GLIBC_2.3.4\0exp\0";
        assert_eq!(needed(binary), Some(Version { major: 2, minor: 14 }));
        assert_eq!(needed(binary).unwrap().to_string(), "2.14");
    }

    #[test]
    fn what_is_no_version_counts_as_none() {
        for bytes in [&b""[..], b"GLIBC_", b"GLIBC_2.17", b"GLIBC_PRIVATE\0", b"GLIBC_2.x\0", b"GLIBC_2\0"] {
            assert_eq!(needed(bytes), None, "{bytes:?}");
        }
    }

    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    #[test]
    fn this_very_test_needs_one() {
        let bytes = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        assert!(needed(&bytes) >= Some(Version { major: 2, minor: 2 }));
    }
}
