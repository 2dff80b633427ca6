//! Rows of a CSV file, split into fields ahead of the reader of their numbers: a separate thread reads the file, hashes it and finds the
//! ends of fields, which is half of the work.

use std::{
    io::{self, Chain, Cursor},
    mem,
    sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel},
    thread,
};

use super::{
    dialect::{COMMENTS, Dialect, holds_row, is_of_other_length},
    source::Source,
};
use actuator_fmu::error::{Error, Result};

/// The beginning of a file, used for detecting its dialect, and the remainder.
pub type Text = Chain<Cursor<Vec<u8>>, Box<dyn Source>>;

/// Bytes of the file per batch: a few hundred rows.
const BATCH_BYTES: u64 = 1 << 15;

/// Number of queued batches.
const WAITING: usize = 4;

/// Consecutive rows.
#[derive(Default)]
struct Batch {
    /// The first `count` are rows; the others are buffers for reuse.
    rows: Vec<csv::ByteRecord>,
    /// Their lines.
    lines: Vec<Option<usize>>,
    count: usize,
    end: Option<End>,
}

/// What follows the last row of the last batch.
enum End {
    /// The end of the file, with its hash.
    File(String),
    /// An invalid row, and its line.
    Row(csv::Error, Option<usize>),
}

/// The rows of a file, in order.
pub struct RowBatches {
    full: Receiver<Batch>,
    used: Sender<Batch>,
    batch: Batch,
    next: usize,
    sha256: String,
}

impl RowBatches {
    /// Continues at the position of `reader`.
    ///
    /// # Errors
    /// A system that cannot start a thread.
    pub fn start(reader: csv::Reader<Text>, dialect: Dialect) -> Result<Self> {
        let (sender, full) = sync_channel(WAITING);
        let (used, empty) = channel();
        thread::Builder::new()
            .name("rows".into())
            .spawn(move || split(reader, &dialect, &sender, &empty))
            .map_err(|error| Error::new("thread", error.to_string(), "a computer that can start one"))?;
        Ok(Self { full, used, batch: Batch::default(), next: 0, sha256: String::new() })
    }

    /// The next row; `None` at the end of the file.
    ///
    /// # Errors
    /// An invalid row, and its line.
    pub fn next_row(&mut self) -> std::result::Result<Option<&csv::ByteRecord>, (csv::Error, Option<usize>)> {
        while self.next == self.batch.count {
            if !self.sha256.is_empty() {
                return Ok(None);
            }
            match self.batch.end.take() {
                Some(End::Row(error, line)) => return Err((error, line)),
                Some(End::File(sha256)) => self.sha256 = sha256,
                None => {
                    let beyond = |_| (io::Error::other("rows behind one that is none").into(), None);
                    let full = self.full.recv().map_err(beyond)?;
                    let _ = self.used.send(mem::replace(&mut self.batch, full));
                    self.next = 0;
                }
            }
        }
        self.next += 1;
        Ok(Some(&self.batch.rows[self.next - 1]))
    }

    /// The latest row.
    pub fn row(&self) -> Option<&csv::ByteRecord> {
        self.next.checked_sub(1).map(|last| &self.batch.rows[last])
    }

    /// Its line [from 1].
    pub fn line(&self) -> Option<usize> {
        self.batch.lines.get(self.next.checked_sub(1)?).copied().flatten()
    }

    /// SHA-256 of the file, after the last row.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }
}

/// Whether a row is a comment with a mark that does not occur in the beginning of the file.
fn is_comment(row: &csv::ByteRecord) -> bool {
    row.as_slice().first().is_some_and(|mark| COMMENTS.contains(mark))
}

/// Result of the CSV reader for a comment at the end of the file without a line end.
fn is_empty(row: &csv::ByteRecord) -> bool {
    row.as_slice().is_empty() && row.len() == 1
}

/// Splits until the file ends, or the receiver is dropped.
fn split(mut reader: csv::Reader<Text>, dialect: &Dialect, full: &SyncSender<Batch>, empty: &Receiver<Batch>) {
    loop {
        let mut batch = empty.try_recv().unwrap_or_default();
        batch.count = 0;
        batch.lines.clear();
        let begin = reader.position().byte();
        while batch.end.is_none() && reader.position().byte() < begin + BATCH_BYTES {
            if batch.count == batch.rows.len() {
                batch.rows.push(csv::ByteRecord::new());
            }
            let row = &mut batch.rows[batch.count];
            match reader.read_byte_record(row) {
                Ok(true) if is_comment(row) => {}
                Err(error) if is_of_other_length(&error) && (is_comment(row) || is_empty(row)) => {}
                read if holds_row(&read, row) => {
                    batch.lines.push(dialect.line_of(row, &reader));
                    batch.count += 1;
                }
                Ok(_) => batch.end = Some(End::File(reader.get_ref().get_ref().1.sha256())),
                Err(error) => batch.end = Some(End::Row(error, dialect.line_of(row, &reader))),
            }
        }
        let ended = batch.end.is_some();
        if full.send(batch).is_err() || ended {
            return;
        }
    }
}
