//! One element of the parameter vector of a search: parameters of one sign by their logarithm, the others in units of their start value.

use actuator_fmu::effects::UNLIMITED;

/// The parameter that an element of the vector stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Place in [`actuator_fmu::parameters::Base::PARAMETERS`].
    Base(usize),
    /// Place in [`Effects::parameters`].
    Effect(usize),
    /// Frequency of the chatter [Hz].
    Chatter,
}

/// How it is scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// value = sign exp(x)
    Logarithm(f64),
    /// value = scale x
    Linear(f64),
}

/// An element of the vector, and the range of x in which it is searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinate {
    /// Its parameter.
    pub target: Target,
    /// Its scale.
    pub scale: Scale,
    /// Least x.
    pub low: f64,
    /// Greatest x.
    pub high: f64,
}

impl Coordinate {
    /// The value at x.
    pub fn value(&self, x: f64) -> f64 {
        match self.scale {
            // A limit that does not act has exactly this value.
            Scale::Logarithm(sign) if (x - UNLIMITED.ln()).abs() < 1e-9 => sign * UNLIMITED,
            Scale::Logarithm(sign) => sign * x.exp(),
            Scale::Linear(scale) => scale * x,
        }
    }

    /// d value / dx
    pub fn slope(&self, x: f64) -> f64 {
        match self.scale {
            Scale::Logarithm(_) => self.value(x),
            Scale::Linear(scale) => scale,
        }
    }

    /// The x of a value.
    pub fn number(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Logarithm(sign) => (sign * value).max(f64::MIN_POSITIVE).ln(),
            Scale::Linear(scale) => value / scale,
        }
    }
}
