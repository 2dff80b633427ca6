//! Reads a folder into a map of relative names and bytes, for documentation and resources.
//!
//! Names have forward slashes on every system. Hidden files (a leading dot) are left out: editors and file browsers create them, and an FMU
//! must not depend on who has looked at its folder.

use crate::error::{Error, Result};
use std::{collections::BTreeMap, fs, path::Path};

/// All files below `folder`, recursively.
pub(crate) fn read(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>> {
    let mut files = BTreeMap::new();
    read_into(folder, "", &mut files)?;
    Ok(files)
}

/// The bytes of one file.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).map_err(|cause| Error::Read { path: path.into(), cause })
}

fn read_into(folder: &Path, prefix: &str, files: &mut BTreeMap<String, Vec<u8>>) -> Result<()> {
    let failed = |cause| Error::Read { path: folder.into(), cause };
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let path = entry.path();
        let file_name = entry.file_name();
        let Some(file_name) = file_name.to_str() else {
            return Err(Error::Unpackable { path, problem: "has a name that is not UTF-8" });
        };
        if file_name.starts_with('.') {
            continue;
        }
        let name = format!("{prefix}{file_name}");
        let kind = entry.file_type().map_err(failed)?;
        if kind.is_dir() {
            read_into(&path, &format!("{name}/"), files)?;
        } else if path.is_file() {
            files.insert(name, read_file(&path)?);
        } else {
            // Including links to folders, which may form a cycle.
            return Err(Error::Unpackable { path, problem: "is neither a file nor a folder nor a link to a file" });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_relative_with_forward_slashes_and_hidden_files_stay_out() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir_all(folder.path().join("images/.cache")).unwrap();
        for name in ["index.html", "images/a.png", "images/.DS_Store", "images/.cache/x"] {
            fs::write(folder.path().join(name), name).unwrap();
        }
        let files = read(folder.path()).unwrap();
        assert_eq!(files.keys().collect::<Vec<_>>(), ["images/a.png", "index.html"]);
        assert_eq!(files["images/a.png"], b"images/a.png");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_a_file_is_followed_and_a_link_to_a_folder_refused() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.txt"), "text").unwrap();
        symlink("a.txt", folder.path().join("b.txt")).unwrap();
        assert_eq!(read(folder.path()).unwrap()["b.txt"], b"text");
        symlink(".", folder.path().join("round")).unwrap();
        assert!(matches!(read(folder.path()), Err(Error::Unpackable { .. })));
    }

    #[test]
    fn a_missing_folder_is_named() {
        let message = read(Path::new("no/such/folder")).unwrap_err().to_string();
        assert!(message.contains("no/such/folder"), "{message}");
    }
}
