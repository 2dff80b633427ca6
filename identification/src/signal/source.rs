//! Source of the text of a record, with the hash of the file as given: for a compressed file that of its compressed bytes, so that
//! `sha256sum` gives the same.

use std::io::{BufReader, Read};

use sha2::{Digest, Sha256};

/// Text of a file, and the hash of the file.
pub trait Source: Read + Send {
    /// SHA-256 of the bytes of the file read so far, in hexadecimal digits: at its end that of the whole file.
    fn sha256(&self) -> String;

    /// Total number of bytes of text, if known.
    fn size(&self) -> Option<u64>;
}

/// The bytes of a file, hashed while read.
pub struct Hashed<R> {
    bytes: R,
    size: Option<u64>,
    hash: Sha256,
}

impl<R> Hashed<R> {
    /// From the beginning of a file.
    pub fn new(bytes: R) -> Self {
        Self { bytes, size: None, hash: Sha256::new() }
    }

    /// For a file of this many bytes.
    #[must_use]
    pub fn of_size(self, size: Option<u64>) -> Self {
        Self { size, ..self }
    }
}

impl<R: Read> Read for Hashed<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.bytes.read(buffer)?;
        self.hash.update(&buffer[..count]);
        Ok(count)
    }
}

impl<R: Read + Send> Source for Hashed<R> {
    fn sha256(&self) -> String {
        self.hash.clone().finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    fn size(&self) -> Option<u64> {
        self.size
    }
}

impl<S: Source> Source for BufReader<S> {
    fn sha256(&self) -> String {
        self.get_ref().sha256()
    }

    fn size(&self) -> Option<u64> {
        self.get_ref().size()
    }
}
