//! Results on disk, each with hashes of its inputs.

use std::{fmt::Write as _, fs, io, path::Path};

use serde::{Deserialize, Serialize, de::DeserializeOwned};
use sha2::{Digest, Sha256};

use crate::files;
use actuator_fmu::error::{Error, Result};

/// Incremented when the same record and options give a different result.
const REVISION: u32 = 2;

/// The inputs of a result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Key {
    data_sha256: String,
    options_sha256: String,
}

impl Key {
    /// From the hash of the data and a text of all relevant options; version and revision of the program are added.
    pub fn new(data_sha256: String, options: &str) -> Self {
        let all = format!("{} {REVISION} {options}", env!("CARGO_PKG_VERSION"));
        Self { data_sha256, options_sha256: hex(&Sha256::digest(all.as_bytes())) }
    }
}

#[derive(Serialize, Deserialize)]
struct Stored<T> {
    key: Key,
    result: T,
}

/// The stored result, if its inputs are the same.
pub fn read<T: DeserializeOwned>(path: &Path, key: &Key) -> Option<T> {
    let stored: Stored<T> = serde_json::from_slice(&fs::read(path).ok()?).ok()?;
    (stored.key == *key).then_some(stored.result)
}

/// Writes a result atomically.
pub fn write<T: Serialize>(path: &Path, key: &Key, result: &T) -> Result<()> {
    let text = serde_json::to_vec(&Stored { key: key.clone(), result })
        .map_err(|error| Error::new("result", error.to_string(), "values that JSON can hold"))?;
    files::write_new(path, &text, true)
}

/// SHA-256 of a file, read in pieces.
pub fn file_sha256(path: &Path) -> Result<String> {
    let mut hash = Sha256::new();
    let read = fs::File::open(path).and_then(|mut file| io::copy(&mut file, &mut Sink(&mut hash)));
    read.map_err(|error| {
        Error::new("record", error.to_string(), "a readable CSV file").remedy("check the path").at(path, None)
    })?;
    Ok(hex(&hash.finalize()))
}

/// SHA-256 of a text.
pub fn text_sha256(text: &str) -> String {
    hex(&Sha256::digest(text.as_bytes()))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

struct Sink<'a>(&'a mut Sha256);

impl io::Write for Sink<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_found_again_only_for_the_same_data_and_options() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b.json");
        let key = Key::new("data".into(), "options");
        write(&path, &key, &[1.0, 0.1]).unwrap();
        assert_eq!(read(&path, &key), Some([1.0, 0.1]));
        assert_eq!(read::<[f64; 2]>(&path, &Key::new("other".into(), "options")), None);
        assert_eq!(read::<[f64; 2]>(&path, &Key::new("data".into(), "other")), None);
        fs::write(&path, &fs::read(&path).unwrap()[..20]).unwrap();
        assert_eq!(read::<[f64; 2]>(&path, &key), None);
    }

    #[test]
    fn the_hash_of_a_file_is_the_standard_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc");
        fs::write(&path, "abc").unwrap();
        // FIPS 180-4, example of one block.
        assert!(file_sha256(&path).unwrap().starts_with("ba7816bf8f01cfea414140de5dae2223"));
        assert_eq!(file_sha256(&path).unwrap(), text_sha256("abc"));
    }
}
