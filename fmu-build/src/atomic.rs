//! Writes a file atomically: completely or not at all. The bytes go to a temporary file in the same folder, which is then renamed; on any
//! failure the temporary file is removed.

use crate::error::{Error, Result};
use std::{fs, io::Write as _, path::Path};
use tempfile::NamedTempFile;

/// Whether an existing file may be replaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overwrite {
    /// Replace it.
    Allow,
    /// Refuse with [`Error::Exists`].
    Refuse,
}

impl Overwrite {
    /// Refuses before the compilation what [`write`] would refuse after it.
    pub(crate) fn check(self, path: &Path) -> Result<()> {
        match self {
            Self::Refuse if path.symlink_metadata().is_ok() => Err(Error::Exists { path: path.into() }),
            _ => Ok(()),
        }
    }
}

/// Prefix of the names of temporary files. A process that is killed leaves at most those that it was writing.
pub const TEMPORARY_PREFIX: &str = ".fmu-build-";

/// Writes `bytes` to `path`, creating the folders above it.
pub fn write(path: &Path, bytes: &[u8], overwrite: Overwrite) -> Result<()> {
    write_all(&[(path, bytes)], overwrite)
}

/// Writes files that belong together: none of them appears before all have been written, so that a full disk leaves the old ones intact.
pub fn write_all<P: AsRef<Path>>(files: &[(P, &[u8])], overwrite: Overwrite) -> Result<()> {
    let staged: Vec<NamedTempFile> =
        files.iter().map(|(path, bytes)| stage(path.as_ref(), bytes, overwrite)).collect::<Result<_>>()?;
    files.iter().zip(staged).try_for_each(|((path, _), temporary)| publish(path.as_ref(), temporary, overwrite))
}

/// The bytes as a temporary file beside `path`.
fn stage(path: &Path, bytes: &[u8], overwrite: Overwrite) -> Result<NamedTempFile> {
    let failed = |cause| Error::Write { path: path.into(), cause };
    overwrite.check(path)?;
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    fs::create_dir_all(folder).map_err(failed)?;
    let mut temporary = temporary_file(folder).map_err(failed)?;
    temporary.write_all(bytes).map_err(failed)?;
    Ok(temporary)
}

/// Gives a temporary file its name.
fn publish(path: &Path, temporary: NamedTempFile, overwrite: Overwrite) -> Result<()> {
    let failed = |cause| Error::Write { path: path.into(), cause };
    let renamed = match overwrite {
        Overwrite::Allow => temporary.persist(path),
        Overwrite::Refuse => temporary.persist_noclobber(path),
    };
    match renamed {
        Ok(_) => Ok(()),
        // Another process wrote it since the check above.
        Err(refused) if overwrite == Overwrite::Refuse && path.exists() => {
            drop(refused.file);
            Err(Error::Exists { path: path.into() })
        }
        Err(refused) => Err(failed(refused.error)),
    }
}

fn temporary_file(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY_PREFIX);
    // Temporary files are private by default; an output gets the usual permissions of the user's files.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn folders_are_created_and_the_file_is_all_there_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/c.fmu");
        write(&path, b"content", Overwrite::Refuse).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"content");
        assert_eq!(names_in(path.parent().unwrap()), ["c.fmu"]);
    }

    #[test]
    fn an_existing_file_stays_unless_it_may_be_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.fmu");
        write(&path, b"old", Overwrite::Refuse).unwrap();
        let message = write(&path, b"new", Overwrite::Refuse).unwrap_err().to_string();
        assert!(message.contains("already exists") && message.contains("--force"), "{message}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        write(&path, b"new", Overwrite::Allow).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names_in(folder.path()), ["c.fmu"]);
    }

    #[test]
    fn files_that_belong_together_are_all_written_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let [one, two] = ["one", "two"].map(|name| folder.path().join(name));
        fs::write(&two, b"old").unwrap();
        assert!(write_all(&[(&one, &b"new"[..]), (&two, b"new")], Overwrite::Refuse).is_err());
        assert_eq!(names_in(folder.path()), ["two"]);
        write_all(&[(&one, &b"new"[..]), (&two, b"new")], Overwrite::Allow).unwrap();
        assert_eq!((fs::read(&one).unwrap(), fs::read(&two).unwrap()), (b"new".to_vec(), b"new".to_vec()));
    }

    #[test]
    fn a_failed_write_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let in_the_way = folder.path().join("c.fmu");
        fs::create_dir(&in_the_way).unwrap();
        assert!(matches!(write(&in_the_way, b"content", Overwrite::Allow), Err(Error::Write { .. })));
        assert_eq!(names_in(folder.path()), ["c.fmu"]);
    }

    #[cfg(unix)]
    #[test]
    fn the_file_is_readable_by_others_as_far_as_the_umask_allows() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write(&ours, b"", Overwrite::Refuse).unwrap();
        fs::write(&plain, b"").unwrap();
        let mode = |path: &Path| path.metadata().unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
