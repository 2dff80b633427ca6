//! k, p, ω and ζ of eq. (1), with the ranges for which the dynamics are meaningful and solvable.

use crate::error::{Error, Result};

/// The four parameters of eq. (1), checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Base {
    k: f64,
    p: f64,
    omega: f64,
    zeta: f64,
}

/// Name, unit, minimum, maximum and meaning of one base parameter.
#[derive(Debug, Clone, Copy)]
pub struct BaseParameter {
    /// Name in model files and, after `custom.` and `active.`, in the FMU.
    pub name: &'static str,
    /// Unit, with positions in deg ([`PositionUnit::derived`](super::position_unit::PositionUnit::derived)).
    pub unit: &'static str,
    /// Minimum.
    pub min: f64,
    /// Maximum.
    pub max: f64,
    /// Order of magnitude, from the default set, for solvers that scale.
    pub nominal: f64,
    /// Meaning.
    pub meaning: &'static str,
}

impl Base {
    /// The four parameters in order, with the ranges for which the dynamics are meaningful and solvable.
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

    /// Gain k \[1\], pole p [1/s], frequency ω [rad/s], damping ratio ζ \[1\].
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
                // The range of a gain is the same in all units of position.
                let unit = if parameter.unit == "deg/deg" { String::new() } else { format!(" {}", parameter.unit) };
                return Err(Error::new(
                    format!("parameter {}", parameter.name),
                    format!("{value}{unit}"),
                    format!("{} to {}{unit}", parameter.min, parameter.max),
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

    /// Gain k \[1\].
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

    /// Second-order damping ratio ζ \[1\].
    #[must_use]
    pub fn zeta(&self) -> f64 {
        self.zeta
    }

    /// Decay rate of the pole pair: ζω; above critical damping its slower pole ω / (ζ + √(ζ² - 1)) [1/s].
    #[must_use]
    pub fn pair_decay(&self) -> f64 {
        let over = self.zeta * self.zeta - 1.0;
        if over > 0.0 { self.omega / (self.zeta + over.sqrt()) } else { self.zeta * self.omega }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// s² + 2ζω s + ω² at s = -decay: a root above critical damping, the real part of one below.
    #[test]
    fn a_pair_decays_with_its_slower_pole() {
        for (omega, zeta) in [(30.0, 3.5), (30.0, 1.0), (200.0, 40.0)] {
            let decay = Base::new(1.0, 100.0, omega, zeta).unwrap().pair_decay();
            let polynomial = decay * decay - 2.0 * zeta * omega * decay + omega * omega;
            assert!(polynomial.abs() < 1e-9 * omega * omega && decay <= omega, "{omega} {zeta} {decay}");
        }
        assert!((Base::new(1.0, 100.0, 30.0, 0.4).unwrap().pair_decay() - 12.0).abs() < 1e-12);
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
