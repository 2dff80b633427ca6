//! Dialect of a text file of numbers: column separator, decimals and comments, and rows without numbers.

use actuator_fmu::error::Error;

/// Dialect of a file, detected from its beginning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dialect {
    /// Column separator.
    pub delimiter: u8,
    /// Whether `1,5` is one and a half.
    pub decimal_comma: bool,
    /// First character of comment lines.
    pub comment: Option<u8>,
    /// Whether the first row names the columns.
    pub has_header: bool,
    /// The row after the header, if it contains units.
    pub units: Option<String>,
    /// Whether the assumed header is other text above it.
    pub text_above: bool,
    /// Whether rows end in CR LF, as under Windows; lines above them may differ.
    pub carriage_returns: bool,
}

/// Characters that begin comment lines.
pub const COMMENTS: [u8; 2] = [b'#', b'%'];

/// Number of bytes used for detection.
pub const BEGINNING_BYTES: u64 = 1 << 16;

/// The byte-order mark that Excel writes before UTF-8.
pub const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// A first line `sep=;`, which declares the column separator to Excel: the separator, and the bytes of the line without its end.
#[must_use]
pub fn declared_separator(beginning: &[u8]) -> Option<(u8, usize)> {
    let length = beginning.iter().position(|byte| b"\r\n".contains(byte))?;
    let line = beginning[..length].strip_prefix(b"\"").unwrap_or(&beginning[..length]);
    match line.strip_suffix(b"\"").unwrap_or(line) {
        [key @ .., mark] if key.eq_ignore_ascii_case(b"sep=") && mark.is_ascii() && !mark.is_ascii_alphanumeric() => {
            Some((*mark, length))
        }
        _ => None,
    }
}

impl Dialect {
    /// From the first bytes of a file, whose last line may be truncated.
    #[must_use]
    pub fn detect(beginning: &[u8]) -> Self {
        let text = String::from_utf8_lossy(beginning);
        let declared = declared_separator(beginning).map(|(mark, _)| mark);
        let mut lines: Vec<&str> =
            text.lines().skip(usize::from(declared.is_some())).filter(|line| !line.trim().is_empty()).collect();
        if beginning.len() as u64 >= BEGINNING_BYTES {
            lines.pop();
        }
        let is_comment = |line: &&str| COMMENTS.iter().any(|mark| line.trim_start().as_bytes().first() == Some(mark));
        let comment = lines.iter().find(|line| is_comment(line)).and_then(|line| line.trim_start().bytes().next());
        let rows: Vec<&str> = lines.into_iter().filter(|line| !is_comment(line)).collect();
        let first = rows.first().copied().unwrap_or_default();
        let delimiter = declared.unwrap_or_else(|| delimiter_of(first));
        let fields = |row| fields(row, delimiter);
        let last = fields(rows.last().copied().unwrap_or_default());
        let decimal_comma = delimiter != b','
            && last.iter().any(|field| is_number(&field.replacen(',', ".", 1)) && field.contains(','));
        let numeric = |field: &String| {
            let field = if decimal_comma { field.replacen(',', ".", 1) } else { field.clone() };
            is_number(&field) || super::time_stamp::TimeStamp::parse(&field).is_some()
        };
        let has_header = !fields(first).iter().all(|field| field.is_empty() || numeric(field)) || rows.is_empty();
        let second = rows.get(1).copied().filter(|_| has_header);
        // A bad number is not a unit: if one field of the row is a number, all must be.
        let width = fields(first).len();
        let units = second.filter(|row| {
            let fields = fields(row);
            fields.len() == width && !fields.iter().any(|field| numeric(field) || is_missing(field))
        });
        Self {
            delimiter,
            decimal_comma,
            comment,
            has_header,
            units: units.map(|row| fields(row).join(", ")),
            text_above: is_below_text(&rows, declared),
            carriage_returns: beginning
                .iter()
                .rposition(|byte| *byte == b'\n')
                .is_some_and(|end| beginning[..end].ends_with(b"\r")),
        }
    }

    /// From the first bytes of a file, after removal of a byte-order mark and of the content of a declaring first line; its end remains,
    /// and counts as a line.
    #[must_use]
    pub fn taken_from(beginning: &mut Vec<u8>) -> Self {
        if beginning.starts_with(BYTE_ORDER_MARK) {
            beginning.drain(..BYTE_ORDER_MARK.len());
        }
        let dialect = Self::detect(beginning);
        if let Some((_, length)) = declared_separator(beginning) {
            beginning.drain(..length);
        }
        dialect
    }

    /// A reader of such text, which uses the first row as header.
    #[must_use]
    pub fn reader(&self) -> csv::ReaderBuilder {
        let mut reader = csv::ReaderBuilder::new();
        reader.delimiter(self.delimiter).comment(Some(self.comment.unwrap_or(COMMENTS[0])));
        reader
    }

    /// The line [from 1] of the row that `reader` has just read, or of an invalid row. The reader's own position is the end of the previous
    /// row: before comments and empty lines, and before the second half of a line end.
    #[must_use]
    pub fn line_of<R: std::io::Read>(&self, row: &csv::ByteRecord, reader: &csv::Reader<R>) -> Option<usize> {
        let end = reader.position().line();
        let line = if self.carriage_returns { end } else { row.position()?.line().max(end - 1) };
        usize::try_from(line).ok()
    }

    /// Deviations from plain CSV, in words.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        match self.delimiter {
            b';' => words.push("columns separated by semicolons".to_owned()),
            b'\t' => words.push("columns separated by tabs".to_owned()),
            b',' => {}
            mark => words.push(format!("columns separated by `{}`", char::from(mark))),
        }
        if self.decimal_comma {
            words.push("decimal commas".to_owned());
        }
        if let Some(mark) = self.comment {
            words.push(format!("comment lines behind `{}`", char::from(mark)));
        }
        if !self.has_header {
            words.push("no header: columns by number".to_owned());
        }
        if let Some(units) = &self.units {
            words.push(format!("a row of units: {units}"));
        }
        words
    }
}

