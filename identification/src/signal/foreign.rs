//! Files that are not text, detected from their first bytes, with the name of their format for the error message.

use std::path::Path;

use actuator_fmu::error::{Error, Result};

/// First bytes of other file formats (from their specifications), and their names.
const BEGINNINGS: [(&[u8], &str); 8] = [
    (b"PK\x03\x04", "an archive, as workbooks (.xlsx, .ods) and FMUs are"),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "a workbook of Excel (.xls)"),
    (b"MATLAB 5.0 MAT-file", "a MAT-file"),
    (b"\x89HDF\r\n\x1a\n", "an HDF5 file, as MAT-files of version 7.3 are"),
    (b"PAR1", "a Parquet file"),
    (b"\x93NUMPY", "an array of NumPy"),
    (b"TDSm", "a TDMS file"),
    (b"MDF     ", "an MDF file"),
];

/// Format of a file with these first bytes; `None` if it may be text.
#[must_use]
pub fn kind_of(beginning: &[u8]) -> Option<&'static str> {
    BEGINNINGS.iter().find(|(first, _)| beginning.starts_with(first)).map(|(_, kind)| *kind)
}

/// Refuses a file in one of these formats.
///
/// # Errors
/// The name of the format, and what to do.
pub fn refuse(beginning: &[u8], path: &Path) -> Result<()> {
    match kind_of(beginning) {
        Some(kind) => Err(Error::new("file", kind, "text with one row for each sample")
            .remedy("save the table as CSV in the program that wrote it")
            .at(path, None)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_workbook_is_called_one_and_text_is_taken() {
        let message = refuse(b"PK\x03\x04\x14\0\x06\0", Path::new("run7.xlsx")).unwrap_err().to_string();
        assert!(message.starts_with("run7.xlsx: file") && message.contains("as CSV"), "{message}");
        for text in ["time,command,position\n", "PKT;1\n", "MDF,1\n", ""] {
            assert!(refuse(text.as_bytes(), Path::new("run7.csv")).is_ok(), "{text}");
        }
    }
}
