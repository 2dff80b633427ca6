//! The column names of a file, and the indices of the requested ones.

use std::{io::Read, path::Path};

use super::dialect::Dialect;
use actuator_fmu::error::{Error, Result};

/// The first row of a file: the names of its columns.
pub struct Header<'a> {
    names: Vec<String>,
    text_above: bool,
    fewest_rows: usize,
    path: &'a Path,
}

impl<'a> Header<'a> {
    /// Without a header, columns are named by their numbers, from 1. `fewest_rows` is used in the error for an empty file.
    ///
    /// # Errors
    /// A first row that cannot be read.
    pub fn read<R: Read>(
        reader: &mut csv::Reader<R>,
        dialect: &Dialect,
        fewest_rows: usize,
        path: &'a Path,
    ) -> Result<Self> {
        let names = reader.byte_headers().map_err(|error| {
            Error::new("header", error.to_string(), "CSV with a header row").remedy("check the file").at(path, Some(1))
        })?;
        let text_above = dialect.text_above;
        if !dialect.has_header {
            let numbers = (1..=names.len()).map(|number| number.to_string()).collect();
            return Ok(Self { names: numbers, text_above, fewest_rows, path });
        }
        // Only the requested names must be text.
        let names = names.iter().map(|name| String::from_utf8_lossy(name).trim().to_owned()).collect();
        Ok(Self { names, text_above, fewest_rows, path })
    }

    /// The first index of a name, if any, ignoring case.
    pub fn position_of(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|header| header.eq_ignore_ascii_case(name))
    }

    /// Their indices, by role and name. Missing ones are reported together.
    ///
    /// # Errors
    /// Names without a column, or with several.
    pub fn columns<const N: usize>(&self, wanted: [(&str, &str); N]) -> Result<[usize; N]> {
        let mut places = [0; N];
        let mut missing = Vec::new();
        for (place, (role, name)) in places.iter_mut().zip(wanted) {
            match self.place(name)? {
                Some(found) => *place = found,
                None => missing.push((role, name)),
            }
        }
        if missing.is_empty() { Ok(places) } else { Err(self.missing(&missing)) }
    }

    /// The unique index of a name; without an exact match, case and spaces are ignored, and a number is an index.
    fn place(&self, name: &str) -> Result<Option<usize>> {
        let folded = |name: &str| name.to_lowercase().split_whitespace().collect::<Vec<&str>>().join(" ");
        let exact = self.names.iter().any(|column| column == name);
        let is_meant = |place: &usize| {
            if exact { self.names[*place] == name } else { folded(&self.names[*place]) == folded(name) }
        };
        if let Some(place) = name.parse::<usize>().ok().filter(|place| !exact && (1..=self.names.len()).contains(place))
        {
            return Ok(Some(place - 1));
        }
        let mut places = (0..self.names.len()).filter(is_meant);
        match (places.next(), places.next()) {
            (place, None) => Ok(place),
            (_, Some(_)) => Err(Error::new(format!("column `{name}`"), "several of that name", "one")
                .remedy("rename or remove the others")
                .at(self.path, Some(1))),
        }
    }

    /// Error for a header without these columns, with a remedy.
    fn missing(&self, columns: &[(&str, &str)]) -> Error {
        let found = match self.names.as_slice() {
            [] => "an empty file".to_owned(),
            names => format!("only {}", names.join(", ")),
        };
        let remedy = match self.names.as_slice() {
            [] => format!("give a CSV file with a header row and {} rows or more", self.fewest_rows),
            // UTF-16 of other letters, UTF-32
            names if names.iter().any(|name| name.contains('\0')) => "save the file as UTF-8 text".to_owned(),
            names if names.iter().any(|name| name.contains('\u{fffd}')) => {
                "save the file as UTF-8 text, or name columns by their numbers: --columns time=1,command=2,position=3"
                    .to_owned()
            }
            _ if self.text_above => "remove the lines above the header, or begin each with `#`".to_owned(),
            [one] if one.contains([';', '\t']) => {
                "separate columns by commas, and write decimals with points".to_owned()
            }
            _ => {
                let roles = columns.iter().map(|(role, _)| format!("{role}=NAME")).collect::<Vec<_>>().join(",");
                match columns {
                    [(role, _)] => {
                        format!("say which column holds the {role} with --columns {roles}, or by its number")
                    }
                    _ => format!("say which columns hold them with --columns {roles}, or by their numbers"),
                }
            }
        };
        let names = columns.iter().map(|(_, name)| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let (what, allowed) = match columns {
            [_] => ("column", "a header that names it"),
            _ => ("columns", "a header that names them"),
        };
        Error::new(format!("{what} {names}"), found, allowed).remedy(remedy).at(self.path, Some(1))
    }
}
