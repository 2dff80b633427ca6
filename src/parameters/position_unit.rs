//! The unit of a position, and the units derived from it.
//!
//! A model, its records and its FMU use one position unit u; rates are then in u/s, accelerations in u/s², the gain k in u/u. The tables of
//! base parameters and effects list units for u = deg; [`PositionUnit::derived`] gives the others.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Unit of command, position and load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&'static str")]
pub enum PositionUnit {
    /// Degrees.
    #[default]
    Degree,
    /// Radians.
    Radian,
    /// Millimetres.
    Millimetre,
    /// Metres.
    Metre,
    /// A number without unit.
    One,
}

/// Kind of a position; units of one kind are convertible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PositionKind {
    /// deg, rad.
    Angle,
    /// mm, m.
    Length,
    /// 1.
    Number,
}

impl fmt::Display for PositionKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Angle => "an angle",
            Self::Length => "a length",
            Self::Number => "a number without unit",
        })
    }
}

const DEGREES_PER_RADIAN: f64 = 180.0 / std::f64::consts::PI;
const RADIANS_PER_DEGREE: f64 = std::f64::consts::PI / 180.0;
const MILLIMETRES_PER_METRE: f64 = 1000.0;

impl PositionUnit {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Degree, Self::Radian, Self::Millimetre, Self::Metre, Self::One];

    /// As spelled in arguments and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Degree => "deg",
            Self::Radian => "rad",
            Self::Millimetre => "mm",
            Self::Metre => "m",
            Self::One => "1",
        }
    }

    /// Angle, length or number.
    #[must_use]
    pub fn kind(self) -> PositionKind {
        match self {
            Self::Degree | Self::Radian => PositionKind::Angle,
            Self::Millimetre | Self::Metre => PositionKind::Length,
            Self::One => PositionKind::Number,
        }
    }

    /// Unit of a rate.
    #[must_use]
    pub fn of_rate(self) -> &'static str {
        match self {
            Self::Degree => "deg/s",
            Self::Radian => "rad/s",
            Self::Millimetre => "mm/s",
            Self::Metre => "m/s",
            Self::One => "1/s",
        }
    }

    /// Unit of an acceleration.
    #[must_use]
    pub fn of_acceleration(self) -> &'static str {
        match self {
            Self::Degree => "deg/s2",
            Self::Radian => "rad/s2",
            Self::Millimetre => "mm/s2",
            Self::Metre => "m/s2",
            Self::One => "1/s2",
        }
    }

    /// Unit of the inverse of a square.
    #[must_use]
    pub fn of_inverse_square(self) -> &'static str {
        match self {
            Self::Degree => "1/deg2",
            Self::Radian => "1/rad2",
            Self::Millimetre => "1/mm2",
            Self::Metre => "1/m2",
            Self::One => "1",
        }
    }

    /// Unit of a gain from command to position.
    #[must_use]
    pub fn of_gain(self) -> &'static str {
        match self {
            Self::Degree => "deg/deg",
            Self::Radian => "rad/rad",
            Self::Millimetre => "mm/mm",
            Self::Metre => "m/m",
            Self::One => "1/1",
        }
    }

    /// The unit for these positions, from that for positions in deg. One that does not involve positions is unchanged.
    #[must_use]
    pub fn derived(self, unit: &'static str) -> &'static str {
        match unit {
            "deg" => self.name(),
            "deg/s" => self.of_rate(),
            "deg/s2" => self.of_acceleration(),
            "1/deg2" => self.of_inverse_square(),
            "deg/deg" => self.of_gain(),
            other => other,
        }
    }

    /// Power of the position unit in a unit given for positions in deg.
    #[must_use]
    pub fn power(unit: &str) -> i32 {
        match unit {
            "deg" | "deg/s" | "deg/s2" => 1,
            "1/deg2" => -2,
            _ => 0,
        }
    }

    /// Order of magnitude of positions in this unit, for solvers that scale: the equivalent of 1 deg.
    #[must_use]
    pub fn typical(self) -> f64 {
        match self {
            Self::Degree | Self::Millimetre | Self::One => 1.0,
            Self::Radian => 0.01,
            Self::Metre => 0.001,
        }
    }

    /// A position in another unit of the same kind.
    ///
    /// # Errors
    /// A unit of another kind.
    pub fn convert(self, value: f64, to: Self) -> Result<f64> {
        Ok(match (self, to) {
            (one, other) if one == other => value,
            (Self::Radian, Self::Degree) => value * DEGREES_PER_RADIAN,
            (Self::Degree, Self::Radian) => value * RADIANS_PER_DEGREE,
            (Self::Metre, Self::Millimetre) => value * MILLIMETRES_PER_METRE,
            (Self::Millimetre, Self::Metre) => value / MILLIMETRES_PER_METRE,
            _ => return Err(self.differs_in_kind_from(to)),
        })
    }

    /// A quantity whose unit contains the position unit to this power, in another unit of the same kind.
    ///
    /// # Errors
    /// A unit of another kind.
    pub fn convert_power(self, value: f64, power: i32, to: Self) -> Result<f64> {
        let (from, into) = if power < 0 { (to, self) } else { (self, to) };
        (0..power.abs()).try_fold(value, |value, _| from.convert(value, into))
    }

    fn differs_in_kind_from(self, to: Self) -> Error {
        let allowed: Vec<&str> =
            Self::ALL.iter().filter(|unit| unit.kind() == to.kind()).map(|unit| unit.name()).collect();
        Error::new("unit of positions", format!("{self}, {}, against {to}, {}", self.kind(), to.kind()), allowed.join(" or "))
            .remedy("units of different kinds do not convert: use a model and records of one kind, or state the unit they really have (--unit, [model] unit)")
    }
}

