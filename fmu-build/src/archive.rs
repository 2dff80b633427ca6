//! The archive: entry names and their bytes, independent of when, where and by whom it was written.
//!
//! The same entries give the same bytes on every computer: `modelDescription.xml` comes first, because importers read
//! it first, the others follow in the order of their names; all are deflated, with mode 0644 and the earliest time that
//! the zip format knows, 1980-01-01.

use crate::{
    atomic::{self, Overwrite},
    error::{Error, Result},
    folder,
};
use std::{collections::BTreeMap, fmt, path::Path};

mod name;
mod zip_format;

use zip_format::Packed;

/// The one entry of every FMU.
pub const MODEL_DESCRIPTION: &str = "modelDescription.xml";

/// An FMU, or any other zip archive, in memory.
#[derive(Clone, Default, PartialEq, Eq)]
pub struct Archive {
    entries: BTreeMap<String, Entry>,
}

#[derive(Clone)]
struct Entry {
    bytes: Vec<u8>,
    /// As read, where it need not be compressed again.
    packed: Option<Packed>,
}

impl From<Vec<u8>> for Entry {
    fn from(bytes: Vec<u8>) -> Self {
        Self { bytes, packed: None }
    }
}

/// Equal content, however it was packed.
impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.bytes == other.bytes
    }
}

impl Eq for Entry {}

impl Archive {
    /// An archive without entries.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Reads a file. Folders get no entries here; entries with names that [`Archive::insert`] refuses are refused here as well.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::from_entries(zip_format::read(folder::read_file(path)?, &path.display().to_string())?)
    }

    /// Reads an archive that is already in memory.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        Self::from_entries(zip_format::read(bytes.to_vec(), "these bytes")?)
    }

    fn from_entries(entries: Vec<zip_format::Read>) -> Result<Self> {
        let mut archive = Self::new();
        for zip_format::Read { name, bytes, packed } in entries {
            archive.add(name, Entry { bytes, packed })?;
        }
        Ok(archive)
    }

    /// Adds an entry. Refuses a name that would not unpack everywhere below the archive's own folder, and a name that already exists, also
    /// in another case: Windows and macOS would overwrite one with the other.
    pub fn insert(&mut self, name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Result<()> {
        self.add(name.into(), bytes.into().into())
    }

    fn add(&mut self, name: String, entry: Entry) -> Result<()> {
        if let Some(problem) = name::problem(&name) {
            return Err(Error::EntryName { name, problem });
        }
        let taken = |existing: &&String| existing.eq_ignore_ascii_case(&name);
        if let Some(existing) = self.entries.keys().find(taken) {
            return Err(Error::DuplicateEntry { existing: existing.clone(), name });
        }
        self.entries.insert(name, entry);
        Ok(())
    }

    /// Replaces the bytes of an entry and returns the old ones. Refuses a name that does not exist.
    pub fn replace(&mut self, name: &str, bytes: impl Into<Vec<u8>>) -> Result<Vec<u8>> {
        match self.entries.get_mut(name) {
            Some(entry) => Ok(std::mem::replace(entry, bytes.into().into()).bytes),
            None => {
                Err(Error::MissingEntry { name: name.into(), available: self.names().collect::<Vec<_>>().join(", ") })
            }
        }
    }

    /// Removes an entry, if it exists.
    pub fn remove(&mut self, name: &str) -> Option<Vec<u8>> {
        self.entries.remove(name).map(|entry| entry.bytes)
    }

    /// The bytes of an entry.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&[u8]> {
        self.entries.get(name).map(|entry| entry.bytes.as_slice())
    }

    /// The names, in the order of the archive.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries().map(|(name, _)| name)
    }

    /// Names and bytes, in the order of the archive: the description first, then by name.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.ordered().map(|(name, entry)| (name, entry.bytes.as_slice()))
    }

    fn ordered(&self) -> impl Iterator<Item = (&str, &Entry)> {
        let description = self.entries.get_key_value(MODEL_DESCRIPTION);
        let others = self.entries.iter().filter(|(name, _)| *name != MODEL_DESCRIPTION);
        description.into_iter().chain(others).map(|(name, entry)| (name.as_str(), entry))
    }

    /// The archive as the bytes of a file. The same entries always give the same bytes; those of an archive that was read stay compressed as they
    /// are, which is the same if it was written here.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        zip_format::write(self.ordered().map(|(name, entry)| (name, entry.bytes.as_slice(), entry.packed.as_ref())))
    }

    /// Writes the archive to a file, creating the folders above it. The file is written completely or not at all.
    pub fn write(&self, path: impl AsRef<Path>, overwrite: Overwrite) -> Result<()> {
        atomic::write(path.as_ref(), &self.to_bytes()?, overwrite)
    }
}

