//! The zip format: entries to bytes and back. Everything that the zip writer would otherwise take from the clock, the system or its own
//! defaults is set here.

use crate::error::{Error, Result};
use std::{
    io::{self, Cursor, Read as _, Write as _},
    sync::Arc,
};
use zip::{
    CompressionMethod, DateTime, System, ZipArchive, ZipWriter, read::ZipFile, result::ZipError,
    write::SimpleFileOptions,
};

/// Level 9, the maximum of the deflate backend, takes more than twice the time for 0.4 % of the size.
const COMPRESSION_LEVEL: i64 = 6;

/// Maximum ratio of unpacked to packed size of an archive above [`ALWAYS_UNPACKED`]: FMUs are libraries and XML, which shrink to a tenth.
const MOST_UNPACKED_RATIO: u64 = 200;

/// Unpacked size that is always accepted [bytes].
const ALWAYS_UNPACKED: u64 = 1 << 24;

/// Maximum number of entries of an archive: far more than FMUs have.
const MOST_ENTRIES: usize = 10_000;

/// Permissions of every entry.
const MODE: u32 = 0o644;

/// An entry as it is compressed in an archive.
#[derive(Clone)]
pub(super) struct Packed {
    archive: ZipArchive<Cursor<Arc<[u8]>>>,
    index: usize,
    /// Compressed [bytes].
    size: usize,
}

/// An entry of an archive.
pub(super) struct Read {
    /// Its name.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
    /// As it is in the archive, where it can be taken over.
    pub packed: Option<Packed>,
}

/// Metadata of every entry, besides name and bytes.
fn options() -> SimpleFileOptions {
    SimpleFileOptions::DEFAULT
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(COMPRESSION_LEVEL))
        .last_modified_time(DateTime::DEFAULT) // 1980-01-01 00:00:00
        .unix_permissions(MODE)
        .system(System::Unix)
}

/// The bytes of an archive with these entries, in this order.
pub(super) fn write<'a>(entries: impl Iterator<Item = (&'a str, &'a [u8], Option<&'a Packed>)>) -> Result<Vec<u8>> {
    let failed = |entry: &str, cause: ZipError| Error::Zip { entry: entry.into(), cause: cause.to_string() };
    let entries: Vec<_> = entries.collect();
    // Two headers of each entry have its name and some numbers.
    let expected = entries
        .iter()
        .map(|(name, bytes, packed)| packed.map_or(bytes.len(), |packed| packed.size) + 2 * name.len() + 100);
    let mut writer = ZipWriter::new(Cursor::new(Vec::with_capacity(expected.sum())));
    for (name, bytes, packed) in entries {
        if let Some(packed) = packed {
            let mut archive = packed.archive.clone();
            let file = archive.by_index_raw(packed.index).map_err(|cause| failed(name, cause))?;
            writer.raw_copy_file_touch(file, DateTime::DEFAULT, Some(MODE)).map_err(|cause| failed(name, cause))?;
            continue;
        }
        writer.start_file(name, options()).map_err(|cause| failed(name, cause))?;
        writer.write_all(bytes).map_err(|cause| failed(name, cause.into()))?;
    }
    let cursor = writer.finish().map_err(|cause| failed("(table of contents)", cause))?;
    Ok(cursor.into_inner())
}

/// Whether an entry has nothing that those written here have not: another compression, times and owners in extra fields, a comment.
fn is_plain<R: io::Read>(file: &ZipFile<'_, R>, name: &str) -> bool {
    file.compression() == CompressionMethod::Deflated
        && !file.encrypted()
        && file.extra_data().is_none_or(|fields| fields.is_empty())
        && file.comment().is_empty()
        && name.is_ascii()
}