impl fmt::Display for PositionUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for PositionUnit {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|unit| unit.name() == text)
            .ok_or_else(|| Error::new("unit", format!("`{text}`"), "rad, deg, mm, m or 1"))
    }
}

impl TryFrom<String> for PositionUnit {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<PositionUnit> for &'static str {
    fn from(unit: PositionUnit) -> Self {
        unit.name()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use PositionUnit::{Degree, Metre, Millimetre, One, Radian};

    #[test]
    fn units_of_one_kind_convert_there_and_back() {
        for (from, value, to, expected) in [
            (Radian, std::f64::consts::PI, Degree, 180.0),
            (Degree, 180.0, Radian, std::f64::consts::PI),
            (Millimetre, 12.5, Metre, 0.0125),
            (Metre, 0.0125, Millimetre, 12.5),
            (One, 0.3, One, 0.3),
        ] {
            let converted = from.convert(value, to).unwrap();
            assert!((converted - expected).abs() <= 1e-15 * expected, "{from} {to} {converted}");
            let there_and_back = to.convert_power(from.convert_power(7.0, -2, to).unwrap(), -2, from).unwrap();
            assert!((there_and_back - 7.0).abs() < 1e-14);
        }
        // 1 / mm² is 1e6 / m².
        assert_eq!(Millimetre.convert_power(1.0, -2, Metre).unwrap(), 1e6);
    }

    #[test]
    fn units_of_different_kinds_are_refused_with_both_and_a_remedy() {
        let message = Degree.convert(1.0, Millimetre).unwrap_err().to_string();
        for words in ["deg, an angle", "mm, a length", "mm or m", "--unit"] {
            assert!(message.contains(words), "{message}");
        }
        assert!(One.convert(1.0, Metre).is_err());
    }

    #[test]
    fn derived_units_follow_the_position() {
        for (unit, spelled) in [
            ("deg", "mm"),
            ("deg/s", "mm/s"),
            ("deg/s2", "mm/s2"),
            ("1/deg2", "1/mm2"),
            ("deg/deg", "mm/mm"),
            ("Hz", "Hz"),
        ] {
            assert_eq!(Millimetre.derived(unit), spelled);
            assert_eq!(Degree.derived(unit), unit);
        }
    }
}