/// Names and sizes; the bytes themselves would fill the screen.
impl fmt::Debug for Archive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_map().entries(self.entries().map(|(name, bytes)| (name, bytes.len()))).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Archive {
        let mut archive = Archive::new();
        for name in ["resources/z.csv", "binaries/linux64/M.so", MODEL_DESCRIPTION, "model.png"] {
            archive.insert(name, name.repeat(50)).unwrap();
        }
        archive
    }

    #[test]
    fn the_description_comes_first_and_the_others_by_name() {
        let archive = example();
        let names: Vec<_> = archive.names().collect();
        assert_eq!(names, [MODEL_DESCRIPTION, "binaries/linux64/M.so", "model.png", "resources/z.csv"]);
    }

    #[test]
    fn an_archive_is_read_back_as_it_was_written() {
        let archive = example();
        assert_eq!(Archive::from_bytes(&archive.to_bytes().unwrap()).unwrap(), archive);
    }

    #[test]
    fn an_archive_that_was_read_is_written_as_it_was_and_changed_where_it_is_changed() {
        let archive = example();
        let bytes = archive.to_bytes().unwrap();
        let read = Archive::from_bytes(&bytes).unwrap();
        assert!(read.entries.values().all(|entry| entry.packed.is_some()));
        assert_eq!(read.to_bytes().unwrap(), bytes);
        let [mut changed, mut made] = [read, archive];
        for archive in [&mut changed, &mut made] {
            archive.replace("model.png", "new".repeat(20)).unwrap();
            archive.remove("resources/z.csv");
            archive.insert("resources/a.csv", "0,1").unwrap();
        }
        assert_eq!(changed.to_bytes().unwrap(), made.to_bytes().unwrap());
    }

    #[test]
    fn the_order_of_insertion_does_not_matter() {
        let archive = example();
        let mut reversed = Archive::new();
        for (name, bytes) in archive.entries().collect::<Vec<_>>().into_iter().rev() {
            reversed.insert(name, bytes).unwrap();
        }
        assert_eq!(reversed.to_bytes().unwrap(), archive.to_bytes().unwrap());
    }

    #[test]
    fn a_name_is_taken_once_in_whatever_case() {
        let mut archive = example();
        for name in ["model.png", "Model.PNG"] {
            assert!(matches!(archive.insert(name, "x"), Err(Error::DuplicateEntry { .. })), "{name}");
        }
        assert_eq!(archive, example());
    }

    #[test]
    fn entries_are_replaced_and_removed_only_if_they_are_there() {
        let mut archive = example();
        assert_eq!(archive.replace("model.png", "new").unwrap(), "model.png".repeat(50).into_bytes());
        assert_eq!(archive.get("model.png"), Some(&b"new"[..]));
        let message = archive.replace("icon.png", "new").unwrap_err().to_string();
        assert!(message.contains("`icon.png`") && message.contains("model.png"), "{message}");
        assert_eq!(archive.remove("model.png"), Some(b"new".to_vec()));
        assert_eq!(archive.remove("model.png"), None);
    }
}
