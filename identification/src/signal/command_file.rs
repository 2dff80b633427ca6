//! A command from a file, in the dialects in which records are written.

use std::{
    io::{Cursor, Read},
    path::Path,
};

use super::{
    Command,
    dialect::{BEGINNING_BYTES, Dialect},
    format::{Format, TimeUnit},
    stated_units, utf16,
};
use actuator_fmu::error::{Error, Result};

impl Command {
    /// Reads time and command of CSV, in the dialects of records; other columns are passed over. `source` is what errors name.
    ///
    /// # Errors
    /// An unreadable file, a missing column, a unit in a row of units that is not the one of the format, a value that is no finite number,
    /// time that does not increase, fewer than two rows; each with its line.
    pub fn from_csv(text: impl Read, source: &Path, format: &Format) -> Result<Self> {
        let at = |line, error: Error| error.at(source, line);
        let unreadable = |error: std::io::Error| at(None, Error::new("file", error.to_string(), "CSV"));
        let mut text = utf16::as_utf8(text).map_err(unreadable)?;
        let mut beginning = Vec::new();
        text.by_ref().take(BEGINNING_BYTES).read_to_end(&mut beginning).map_err(unreadable)?;
        let dialect = Dialect::taken_from(&mut beginning);
        let mut reader = dialect.reader().trim(csv::Trim::All).from_reader(Cursor::new(beginning).chain(text));
        let headers =
            reader.headers().map_err(|error| at(Some(1), Error::new("header", error.to_string(), "CSV")))?.clone();
        let column = |name: &str| {
            headers.iter().position(|header| header == name).ok_or_else(|| {
                let found: Vec<&str> = headers.iter().collect();
                at(
                    Some(1),
                    Error::new(
                        format!("column `{name}`"),
                        format!("only {}", found.join(", ")),
                        "a header with `time` and `command`",
                    )
                    .remedy("say which columns hold them with --columns time=NAME,command=NAME"),
                )
            })
        };
        let names = &format.columns;
        let (time_column, command_column) = (column(&names.time)?, column(&names.command)?);
        let per_second = format.time_unit.map_or(1.0, TimeUnit::per_second);
        let mut signal = Self::default();
        for (index, row) in reader.records().enumerate() {
            let row = row.map_err(|error| {
                let line = error.position().and_then(|position| usize::try_from(position.line()).ok());
                at(line, Error::new("row", error.to_string(), "as many values as the header has columns"))
            })?;
            let line = row.position().and_then(|position| usize::try_from(position.line()).ok());
            if index == 0 && dialect.units.is_some() {
                let columns = [("time", time_column), ("command", command_column)];
                stated_units::check(&row.iter().collect::<Vec<&str>>(), &columns, format, source, line)?;
                continue;
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
        if signal.time.len() < 2 {
            return Err(at(None, Error::new("rows", signal.time.len().to_string(), "2 or more")));
        }
        Ok(signal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A separator that is declared, decimal commas, other names, milliseconds, units.
    #[test]
    fn a_command_is_read_as_a_record_is() {
        let read = |text: &str, format: &Format| Command::from_csv(text.as_bytes(), Path::new("command.csv"), format);
        let expected = Command { time: vec![0.0, 0.005], command: vec![0.5, -1.25] };
        let excel = "\u{feff}sep=;\r\n# bench 3\r\ntime;command\r\ns;deg\r\n0,000;0,5\r\n0,005;-1,25\r\n";
        assert_eq!(read(excel, &Format::default()).unwrap(), expected);
        let columns = "time=t_ms,command=cmd".parse().unwrap();
        let logger = Format { columns, time_unit: Some(TimeUnit::Millisecond), ..Format::default() };
        assert_eq!(read("t_ms,x,cmd\nms,V,deg\n0,9,0.5\n5,9,-1.25\n", &logger).unwrap(), expected);
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
            ("time,command\n0,1\n-0.1,2\n", "command.csv:3: column `time`"),
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
