//! The rows of a record file, one at a time, checked: what [`Record`](super::record::Record) collects and
//! [`Stream`](super::stream::Stream) hands on in blocks.

use std::{
    fs::File,
    io::{BufReader, Read},
    path::{Path, PathBuf},
    str::FromStr,
};

use sha2::{Digest, Sha256};

use super::record::{Columns, Format, Unit};
use crate::error::{Error, Result};

/// Fewest samples of a record: half a second at the report's 200 samples/s, below which nothing can be estimated.
pub const FEWEST_SAMPLES: usize = 100;

/// One row, in the units that the record is kept in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// \[s\]
    pub time: f64,
    /// In the unit of the record.
    pub command: f64,
    /// In the unit of the record.
    pub position: f64,
    /// In the unit of the record, where the file has it.
    pub load: Option<f64>,
}

/// A reader that hashes what passes through it.
struct Hashing {
    file: BufReader<File>,
    hash: Sha256,
}

impl Read for Hashing {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.hash.update(&buffer[..count]);
        Ok(count)
    }
}

/// Reads a record row by row. Memory does not grow with the length of the file.
pub struct Rows {
    path: PathBuf,
    reader: csv::Reader<Hashing>,
    row: csv::ByteRecord,
    columns: [usize; 3],
    load_column: Option<usize>,
    names: Columns,
    scale: f64,
    count: usize,
    last_time: f64,
    first_command: f64,
    moved: bool,
}

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 16;

impl Rows {
    /// Opens the file and finds its columns.
    ///
    /// # Errors
    /// An unreadable file; a column that is not in its header.
    pub fn open(path: &Path, format: &Format) -> Result<Self> {
        let file = File::open(path).map_err(|error| {
            Error::new("record", error.to_string(), "a readable CSV file").remedy("check the path").at(path, None)
        })?;
        let hashing = Hashing { file: BufReader::with_capacity(BUFFER_BYTES, file), hash: Sha256::new() };
        let mut reader = csv::ReaderBuilder::new().buffer_capacity(BUFFER_BYTES).from_reader(hashing);
        let headers = reader
            .headers()
            .map_err(|error| Error::new("header", error.to_string(), "CSV with a header row").at(path, Some(1)))?
            .clone();
        let find = |name: &str| headers.iter().position(|header| header.trim() == name);
        let column = |role: &str, name: &str| {
            find(name).ok_or_else(|| {
                let found: Vec<&str> = headers.iter().map(str::trim).collect();
                Error::new(format!("column `{name}`"), format!("only {}", found.join(", ")), "a header that names it")
                    .remedy(format!("say which column holds the {role} with --columns {role}=NAME"))
                    .at(path, Some(1))
            })
        };
        let names = &format.columns;
        let columns =
            [column("time", &names.time)?, column("command", &names.command)?, column("position", &names.position)?];
        // A load is optional, unless the user named its column.
        let load_column = match &names.load {
            Some(name) => Some(column("load", name)?),
            None => find("load"),
        };
        Ok(Self {
            path: path.to_owned(),
            reader,
            row: csv::ByteRecord::new(),
            columns,
            load_column,
            names: names.clone(),
            scale: format.unit.scale(),
            count: 0,
            last_time: f64::NEG_INFINITY,
            first_command: 0.0,
            moved: false,
        })
    }

    /// Whether the file has a load.
    pub fn has_load(&self) -> bool {
        self.load_column.is_some()
    }

    /// The next row; none at the end of the file.
    ///
    /// # Errors
    /// A row of another length, a value that is no finite number, time that does not increase; at the end, too few rows
    /// or a command that never moved.
    pub fn next_sample(&mut self) -> Result<Option<Sample>> {
        let more = self.reader.read_byte_record(&mut self.row).map_err(|error| {
            let line = error.position().and_then(|position| usize::try_from(position.line()).ok());
            Error::new("row", error.to_string(), "as many values as the header has columns")
                .remedy("repair or remove the row")
                .at(&self.path, line)
        })?;
        if !more {
            self.check_end()?;
            return Ok(None);
        }
        let [time, command, position] = self.columns;
        let sample = Sample {
            time: self.number(time, &self.names.time)?,
            command: self.number(command, &self.names.command)? * self.scale,
            position: self.number(position, &self.names.position)? * self.scale,
            load: match self.load_column {
                Some(column) => Some(self.number(column, self.names.load.as_deref().unwrap_or("load"))? * self.scale),
                None => None,
            },
        };
        if sample.time <= self.last_time {
            return Err(Error::new(
                format!("column `{}`", self.names.time),
                format!("{} after {}", sample.time, self.last_time),
                "times that increase from row to row",
            )
            .remedy("sort the rows, remove repeated ones, or split the file where its clock was set back")
            .at(&self.path, self.line()));
        }
        if self.count == 0 {
            self.first_command = sample.command;
        }
        self.moved |= sample.command != self.first_command;
        self.last_time = sample.time;
        self.count += 1;
        Ok(Some(sample))
    }

    /// SHA-256 of the bytes read: of the whole file once the last row is out.
    pub fn sha256(&self) -> String {
        self.reader.get_ref().hash.clone().finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    fn line(&self) -> Option<usize> {
        self.row.position().and_then(|position| usize::try_from(position.line()).ok())
    }

    fn number(&self, column: usize, name: &str) -> Result<f64> {
        let text = std::str::from_utf8(self.row.get(column).unwrap_or_default()).unwrap_or("bytes that are no text");
        match f64::from_str(text.trim()) {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(Error::new(format!("column `{name}`"), format!("`{}`", text.trim()), "finite numbers")
                .remedy("repair or remove the row; sampling may be uneven")
                .at(&self.path, self.line())),
        }
    }

    fn check_end(&self) -> Result<()> {
        let refuse = |error: Error| Err(error.at(&self.path, Some(self.count + 1)));
        if self.count < FEWEST_SAMPLES {
            return refuse(
                Error::new("samples", self.count.to_string(), format!("{FEWEST_SAMPLES} or more"))
                    .remedy("record for longer or at a higher rate"),
            );
        }
        if !self.moved {
            return refuse(
                Error::new(
                    format!("column `{}`", self.names.command),
                    format!("{} in every row", self.first_command / self.scale),
                    "a command that moves",
                )
                .remedy("choose a record with excitation, or name the right column with --columns command=NAME"),
            );
        }
        Ok(())
    }
}

impl Unit {
    fn scale(self) -> f64 {
        match self {
            Self::Radian => 180.0 / std::f64::consts::PI,
            _ => 1.0,
        }
    }
}