/// The entries of an archive; `origin` names it in errors.
pub(super) fn read(bytes: Vec<u8>, origin: &str) -> Result<Vec<Read>> {
    let failed = |cause: String| Error::NotAnArchive { archive: origin.into(), cause };
    let failed_zip = |cause: ZipError| failed(cause.to_string());
    let size = u64::try_from(bytes.len()).unwrap_or(u64::MAX);
    let mut zip = ZipArchive::new(Cursor::new(Arc::from(bytes))).map_err(failed_zip)?;
    if zip.has_duplicate_names() {
        return Err(failed("two entries have the same name".into()));
    }
    if zip.len() > MOST_ENTRIES {
        return Err(failed(format!("it has {} entries, more than {MOST_ENTRIES}", zip.len())));
    }
    let archive = zip.clone();
    let mut left = size.saturating_mul(MOST_UNPACKED_RATIO).max(ALWAYS_UNPACKED);
    let mut entries = Vec::new();
    for index in 0..zip.len() {
        let mut file = zip.by_index(index).map_err(failed_zip)?;
        let name = file.name().map_err(failed_zip)?.into_owned();
        if file.is_dir() {
            continue;
        }
        if file.is_symlink() {
            return Err(failed(format!("the entry `{name}` is a symbolic link")));
        }
        let packed = is_plain(&file, &name).then(|| Packed {
            archive: archive.clone(),
            index,
            size: usize::try_from(file.compressed_size()).unwrap_or_default(),
        });
        let declared = usize::try_from(file.size().min(left)).unwrap_or_default();
        let mut bytes = Vec::with_capacity(declared);
        let read = file.by_ref().take(left.saturating_add(1)).read_to_end(&mut bytes);
        let read = read.map_err(|cause| failed(format!("the entry `{name}` is damaged: {cause}")))?;
        // A declared size may be wrong.
        bytes.shrink_to_fit();
        left = left.checked_sub(read as u64).ok_or_else(|| {
            failed(format!("with the entry `{name}` it unpacks to more than {MOST_UNPACKED_RATIO} times its size"))
        })?;
        entries.push(Read { name, bytes, packed });
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries that are compressed here.
    fn written(entries: &[(&str, &[u8])]) -> Vec<u8> {
        write(entries.iter().map(|(name, bytes)| (*name, *bytes, None))).unwrap()
    }

    type Writer = ZipWriter<Cursor<Vec<u8>>>;

    #[test]
    fn bytes_that_are_no_archive_are_refused_by_name() {
        let message = read(b"not a zip".to_vec(), "some.fmu").err().unwrap().to_string();
        assert!(message.contains("some.fmu") && message.contains("zip archive"), "{message}");
    }

    #[test]
    fn a_damaged_entry_is_noticed_and_named() {
        let content = "0123456789".repeat(100);
        let mut bytes = written(&[("data.txt", content.as_bytes())]);
        let inside_data = 30 + "data.txt".len() + 4; // a local header has 30 bytes before the name
        bytes[inside_data] ^= 0xff;
        let message = read(bytes, "some.fmu").err().unwrap().to_string();
        assert!(message.contains("data.txt"), "{message}");
    }

    #[test]
    fn an_archive_that_unpacks_to_far_more_than_its_size_is_refused() {
        let zeros = vec![0; (ALWAYS_UNPACKED / 2) as usize];
        assert!(read(written(&[("a", &zeros)]), "some.fmu").is_ok());
        let entries = ["a", "b", "c"].map(|name| (name, zeros.as_slice()));
        let message = read(written(&entries), "some.fmu").err().unwrap().to_string();
        assert!(message.contains("`c`") && message.contains("200 times"), "{message}");
    }

    #[test]
    fn an_archive_of_too_many_entries_is_refused() {
        let names: Vec<String> = (0..=MOST_ENTRIES).map(|number| number.to_string()).collect();
        let bytes = write(names.iter().map(|name| (name.as_str(), &b""[..], None))).unwrap();
        assert!(read(bytes, "some.fmu").err().unwrap().to_string().contains("10001 entries"));
    }

    #[test]
    fn folders_are_skipped_and_links_and_bad_names_refused() {
        let build = |fill: fn(&mut Writer)| {
            let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
            fill(&mut writer);
            writer.finish().unwrap().into_inner()
        };
        let folder = build(|zip| zip.add_directory("resources/", options()).unwrap());
        assert!(read(folder, "f").unwrap().is_empty());
        let link = build(|zip| zip.add_symlink("link", "/etc/passwd", options()).unwrap());
        assert!(matches!(read(link, "f"), Err(Error::NotAnArchive { .. })));
        let outside = build(|zip| zip.start_file("../outside", options()).unwrap());
        assert!(matches!(crate::archive::Archive::from_bytes(&outside), Err(Error::EntryName { .. })));
    }

    #[test]
    fn entries_with_metadata_of_their_own_are_compressed_again() {
        let with = |options: SimpleFileOptions| {
            let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
            writer.start_file("data.txt", options).unwrap();
            writer.write_all(b"content").unwrap();
            writer.finish().unwrap().into_inner()
        };
        let is_taken_over = |bytes: Vec<u8>| read(bytes, "f").unwrap()[0].packed.is_some();
        assert!(is_taken_over(with(options())));
        assert!(!is_taken_over(with(options().compression_method(CompressionMethod::Stored).compression_level(None))));
        let later = with(options().last_modified_time(DateTime::from_date_and_time(2020, 2, 3, 4, 5, 6).unwrap()));
        let entries = read(later, "f").unwrap();
        let entries = entries.iter().map(|entry| (entry.name.as_str(), entry.bytes.as_slice(), entry.packed.as_ref()));
        assert_eq!(write(entries).unwrap(), written(&[("data.txt", b"content")]));
    }
}
