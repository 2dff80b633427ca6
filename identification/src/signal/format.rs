//! Layout of a record file: columns, units, and interpolation of the command between samples.

use std::str::FromStr;

use super::Interpolation;
use actuator_fmu::error::{Error, Result};
pub use actuator_fmu::parameters::PositionUnit;

/// Column assignment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns {
    /// Time \[s\].
    pub time: String,
    /// Command.
    pub command: String,
    /// Measured position.
    pub position: String,
    /// External load; `None` means `load` if the file has it.
    pub load: Option<String>,
}

impl Default for Columns {
    fn default() -> Self {
        Self { time: "time".into(), command: "command".into(), position: "position".into(), load: None }
    }
}

impl FromStr for Columns {
    type Err = Error;

    /// From `time=t_s,command=cmd_rad,position=pos_rad`; the others keep their default.
    fn from_str(text: &str) -> Result<Self> {
        let allowed = "ROLE=NAME,... with the roles time, command, position and load";
        let mut columns = Self::default();
        for pair in text.split(',') {
            let refuse = || Error::new("columns", format!("`{pair}`"), allowed);
            let (role, name) = pair.split_once('=').ok_or_else(refuse)?;
            let name = name.trim().to_owned();
            match role.trim() {
                _ if name.is_empty() => return Err(refuse()),
                "time" => columns.time = name,
                "command" => columns.command = name,
                "position" => columns.position = name,
                "load" => columns.load = Some(name),
                _ => return Err(refuse()),
            }
        }
        Ok(columns)
    }
}

/// Unit of the time column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeUnit {
    /// Seconds.
    Second,
    /// Milliseconds.
    Millisecond,
    /// Microseconds.
    Microsecond,
}

impl TimeUnit {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Second, Self::Millisecond, Self::Microsecond];

    /// As spelled in arguments and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Second => "s",
            Self::Millisecond => "ms",
            Self::Microsecond => "us",
        }
    }

    /// Units per second: times are divided by it, which is exact to the last digit, unlike a product with 0.001.
    #[must_use]
    pub fn per_second(self) -> f64 {
        match self {
            Self::Second => 1.0,
            Self::Millisecond => 1e3,
            Self::Microsecond => 1e6,
        }
    }
}

impl FromStr for TimeUnit {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|unit| unit.name() == text)
            .ok_or_else(|| Error::new("unit of time", format!("`{text}`"), "s, ms or us"))
    }
}

/// How to read a record file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Format {
    /// Its columns.
    pub columns: Columns,
    /// Unit of command, position and load, which the record keeps.
    pub unit: PositionUnit,
    /// Interpolation of the command between samples.
    pub interpolation: Interpolation,
    /// Unit of its times; `None` means seconds, and refusal if they are evidently in another unit.
    pub time_unit: Option<TimeUnit>,
}
