//! A record in blocks, for files that are longer than memory: it is read once, and what is kept does not grow.

use std::path::Path;

use super::{
    record::Format,
    rows::{Rows, Sample},
};
use crate::error::Result;

/// Reads a record file in blocks of samples.
pub struct Stream {
    rows: Rows,
    block: Vec<Sample>,
    length: usize,
}

impl Stream {
    /// Samples in a block when the caller has no wish.
    pub const BLOCK: usize = 4096;

    /// Opens a file; blocks have `length` samples, the last one what is left.
    ///
    /// # Errors
    /// An unreadable file; a column that is not in its header.
    pub fn open(path: &Path, format: &Format, length: usize) -> Result<Self> {
        Ok(Self { rows: Rows::open(path, format)?, block: Vec::with_capacity(length), length: length.max(1) })
    }

    /// The next block; none at the end.
    ///
    /// # Errors
    /// As for [`Record::read`](super::record::Record::read); what concerns the file as a whole (too few samples, a command
    /// that never moves) with its last block.
    pub fn next_block(&mut self) -> Result<Option<&[Sample]>> {
        self.block.clear();
        while self.block.len() < self.length {
            match self.rows.next_sample()? {
                Some(sample) => self.block.push(sample),
                None => break,
            }
        }
        Ok(if self.block.is_empty() { None } else { Some(&self.block) })
    }

    /// SHA-256 of what was read so far: of the whole file after the last block.
    #[must_use]
    pub fn sha256(&self) -> String {
        self.rows.sha256()
    }
}
