//! The zip format: entries to bytes and back. Everything that the zip writer would otherwise take from the clock, the system or its own
//! defaults is set here.

use crate::error::{Error, Result};
use std::io::{Cursor, Read as _, Write as _};
use zip::{CompressionMethod, DateTime, System, ZipArchive, ZipWriter, result::ZipError, write::SimpleFileOptions};

/// Level 9, the maximum of the deflate backend, takes more than twice the time for 0.4 % of the size.
const COMPRESSION_LEVEL: i64 = 6;

/// Maximum ratio of unpacked to packed size of an archive above [`ALWAYS_UNPACKED`]: FMUs are libraries and XML, which shrink to a tenth.
const MOST_UNPACKED_RATIO: u64 = 200;

/// Unpacked size that is always accepted [bytes].
const ALWAYS_UNPACKED: u64 = 1 << 24;

/// Maximum number of entries of an archive: far more than FMUs have.
const MOST_ENTRIES: usize = 10_000;

/// Metadata of every entry, besides name and bytes.
fn options() -> SimpleFileOptions {
    SimpleFileOptions::DEFAULT
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(COMPRESSION_LEVEL))
        .last_modified_time(DateTime::DEFAULT) // 1980-01-01 00:00:00
        .unix_permissions(0o644)
        .system(System::Unix)
}

/// The bytes of an archive with these entries, in this order.
pub(super) fn write<'a>(entries: impl Iterator<Item = (&'a str, &'a [u8])>) -> Result<Vec<u8>> {
    let failed = |entry: &str, cause: ZipError| Error::Zip { entry: entry.into(), cause: cause.to_string() };
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        writer.start_file(name, options()).map_err(|cause| failed(name, cause))?;
        writer.write_all(bytes).map_err(|cause| failed(name, cause.into()))?;
    }
    let cursor = writer.finish().map_err(|cause| failed("(table of contents)", cause))?;
    Ok(cursor.into_inner())
}

/// Names and bytes of the entries of an archive; `origin` names it in errors.
pub(super) fn read(bytes: &[u8], origin: &str) -> Result<Vec<(String, Vec<u8>)>> {
    let failed = |cause: String| Error::NotAnArchive { archive: origin.into(), cause };
    let failed_zip = |cause: ZipError| failed(cause.to_string());
    let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(failed_zip)?;
    if zip.has_duplicate_names() {
        return Err(failed("two entries have the same name".into()));
    }
    if zip.len() > MOST_ENTRIES {
        return Err(failed(format!("it has {} entries, more than {MOST_ENTRIES}", zip.len())));
    }
    let size = u64::try_from(bytes.len()).unwrap_or(u64::MAX);
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
        let mut content = Vec::new();
        let read = file.by_ref().take(left.saturating_add(1)).read_to_end(&mut content);
        let read = read.map_err(|cause| failed(format!("the entry `{name}` is damaged: {cause}")))?;
        left = left.checked_sub(read as u64).ok_or_else(|| {
            failed(format!("with the entry `{name}` it unpacks to more than {MOST_UNPACKED_RATIO} times its size"))
        })?;
        entries.push((name, content));
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    type Writer = ZipWriter<Cursor<Vec<u8>>>;

    #[test]
    fn bytes_that_are_no_archive_are_refused_by_name() {
        let message = read(b"not a zip", "some.fmu").unwrap_err().to_string();
        assert!(message.contains("some.fmu") && message.contains("zip archive"), "{message}");
    }

    #[test]
    fn a_damaged_entry_is_noticed_and_named() {
        let content = "0123456789".repeat(100);
        let mut bytes = write([("data.txt", content.as_bytes())].into_iter()).unwrap();
        let inside_data = 30 + "data.txt".len() + 4; // a local header has 30 bytes before the name
        bytes[inside_data] ^= 0xff;
        let message = read(&bytes, "some.fmu").unwrap_err().to_string();
        assert!(message.contains("data.txt"), "{message}");
    }

    #[test]
    fn an_archive_that_unpacks_to_far_more_than_its_size_is_refused() {
        let zeros = vec![0; (ALWAYS_UNPACKED / 2) as usize];
        assert!(read(&write([("a", &*zeros)].into_iter()).unwrap(), "some.fmu").is_ok());
        let entries = ["a", "b", "c"].map(|name| (name, &*zeros));
        let message = read(&write(entries.into_iter()).unwrap(), "some.fmu").unwrap_err().to_string();
        assert!(message.contains("`c`") && message.contains("200 times"), "{message}");
    }

    #[test]
    fn an_archive_of_too_many_entries_is_refused() {
        let names: Vec<String> = (0..=MOST_ENTRIES).map(|number| number.to_string()).collect();
        let bytes = write(names.iter().map(|name| (name.as_str(), &b""[..]))).unwrap();
        assert!(read(&bytes, "some.fmu").unwrap_err().to_string().contains("10001 entries"));
    }

    #[test]
    fn folders_are_skipped_and_links_and_bad_names_refused() {
        let build = |fill: fn(&mut Writer)| {
            let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
            fill(&mut writer);
            writer.finish().unwrap().into_inner()
        };
        let folder = build(|zip| zip.add_directory("resources/", options()).unwrap());
        assert!(read(&folder, "f").unwrap().is_empty());
        let link = build(|zip| zip.add_symlink("link", "/etc/passwd", options()).unwrap());
        assert!(matches!(read(&link, "f"), Err(Error::NotAnArchive { .. })));
        let outside = build(|zip| zip.start_file("../outside", options()).unwrap());
        assert!(matches!(crate::archive::Archive::from_bytes(&outside), Err(Error::EntryName { .. })));
    }
}
