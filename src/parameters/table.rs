//! Tables 1 and 2 of NASA/TM-1998-208452.

use std::{fmt, str::FromStr, sync::OnceLock};

use serde::Deserialize;

use super::{
    base::Base,
    selection::{LoadCase, Stage, Surface},
};
use crate::error::{Error, Result};

/// Which set: surface, stage and load case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SetName {
    /// Control surface.
    pub surface: Surface,
    /// Stage of the test.
    pub stage: Stage,
    /// Load case.
    pub load_case: LoadCase,
}

impl fmt::Display for SetName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}-{}", self.surface.short(), self.stage.short(), self.load_case.short())
    }
}

impl FromStr for SetName {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        table().iter().find(|set| set.name.to_string() == text).map(|set| set.name).ok_or_else(|| {
            let names: Vec<String> = table().iter().map(|set| set.name.to_string()).collect();
            let error = Error::new("set name", format!("`{text}`"), names.join(", "));
            if text == no_data_name().to_string() { error.remedy(NO_DATA) } else { error }
        })
    }
}

/// Reason for refusing the eighteenth combination.
pub const NO_DATA: &str = "the report has no data for the lower spoiler late in the test under load (N/A in table 2)";

fn no_data_name() -> SetName {
    SetName { surface: Surface::LowerSpoiler, stage: Stage::Late, load_case: LoadCase::Loaded }
}

/// One row of table 1 or 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterSet {
    /// Which actuator.
    pub name: SetName,
    /// Table of the report.
    pub table: u8,
    /// Row in that table, from its top.
    pub row: u8,
    /// Its parameters.
    pub base: Base,
}

impl ParameterSet {
    /// Table and row of the report.
    #[must_use]
    pub fn source(&self) -> String {
        format!("{SOURCE}, table {}, row {}", self.table, self.row)
    }
}

/// Band of the report's data \[Hz\].
pub const BAND_HZ: [f64; 2] = [0.5, 12.0];

/// The report.
pub const SOURCE: &str = "NASA/TM-1998-208452";

/// The 17 sets, table 1 before table 2, each from top to bottom: `table()[n - 1]` is set number n.
#[must_use]
pub fn table() -> &'static [ParameterSet] {
    static TABLE: OnceLock<Vec<ParameterSet>> = OnceLock::new();
    // The text is part of the program and a test reads every row, so that the fallback to an empty table does not occur.
    TABLE.get_or_init(|| parse_table(include_str!("tables.toml")).unwrap_or_default())
}

fn parse_table(text: &str) -> Result<Vec<ParameterSet>> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Tables {
        source: String,
        units: std::collections::BTreeMap<String, String>,
        set: Vec<Row>,
    }
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Row {
        surface: Surface,
        stage: Stage,
        load_case: LoadCase,
        table: u8,
        row: u8,
        k: f64,
        p: f64,
        omega: f64,
        zeta: f64,
    }
    let tables: Tables =
        toml::from_str(text).map_err(|error| Error::new("parameter tables", error.to_string(), "17 complete rows"))?;
    if tables.source != SOURCE {
        return Err(Error::new("source of the parameter tables", tables.source, SOURCE));
    }
    for parameter in Base::PARAMETERS {
        if tables.units.get(parameter.name).map(String::as_str) != Some(parameter.unit) {
            return Err(Error::new(
                format!("unit of {}", parameter.name),
                format!("{:?}", tables.units),
                parameter.unit,
            ));
        }
    }
    tables
        .set
        .into_iter()
        .map(|row| {
            Ok(ParameterSet {
                name: SetName { surface: row.surface, stage: row.stage, load_case: row.load_case },
                table: row.table,
                row: row.row,
                base: Base::new(row.k, row.p, row.omega, row.zeta)?,
            })
        })
        .collect()
}

/// The set of a surface at a stage under a load case.
///
/// # Errors
/// The one combination for which the report has no data.
pub fn find(name: SetName) -> Result<&'static ParameterSet> {
    table().iter().find(|set| set.name == name).ok_or_else(|| {
        Error::new(
            "combination of surface, stage and load_case",
            format!("{}, {}, {}", name.surface.name(), name.stage.name(), name.load_case.name()),
            "the 17 combinations of tables 1 and 2",
        )
        .remedy(NO_DATA)
    })
}

/// The set with a number, 1-9 for the rows of table 1, 10-17 for those of table 2.
///
/// # Errors
/// A number outside 1-17.
pub fn by_number(number: usize) -> Result<&'static ParameterSet> {
    number
        .checked_sub(1)
        .and_then(|index| table().get(index))
        .ok_or_else(|| Error::new("set number", number.to_string(), "1 to 17"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_hold_seventeen_different_sets_in_the_order_of_the_report() {
        let sets = parse_table(include_str!("tables.toml")).unwrap();
        assert_eq!(sets.len(), 17);
        for (index, set) in sets.iter().enumerate() {
            assert_eq!((usize::from(set.table) - 1) * 9 + usize::from(set.row) - 1, index);
            assert_eq!(sets.iter().filter(|other| other.name == set.name).count(), 1);
            assert_eq!(set.name.to_string().parse::<SetName>().unwrap(), set.name);
        }
    }

    #[test]
    fn the_combination_without_data_is_refused_with_the_reason() {
        let message = find(no_data_name()).unwrap_err().to_string();
        for part in ["lower_spoiler", "late", "loaded", "no data"] {
            assert!(message.contains(part), "{message}");
        }
        assert!("ls-late-loaded".parse::<SetName>().unwrap_err().to_string().contains("no data"));
    }
}