fn delimiter_of(row: &str) -> u8 {
    [b'\t', b';'].into_iter().find(|mark| row.as_bytes().contains(mark)).unwrap_or(b',')
}

fn fields(row: &str, delimiter: u8) -> Vec<String> {
    row.split(char::from(delimiter)).map(|field| field.trim().trim_matches('"').to_owned()).collect()
}

/// Whether the header is below other text: the first row of numbers, as wide as the last row, follows a row of as many words, or such a row
/// and its units, and that is not the first row.
fn is_below_text(rows: &[&str], declared: Option<u8>) -> bool {
    let Some(last) = rows.last() else { return false };
    let delimiter = declared.unwrap_or_else(|| delimiter_of(last));
    let is_numeric = |field: &String| is_number(&field.replacen(',', ".", 1));
    let rows = || rows.iter().map(|row| fields(row, delimiter));
    let width = fields(last, delimiter).len();
    let Some(numbers) = rows().position(|row| row.len() == width && row.iter().any(is_numeric)) else { return false };
    // Rows of words, upwards.
    let is_of_words = |row: &Vec<String>| row.len() == width && !row.iter().any(is_numeric);
    let words = rows().take(numbers).collect::<Vec<_>>().iter().rev().take_while(|row| is_of_words(row)).count();
    words > 0 && (numbers > words || words > 2)
}

fn is_number(field: &str) -> bool {
    field.parse::<f64>().is_ok()
}

/// Whether a reader's error about a row is a different number of fields.
#[must_use]
pub fn is_of_other_length(error: &csv::Error) -> bool {
    matches!(error.kind(), csv::ErrorKind::UnequalLengths { .. })
}

/// Whether a row was read with the same number of fields, or without any value.
#[must_use]
pub fn holds_row(read: &csv::Result<bool>, row: &csv::ByteRecord) -> bool {
    match read {
        Ok(is_row) => *is_row,
        Err(error) => is_of_other_length(error) && is_blank(row),
    }
}

/// Whether a row contains only separators or blanks: spreadsheets and editors write such rows at the end of files.
#[must_use]
pub fn is_blank(row: &csv::ByteRecord) -> bool {
    row.as_slice().iter().all(u8::is_ascii_whitespace)
}

/// Error for such a row followed by others.
#[must_use]
pub fn blank_within() -> Error {
    Error::new("row", "no values", "rows without values at the end of a file only")
        .remedy("remove the row, or split the file there; sampling may be uneven")
}

/// Empty, or a usual text for a missing number.
fn is_missing(field: &str) -> bool {
    ["", "nan", "na", "n/a", "null", "none", "inf", "-inf"].contains(&field.to_lowercase().as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Dialect {
        Dialect::detect(text.as_bytes())
    }

    #[test]
    fn dialects_are_told_apart() {
        let plain = of("time,command,position\n0,1,2\n0.1,1,2\n");
        assert_eq!(
            plain,
            Dialect {
                delimiter: b',',
                decimal_comma: false,
                comment: None,
                has_header: true,
                units: None,
                text_above: false,
                carriage_returns: false
            }
        );
        assert!(plain.words().is_empty());
        let german = of("# Messung 7\nZeit;Soll;Ist\ns;Grad;Grad\n0,00;1,5;1,4\n0,01;1,5;1,4\n");
        assert_eq!((german.delimiter, german.decimal_comma, german.comment), (b';', true, Some(b'#')));
        assert_eq!(german.units.as_deref(), Some("s, Grad, Grad"));
        let bare = of("0\t1\t2\n0.1\t1\t2\n");
        assert_eq!((bare.delimiter, bare.has_header), (b'\t', false));
        assert!(of("2026-01-02T03:04:05Z,1,2\n").words()[0].contains("no header"));
        assert_eq!(of("time,command,position\nNaN,1,2\n").units, None);
        assert_eq!(of("time;command;position\n0,1,2\n").units, None);
    }

    #[test]
    fn a_first_line_may_tell_the_separator() {
        for line in ["sep=;", "SEP=;\r", "\"sep=;\""] {
            let told = of(&format!("{line}\nZeit;Soll;Ist\n0,00;1,5;1,4\n0,01;1,5;1,4\n"));
            assert_eq!((told.delimiter, told.decimal_comma, told.text_above), (b';', true, false), "{line}");
        }
        let bars = of("sep=|\ntime|command|position\n0|1|2\n");
        assert_eq!(bars.words(), ["columns separated by `|`"]);
        assert_eq!(declared_separator(b"sep=8\n0,1,2\n"), None);
    }

    #[test]
    fn text_above_the_header_is_seen_and_no_header_or_units_are_taken_for_it() {
        let header = "Zeit;Soll;Ist\n";
        for (above, units, expected) in [
            ("", "", false),
            ("", "s;Grad;Grad\n", false),
            ("Messung 7, vom Montag\n", "", true),
            ("Messung 7\nRate: 200\n", "s;Grad;Grad\n", true),
            ("Messung 7;;\n", "s;Grad;Grad\n", true),
        ] {
            let told = of(&format!("{above}{header}{units}0,00;1,5;1,4\n0,01;1,5;1,4\n"));
            assert_eq!(told.text_above, expected, "{above}{units}");
        }
        assert!(!of("time,command,angle\n0,x,1\n0.1,1,1\n").text_above);
        assert!(!of("time;command;position\n0,1,2\n").text_above);
    }
}
