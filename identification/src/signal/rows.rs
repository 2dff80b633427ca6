//! The rows of a record file, checked one at a time: [`Record`](super::record::Record) collects them, [`Stream`](super::stream::Stream)
//! returns them in blocks.

use std::{
    io::{Cursor, Read},
    path::{Path, PathBuf},
    str::FromStr,
};

use super::{
    dialect::{BEGINNING_BYTES, Dialect, blank_within, is_blank},
    foreign,
    format::{Columns, Format, TimeUnit},
    header::Header,
    row_batches::RowBatches,
    source::Source,
    stated_units,
    time_stamp::{Clock, TimeStamp},
    utf16::{ByteOrder, Utf16},
};
use actuator_fmu::error::{Error, Result};

/// Minimum number of samples of a record: half a second at the report's 200 samples/s, below which nothing can be estimated.
pub const FEWEST_SAMPLES: usize = 100;

/// One row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// \[s\]
    pub time: f64,
    /// In the unit of the record.
    pub command: f64,
    /// In the unit of the record.
    pub position: f64,
    /// In the unit of the record, if the file has it.
    pub load: Option<f64>,
}

/// Reads a record row by row. Memory does not grow with the length of the file.
pub struct Rows {
    path: PathBuf,
    rows: RowBatches,
    size: Option<u64>,
    columns: [usize; 3],
    load_column: Option<usize>,
    names: Columns,
    per_second: f64,
    dialect: Dialect,
    is_utf16: bool,
    clock: Clock,
    count: usize,
    /// Rows without a value since the last one with values.
    blank: usize,
    last_time: f64,
    first_command: f64,
    moved: bool,
}

/// Buffer size [bytes].
const BUFFER_BYTES: usize = 1 << 16;

impl Rows {
    /// Finds the columns in the header of `text`; `path` is the name in errors.
    ///
    /// # Errors
    /// An unreadable file; a column that is not in its header.
    pub fn new(mut text: Box<dyn Source>, path: &Path, format: &Format) -> Result<Self> {
        let mut beginning = beginning_of(&mut text, path)?;
        foreign::refuse(&beginning, path)?;
        let utf16 = ByteOrder::of(&beginning);
        if let Some(order) = utf16 {
            text = Box::new(Utf16::new(beginning, text, order));
            beginning = beginning_of(&mut text, path)?;
        }
        let dialect = Dialect::taken_from(&mut beginning);
        let size = text.size();
        let mut reader = dialect
            .reader()
            .buffer_capacity(BUFFER_BYTES)
            .has_headers(dialect.has_header)
            .from_reader(Cursor::new(beginning).chain(text));
        let header = Header::read(&mut reader, &dialect, FEWEST_SAMPLES, path)?;
        let names = &format.columns;
        let columns =
            header.columns([("time", &names.time), ("command", &names.command), ("position", &names.position)])?;
        // A load is optional, unless the user named its column.
        let load_column = match &names.load {
            Some(name) => Some(header.columns([("load", name)])?[0]),
            None => header.position_of("load"),
        };
        if dialect.units.is_some() {
            let mut units = csv::ByteRecord::new();
            let _ = reader.read_byte_record(&mut units); // an error in it shows in the rows after it
            let line = dialect.line_of(&units, &reader);
            let words: Vec<_> = units.iter().map(String::from_utf8_lossy).collect();
            let roles = ["time", "command", "position", "load"].into_iter().zip(columns.into_iter().chain(load_column));
            let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
            stated_units::check(&words, &roles.collect::<Vec<_>>(), format, path, line)?;
        }
        Ok(Self {
            path: path.to_owned(),
            rows: RowBatches::start(reader, dialect.clone())?,
            size,
            columns,
            load_column,
            names: names.clone(),
            per_second: format.time_unit.map_or(1.0, TimeUnit::per_second),
            dialect,
            is_utf16: utf16.is_some(),
            clock: Clock::default(),
            count: 0,
            blank: 0,
            last_time: f64::NEG_INFINITY,
            first_command: 0.0,
            moved: false,
        })
    }

    /// Whether the file has a load.
    pub fn has_load(&self) -> bool {
        self.load_column.is_some()
    }

