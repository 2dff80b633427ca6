//! The identified actuators: tables 1 and 2 of NASA/TM-1998-208452 as data, and models in files.
//!
//! The report gives 17 sets of (k, p, ω, ζ): three surfaces, three stages of wear, two load cases, less the
//! lower spoiler late in the test under load, for which it has no data.

mod model;

use std::{fmt, str::FromStr, sync::OnceLock};

use serde::Deserialize;

use crate::error::{Error, Result};
pub use model::{Model, Provenance, Quantity};

/// The four parameters of eq. (1), checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Base {
    k: f64,
    p: f64,
    omega: f64,
    zeta: f64,
}

/// Name, unit, least and greatest value, meaning of one base parameter.
#[derive(Debug, Clone, Copy)]
pub struct BaseParameter {
    /// Name in model files and, behind `custom.` and `active.`, in the FMU.
    pub name: &'static str,
    /// Unit in the spelling of the contract.
    pub unit: &'static str,
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
    /// Value of the default set's order of magnitude, for solvers that scale.
    pub nominal: f64,
    /// What it is.
    pub meaning: &'static str,
}

impl Base {
    /// The four parameters in their order, with the ranges in which the dynamics are meaningful and solvable.
    pub const PARAMETERS: [BaseParameter; 4] = [
        BaseParameter { name: "k", unit: "deg/deg", min: -1e3, max: 1e3, nominal: 1.0, meaning: "gain" },
        BaseParameter { name: "p", unit: "1/s", min: 1e-3, max: 1e12, nominal: 1e4, meaning: "first-order pole" },
        BaseParameter {
            name: "omega",
            unit: "rad/s",
            min: 1e-3,
            max: 1e6,
            nominal: 100.0,
            meaning: "second-order frequency",
        },
        BaseParameter {
            name: "zeta",
            unit: "1",
            min: 0.0,
            max: 1e3,
            nominal: 1.0,
            meaning: "second-order damping ratio",
        },
    ];

    /// Gain k [deg/deg], pole p [1/s], frequency ω [rad/s], damping ratio ζ [1].
    ///
    /// # Errors
    /// A value that is not finite or outside [`Base::PARAMETERS`].
    pub fn new(k: f64, p: f64, omega: f64, zeta: f64) -> Result<Self> {
        Self::from_values([k, p, omega, zeta])
    }

    /// As [`Base::new`], in the order of [`Base::PARAMETERS`].
    ///
    /// # Errors
    /// A value that is not finite or outside its range.
    pub fn from_values(values: [f64; 4]) -> Result<Self> {
        for (parameter, value) in Self::PARAMETERS.iter().zip(values) {
            if !(parameter.min..=parameter.max).contains(&value) {
                return Err(Error::new(
                    format!("parameter {}", parameter.name),
                    format!("{value} {}", parameter.unit),
                    format!("{} to {} {}", parameter.min, parameter.max, parameter.unit),
                ));
            }
        }
        let [k, p, omega, zeta] = values;
        Ok(Self { k, p, omega, zeta })
    }

    /// Values in the order of [`Base::PARAMETERS`].
    #[must_use]
    pub fn values(&self) -> [f64; 4] {
        [self.k, self.p, self.omega, self.zeta]
    }

    /// Gain k [deg/deg].
    #[must_use]
    pub fn k(&self) -> f64 {
        self.k
    }

    /// First-order pole p [1/s].
    #[must_use]
    pub fn p(&self) -> f64 {
        self.p
    }

    /// Second-order frequency ω [rad/s].
    #[must_use]
    pub fn omega(&self) -> f64 {
        self.omega
    }

    /// Second-order damping ratio ζ [1].
    #[must_use]
    pub fn zeta(&self) -> f64 {
        self.zeta
    }
}

/// Defines an enumeration with its names, so that files, the FMU and the command line spell it alike.
macro_rules! named {
    ($(#[$doc:meta])* $name:ident { $($(#[$item_doc:meta])* $item:ident = $text:literal / $short:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $name { $($(#[$item_doc])* $item),+ }

        impl $name {
            /// All of them, in their order.
            pub const ALL: &'static [Self] = &[$(Self::$item),+];
            /// Their names, in their order.
            pub const NAMES: &'static [&'static str] = &[$($text),+];

            /// The name in full.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$item => $text),+ }
            }

            /// The form used in set names.
            #[must_use]
            pub fn short(self) -> &'static str {
                match self { $(Self::$item => $short),+ }
            }
        }
    };
}

named! {
    /// Control surface.
    Surface {
        /// Trailing edge, driven by a rotary vane actuator.
        TrailingEdge = "trailing_edge" / "te",
        /// Upper spoiler, driven by a piston actuator.
        UpperSpoiler = "upper_spoiler" / "us",
        /// Lower spoiler, driven by a piston actuator.
        LowerSpoiler = "lower_spoiler" / "ls",
    }
}

named! {
    /// Stage of the wind-tunnel test, that is of wear.
    Stage {
        /// First week.
        Early = "early" / "early",
        /// Second week.
        Middle = "middle" / "middle",
        /// Third week.
        Late = "late" / "late",
    }
}

named! {
    /// Aerodynamic load case.
    LoadCase {
        /// Wind off.
        Unloaded = "unloaded" / "unloaded",
        /// Mach 0.63 to 0.91, 74 to 190 psf.
        Loaded = "loaded" / "loaded",
    }
}

named! {
    /// Order of the transfer function.
    Order {
        /// Eq. (6): k ω² / (s² + 2ζω s + ω²).
        Second = "second" / "2",
        /// Eq. (1): k p ω² / ((s + p)(s² + 2ζω s + ω²)).
        Third = "third" / "3",
    }
}

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

/// Why the eighteenth combination is refused.
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
    /// Where the numbers come from.
    #[must_use]
    pub fn source(&self) -> String {
        format!("{SOURCE}, table {}, row {}", self.table, self.row)
    }
}

/// Band of the report's data [Hz].
pub const BAND_HZ: [f64; 2] = [0.5, 12.0];

/// The report.
pub const SOURCE: &str = "NASA/TM-1998-208452";

/// The 17 sets, table 1 before table 2, each from top to bottom: `table()[n - 1]` is set number n.
#[must_use]
pub fn table() -> &'static [ParameterSet] {
    static TABLE: OnceLock<Vec<ParameterSet>> = OnceLock::new();
    // The text is part of the program and a test reads every row of it, so that an empty table cannot be met.
    TABLE.get_or_init(|| parse_table(include_str!("parameters/tables.toml")).unwrap_or_default())
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

/// The set of a number, 1-9 for the rows of table 1, 10-17 for those of table 2.
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
        let sets = parse_table(include_str!("parameters/tables.toml")).unwrap();
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

    #[test]
    fn values_outside_their_range_are_refused_by_name() {
        for (values, name) in [
            ([f64::NAN, 1e4, 165.0, 0.5], "parameter k"),
            ([1.0, 0.0, 165.0, 0.5], "parameter p"),
            ([1.0, 1e4, f64::INFINITY, 0.5], "parameter omega"),
            ([1.0, 1e4, 165.0, -0.1], "parameter zeta"),
        ] {
            assert!(Base::from_values(values).unwrap_err().to_string().contains(name));
        }
    }
}
