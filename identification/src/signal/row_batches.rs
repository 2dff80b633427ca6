//! Rows of a CSV file, split into fields ahead of the one who reads their numbers: a thread of its own reads the file, hashes it and finds the
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

/// The beginning of a file, from which its dialect is told, and the rest of it.
pub type Text = Chain<Cursor<Vec<u8>>, Box<dyn Source>>;

/// Bytes of the file after which a batch is handed on: a few hundred rows.
const BATCH_BYTES: u64 = 1 << 15;

/// Batches that wait for the reader of numbers.
const WAITING: usize = 4;

/// Rows that follow one another.
#[derive(Default)]
struct Batch {
    /// The first `count` of them; behind these, buffers to be used again.
    rows: Vec<csv::ByteRecord>,
    /// The lines in which they stand.
    lines: Vec<Option<usize>>,
    count: usize,
    end: Option<End>,
}

/// What comes after the last row of the last batch.
enum End {
    /// The end of the file, with its hash.
    File(String),
    /// A row that is none, and its line.
    Row(csv::Error, Option<usize>),
}

/// The rows of a file, in their order.
pub struct RowBatches {
    full: Receiver<Batch>,
    used: Sender<Batch>,
    batch: Batch,
    next: usize,
    sha256: String,
}

impl RowBatches {
    /// Goes on where `reader` is.
    ///
    /// # Errors
    /// A computer that has no thread left.
    pub fn start(reader: csv::Reader<Text>, dialect: Dialect) -> Result<Self> {
        let (sender, full) = sync_channel(WAITING);
        let (used, empty) = channel();
        thread::Builder::new()
            .name("rows".into())
            .spawn(move || split(reader, &dialect, &sender, &empty))
            .map_err(|error| Error::new("thread", error.to_string(), "a computer that can start one"))?;
        Ok(Self { full, used, batch: Batch::default(), next: 0, sha256: String::new() })
    }

    /// The next row; none at the end of the file.
    ///
    /// # Errors
    /// A row that is none, and its line.
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

    /// The row that was read last.
    pub fn row(&self) -> Option<&csv::ByteRecord> {
        self.next.checked_sub(1).map(|last| &self.batch.rows[last])
    }

    /// The line in which it stands [from 1].
    pub fn line(&self) -> Option<usize> {
        self.batch.lines.get(self.next.checked_sub(1)?).copied().flatten()
    }

    /// SHA-256 of the file, once the last row is out.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }
}

/// Whether a row is a comment behind a mark that the beginning of the file does not have.
fn is_comment(row: &csv::ByteRecord) -> bool {
    row.as_slice().first().is_some_and(|mark| COMMENTS.contains(mark))
}

/// What the CSV reader makes of a comment that the file ends in without an end of line.
fn is_empty(row: &csv::ByteRecord) -> bool {
    row.as_slice().is_empty() && row.len() == 1
}

/// Splits until the file ends, or nobody wants its rows any more.
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
