//! Unit definitions of an FMU, for the unit of its positions.

use crate::parameters::PositionUnit;

/// A unit definition: exponents of SI base units, 0 for those not listed, and a factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Name used by the variables.
    pub name: &'static str,
    /// Exponent of the metre.
    pub m: i32,
    /// Exponent of the second.
    pub s: i32,
    /// Exponent of the radian.
    pub rad: i32,
    /// Value in SI base units = factor × value.
    pub factor: f64,
    /// Another unit to display values in, with displayed value = factor × value.
    pub display: Option<(&'static str, f64)>,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const MILLIMETRE: f64 = 1e-3;

/// Units of the variables of an FMU with positions in `unit`, each once.
#[must_use]
pub fn units(unit: PositionUnit) -> Vec<Unit> {
    let plain = |name, s, rad| Unit { name, m: 0, s, rad, factor: 1.0, display: None };
    let (m, rad, factor, display) = match unit {
        PositionUnit::Degree => (0, 1, DEGREE, Some(("rad", DEGREE))),
        PositionUnit::Radian => (0, 1, 1.0, Some(("deg", 1.0 / DEGREE))),
        PositionUnit::Millimetre => (1, 0, MILLIMETRE, None),
        PositionUnit::Metre => (1, 0, 1.0, Some(("mm", 1.0 / MILLIMETRE))),
        PositionUnit::One => (0, 0, 1.0, None),
    };
    let position = Unit { name: unit.name(), m, s: 0, rad, factor, display };
    let over_time = |name, s| Unit { name, s, display: None, ..position };
    let inverse_square = Unit {
        name: unit.of_inverse_square(),
        m: -2 * m,
        rad: -2 * rad,
        factor: 1.0 / (factor * factor),
        display: None,
        ..position
    };
    // In a turn per second.
    let angular_frequency = Unit { display: Some(("Hz", 1.0 / std::f64::consts::TAU)), ..plain("rad/s", -1, 1) };
    let all = [
        position,
        over_time(unit.of_rate(), -1),
        plain(unit.of_gain(), 0, 0),
        plain("1/s", -1, 0),
        angular_frequency,
        plain("1", 0, 0),
        over_time(unit.of_acceleration(), -2),
        inverse_square,
        plain("s", 1, 0),
        plain("rad", 0, 1),
        plain("Hz", -1, 0),
    ];
    all.into_iter().fold(Vec::new(), |mut units: Vec<Unit>, unit| {
        if !units.iter().any(|other| other.name == unit.name) {
            units.push(unit);
        }
        units
    })
}

/// The display unit of positions, if useful: deg for angles, mm for lengths.
#[must_use]
pub fn display_unit(unit: PositionUnit) -> Option<&'static str> {
    match unit {
        PositionUnit::Radian => Some("deg"),
        PositionUnit::Metre => Some("mm"),
        PositionUnit::Degree | PositionUnit::Millimetre | PositionUnit::One => None,
    }
}

/// The quantity measured by a unit, with the ISO 80000 names used by Modelica tools, which need it for conversion, to rad for instance.
#[must_use]
pub fn quantity(unit: &str) -> Option<&'static str> {
    Some(match unit {
        "deg" | "rad" => "Angle",
        "deg/s" => "AngularVelocity",
        "deg/s2" | "rad/s2" => "AngularAcceleration",
        "m" | "mm" => "Length",
        "m/s" | "mm/s" => "Velocity",
        "m/s2" | "mm/s2" => "Acceleration",
        "s" => "Time",
        "Hz" => "Frequency",
        // rad/s among them: a velocity for positions in rad, an angular frequency for ω.
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmu::variables::{Kind, variables};

    #[test]
    fn every_unit_of_a_variable_is_defined_once_for_every_unit_of_position() {
        for position in PositionUnit::ALL {
            let units = units(position);
            for variable in variables() {
                if let Kind::Real { unit, .. } = variable.kind {
                    let name = position.derived(unit);
                    assert_eq!(units.iter().filter(|unit| unit.name == name).count(), 1, "{} {name}", variable.name);
                }
            }
        }
    }

    #[test]
    fn definitions_in_si_units_are_those_of_the_unit() {
        let of = |position, name| units(position).into_iter().find(|unit| unit.name == name).unwrap();
        let exponents = |unit: Unit| (unit.m, unit.s, unit.rad, unit.factor);
        assert_eq!(exponents(of(PositionUnit::Millimetre, "mm/s2")), (1, -2, 0, 1e-3));
        assert_eq!(exponents(of(PositionUnit::Millimetre, "1/mm2")), (-2, 0, 0, 1e6));
        assert_eq!(exponents(of(PositionUnit::Metre, "m/s")), (1, -1, 0, 1.0));
        assert_eq!(exponents(of(PositionUnit::Degree, "deg/s")), (0, -1, 1, DEGREE));
        assert_eq!(exponents(of(PositionUnit::Radian, "rad/s")), (0, -1, 1, 1.0));
        assert_eq!(exponents(of(PositionUnit::One, "1/s2")), (0, -2, 0, 1.0));
    }
}
