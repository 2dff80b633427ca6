//! Values of one of the parameters k, p, ω, ζ.

use crate::compare::comparison::Comparison;
use actuator_fmu::parameters::Base;

/// Position of the parameters in [`Base::PARAMETERS`].
pub const K: usize = 0;
pub const P: usize = 1;
pub const OMEGA: usize = 2;
pub const ZETA: usize = 3;

/// Values of one parameter in all sets.
pub fn values(tables: &Comparison, parameter: usize) -> Vec<f64> {
    tables.sets.iter().map(|set| set.model.base.values()[parameter]).collect()
}

/// A base with a different value of one parameter; the same base if that value is not allowed.
pub fn with(base: &Base, parameter: usize, value: f64) -> Base {
    let mut values = base.values();
    values[parameter] = value;
    Base::from_values(values).unwrap_or(*base)
}
