//! A command from a file, in the dialects of record files.

use std::{
    io::{Cursor, Read},
    mem,
    path::Path,
};

use super::{
    Command,
    dialect::{BEGINNING_BYTES, Dialect, blank_within, holds_row, is_blank},
    foreign,
    format::{Format, TimeUnit},
    header::Header,
    stated_units, utf16,
};
use actuator_fmu::error::{Error, Result};

/// A command has at least two values.
const FEWEST_ROWS: usize = 2;

impl Command {
    /// Reads time and command from CSV, in the dialects of records, with columns by name or number; other columns are ignored, and times of
    /// day are not supported. `source` is the name in errors.
    ///
    /// # Errors
    /// An unreadable file, a missing column, a unit in a row of units that is not that of the format, a value that is not a finite number,
    /// time that does not increase, fewer than two rows; each with its line.
    pub fn from_csv(text: impl Read, source: &Path, format: &Format) -> Result<Self> {
        let at = |line, error: Error| error.at(source, line);
        let unreadable = |error: std::io::Error| at(None, Error::new("file", error.to_string(), "CSV"));
        let mut text = utf16::as_utf8(text).map_err(unreadable)?;
        let mut beginning = Vec::new();
        text.by_ref().take(BEGINNING_BYTES).read_to_end(&mut beginning).map_err(unreadable)?;
        foreign::refuse(&beginning, source)?;
        let dialect = Dialect::taken_from(&mut beginning);
        let mut reader = dialect
            .reader()
            .has_headers(dialect.has_header)
            .trim(csv::Trim::All)
            .from_reader(Cursor::new(beginning).chain(text));
        let names = &format.columns;
        let [time_column, command_column] = Header::read(&mut reader, &dialect, FEWEST_ROWS, source)?
            .columns([("time", &names.time), ("command", &names.command)])?;
        let per_second = format.time_unit.map_or(1.0, TimeUnit::per_second);
        let mut signal = Self::default();
        let mut blank = None;
        let mut row = csv::StringRecord::new();
        let mut units = dialect.units.is_some();
        loop {
            let read = reader.read_record(&mut row);
            let line = dialect.line_of(row.as_byte_record(), &reader);
            let allowed = "as many values as the header has columns";
            if !holds_row(&read, row.as_byte_record()) {
                read.map_err(|error| at(line, Error::new("row", error.to_string(), allowed)))?;
                break;
            }
            if mem::take(&mut units) {
                let columns = [("time", time_column), ("command", command_column)];
                stated_units::check(&row.iter().collect::<Vec<&str>>(), &columns, format, source, line)?;
                continue;
            }
            if is_blank(row.as_byte_record()) {
                blank = blank.or(line);
                continue;
            }
            if blank.is_some() {
                return Err(at(blank, blank_within()));
            }
            let number = |column: usize, name: &str| {
                let text = row.get(column).unwrap_or_default();
                let read = if dialect.decimal_comma { text.replacen(',', ".", 1) } else { text.to_owned() };
                read.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
                    at(
                        line,
                        Error::new(format!("column `{name}`"), format!("`{text}`"), "finite numbers")
                            .remedy("remove or repair the row"),
                    )
                })
            };
            let time = number(time_column, &names.time)? / per_second;
            if let Some(before) = signal.time.last().filter(|before| **before >= time) {
                return Err(at(
                    line,
                    Error::new(
                        format!("column `{}`", names.time),
                        format!("{time} after {before}"),
                        "increasing times",
                    )
                    .remedy("sort the rows and remove repeated ones"),
                ));
            }
            signal.time.push(time);
            signal.command.push(number(command_column, &names.command)?);
        }
        if signal.time.len() < FEWEST_ROWS {
            let count = signal.time.len().to_string();
            return Err(at(None, Error::new("rows", count, format!("{FEWEST_ROWS} or more"))));
        }
        Ok(signal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A declared separator, decimal commas, other names, milliseconds, units.
    #[test]
    fn a_command_is_read_as_a_record_is() {
        let read = |text: &str, format: &Format| Command::from_csv(text.as_bytes(), Path::new("command.csv"), format);
        let expected = Command { time: vec![0.0, 0.005], command: vec![0.5, -1.25] };
        assert_eq!(read("time,command\n0,0.5\n0.005,-1.25\n,\n,\n  \n", &Format::default()).unwrap(), expected);
        let excel = "\u{feff}sep=;\r\n# bench 3\r\ntime;command\r\ns;deg\r\n0,000;0,5\r\n0,005;-1,25\r\n";
        assert_eq!(read(excel, &Format::default()).unwrap(), expected);
        let columns = "time=t_ms,command=cmd".parse().unwrap();
        let logger = Format { columns, time_unit: Some(TimeUnit::Millisecond), ..Format::default() };
        assert_eq!(read("t_ms,x,cmd\nms,V,deg\n0,9,0.5\n5,9,-1.25\n", &logger).unwrap(), expected);
        let by_number = Format { columns: "time=1,command=3".parse().unwrap(), ..Format::default() };
        assert_eq!(read("0,9,0.5\n0.005,9,-1.25\n", &by_number).unwrap(), expected);
        assert_eq!(read("Time,Command\n0,0.5\n0.005,-1.25\n", &Format::default()).unwrap(), expected);
        let refused = read("time,command\ns,mm\n0,0.5\n1,1\n", &Format::default()).unwrap_err().to_string();
        assert!(refused.contains("command.csv:2") && refused.contains("--unit mm"), "{refused}");
        let unnamed = read("t_ms,cmd\n0,1\n5,2\n", &Format::default()).unwrap_err().to_string();
        assert!(unnamed.contains("--columns"), "{unnamed}");
    }

    #[test]
    fn bad_rows_are_refused_with_file_and_line() {
        for (text, expected) in [
            ("time,position\n0,1\n", "command.csv:1: column `command`"),
            ("time,command\n0,1\n0.1,NaN\n", "command.csv:3: column `command`"),
            ("time,command\n0,1\n0.1,\n", "command.csv:3: column `command`"),
            ("time,command\n0,1\n,\n,\n0.2,1\n", "command.csv:3: row"),
            ("time,command\n0,1\n \t\n0.2,1\n", "command.csv:3: row: found no values"),
            ("t,x\n0,1\n0.1,1\n", "command.csv:1: columns `time`, `command`"),
            ("PK\u{3}\u{4}\u{14}", "command.csv: file"),
            ("time,command\n0,1\n-0.1,2\n", "command.csv:3: column `time`"),
            ("time,command\r\n0,1\r\n-0.1,2\r\n", "command.csv:3: column `time`"),
            ("# a\ntime,command\r\n0,1\r\n-0.1,2\r\n", "command.csv:4: column `time`"),
            ("time,command\n0,1\n# a\n\n-0.1,2\n", "command.csv:5: column `time`"),
            ("time,command\n0,1\n-0.1,2", "command.csv:3: column `time`"),
            ("time,command\n0,1\n", "command.csv: rows"),
            ("time,command\n0,1\n0.1\n", "command.csv:3: row"),
        ] {
            let message = Command::from_csv(text.as_bytes(), Path::new("command.csv"), &Format::default())
                .unwrap_err()
                .to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