    /// The next row; `None` at the end of the file.
    ///
    /// # Errors
    /// A row with a different number of fields, a value that is not a finite number, time that does not increase; at the end, too few rows
    /// or a command that never moved.
    pub fn next_sample(&mut self) -> Result<Option<Sample>> {
        let mut first_blank = None;
        while self.next_row()? {
            let Some(row) = self.rows.row() else { break };
            if is_blank(row) {
                self.blank += 1;
                first_blank = first_blank.or_else(|| self.line());
                continue;
            }
            if self.blank > 0 {
                return Err(blank_within().at(&self.path, first_blank));
            }
            return self.sample().map(Some);
        }
        self.check_end()?;
        Ok(None)
    }

    /// Reads the next row; false at the end of the file.
    fn next_row(&mut self) -> Result<bool> {
        let row = self.rows.next_row().map_err(|(error, line)| {
            let (found, allowed) = match error.kind() {
                csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                    (format!("{len} values"), format!("{expected_len}, as many as the header has columns"))
                }
                _ => (error.to_string(), "CSV".to_owned()),
            };
            Error::new("row", found, allowed).remedy("repair or remove the row").at(&self.path, line)
        })?;
        Ok(row.is_some())
    }

    /// Values of the latest row.
    fn sample(&mut self) -> Result<Sample> {
        let [time, command, position] = self.columns;
        let sample = Sample {
            time: self.time(time)?,
            command: self.number(command, &self.names.command)?,
            position: self.number(position, &self.names.position)?,
            load: match self.load_column {
                Some(column) => Some(self.number(column, self.names.load.as_deref().unwrap_or("load"))?),
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
        Ok(sample)
    }

    /// SHA-256 of the file as given, after the last row.
    pub fn sha256(&self) -> &str {
        self.rows.sha256()
    }

    /// Expected total number of rows, from the size of the file and of the rows so far: mostly somewhat too large, 0 if unknown.
    pub fn expected(&self) -> usize {
        let begin = self.rows.row().and_then(csv::ByteRecord::position).map_or(0, csv::Position::byte);
        let (Some(size), true) = (self.size, begin > 0) else { return 0 };
        (1.02 * self.count as f64 * size as f64 / begin as f64) as usize
    }

    fn line(&self) -> Option<usize> {
        self.rows.line()
    }

    fn field(&self, column: usize) -> &[u8] {
        self.rows.row().and_then(|row| row.get(column)).unwrap_or_default()
    }

    /// Deviations of the file from plain CSV, in words.
    pub fn understood(&self) -> Vec<String> {
        let mut words = self.dialect.words();
        words.extend(self.is_utf16.then(|| "text in UTF-16".to_owned()));
        words.extend((self.blank > 0).then(|| format!("{} rows without values at its end, left out", self.blank)));
        words.extend(self.clock.has_started().then(|| "times of day or dates, taken from the first".to_owned()));
        words
    }

    /// A number in its unit, or a time stamp since the first one [s].
    fn time(&mut self, column: usize) -> Result<f64> {
        let text = std::str::from_utf8(self.field(column)).unwrap_or_default();
        let stamp = if text.contains(':') { TimeStamp::parse(text) } else { None };
        if let Some(stamp) = stamp {
            return self.clock.since_first(stamp).ok_or_else(|| {
                let text = String::from_utf8_lossy(self.field(column));
                Error::new(
                    format!("column `{}`", self.names.time),
                    format!("`{}`, another date than the first", text.trim()),
                    "dates that tell the day from the month",
                )
                .remedy("write dates as 2026-11-24, or split the file at midnight")
                .at(&self.path, self.line())
            });
        }
        Ok(self.number(column, &self.names.time)? / self.per_second)
    }

    fn number(&self, column: usize, name: &str) -> Result<f64> {
        let text = std::str::from_utf8(self.field(column)).unwrap_or("bytes that are no text");
        let parsed = if self.dialect.decimal_comma {
            f64::from_str(&text.trim().replacen(',', ".", 1))
        } else {
            f64::from_str(text.trim())
        };
        match parsed {
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
                    format!("{} in every row", self.first_command),
                    "a command that moves",
                )
                .remedy("choose a record with excitation, or name the right column with --columns command=NAME"),
            );
        }
        Ok(())
    }
}

/// The first bytes of a text, used for detecting its dialect.
fn beginning_of(text: &mut Box<dyn Source>, path: &Path) -> Result<Vec<u8>> {
    let mut beginning = Vec::new();
    text.take(BEGINNING_BYTES).read_to_end(&mut beginning).map_err(|error| {
        Error::new("record", error.to_string(), "a readable CSV file").remedy("check the file").at(path, None)
    })?;
    Ok(beginning)
}
