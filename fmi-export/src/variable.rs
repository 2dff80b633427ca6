//! One variable of a model: name, causality, variability, type with range; which values it may be set to, and when.

use crate::{
    calls::{self, Call, Kind, Phase},
    error::{Error, Result},
};

/// FMI causality.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set by the importer during simulation.
    Input,
    /// Computed.
    Output,
    /// Set by the importer.
    Parameter,
    /// Computed from parameters.
    CalculatedParameter,
    /// Computed, internal: states and their derivatives.
    Local,
}

/// FMI variability.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// May change at any time.
    Continuous,
    /// Changes at communication points and events only.
    Discrete,
    /// Constant once initialized.
    Fixed,
    /// May be changed between steps and at events.
    Tunable,
}

/// Type with its attributes.
#[derive(Debug, Clone, PartialEq)]
pub enum Type {
    /// A Real with its unit and optional range and nominal value.
    Real {
        /// Name of its unit.
        unit: &'static str,
        /// Minimum and maximum.
        range: Option<(f64, f64)>,
        /// Order of magnitude.
        nominal: Option<f64>,
    },
    /// An Integer with its range.
    Integer {
        /// Minimum.
        min: i32,
        /// Maximum.
        max: i32,
    },
    /// A Boolean.
    Boolean,
    /// An enumeration; items are numbered from 1.
    Enumeration(&'static Enumeration),
}

/// A type definition.
#[derive(Debug, PartialEq, Eq)]
pub struct Enumeration {
    /// Its name.
    pub name: &'static str,
    /// Meaning.
    pub description: &'static str,
    /// Items in their order, the first with value 1.
    pub items: &'static [&'static str],
}

/// One variable. `Slot` identifies it within the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable<Slot> {
    /// Name.
    pub name: String,
    /// Description.
    pub description: String,
    /// FMI causality.
    pub causality: Causality,
    /// FMI variability.
    pub variability: Variability,
    /// Type.
    pub kind: Type,
    /// Quantity of the model.
    pub slot: Slot,
}

/// A value of a variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// Of a Real.
    Real(f64),
    /// Of an Integer or of an Enumeration (item number).
    Integer(i32),
    /// Of a Boolean.
    Boolean(bool),
}

impl Value {
    /// Its type in words.
    #[must_use]
    pub fn kind(self) -> &'static str {
        match self {
            Self::Real(_) => "a Real",
            Self::Integer(_) => "an Integer",
            Self::Boolean(_) => "a Boolean",
        }
    }

    /// The number, of a Real.
    #[must_use]
    pub fn real(self) -> Option<f64> {
        if let Self::Real(value) = self { Some(value) } else { None }
    }
}

impl Type {
    /// True for a value of this type within its range.
    fn contains(&self, value: Value) -> bool {
        match (self, value) {
            (Self::Real { range: None, .. }, Value::Real(value)) => value.is_finite(),
            (Self::Real { range: Some((min, max)), .. }, Value::Real(value)) => (*min..=*max).contains(&value),
            (Self::Integer { min, max }, Value::Integer(value)) => (*min..=*max).contains(&value),
            (Self::Enumeration(of), Value::Integer(value)) => {
                (1..=of.items.len()).contains(&usize::try_from(value).unwrap_or(0))
            }
            (Self::Boolean, Value::Boolean(_)) => true,
            _ => false,
        }
    }

    /// True for a value of this type.
    pub(crate) fn accepts(&self, value: Value) -> bool {
        matches!(
            (self, value),
            (Self::Real { .. }, Value::Real(_))
                | (Self::Integer { .. } | Self::Enumeration(_), Value::Integer(_))
                | (Self::Boolean, Value::Boolean(_))
        )
    }

    /// The type in words.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Real { .. } => "a Real",
            Self::Integer { .. } => "an Integer",
            Self::Boolean => "a Boolean",
            Self::Enumeration(_) => "an Enumeration (set and read as an Integer)",
        }
    }
}

impl<Slot> Variable<Slot> {
    /// A Real without range and nominal value.
    pub fn real(
        name: impl Into<String>,
        description: impl Into<String>,
        causality: Causality,
        variability: Variability,
        unit: &'static str,
        slot: Slot,
    ) -> Self {
        let kind = Type::Real { unit, range: None, nominal: None };
        Self { name: name.into(), description: description.into(), causality, variability, kind, slot }
    }

    /// As above, with a range.
    #[must_use]
    pub fn within(mut self, low: f64, high: f64) -> Self {
        if let Type::Real { range, .. } = &mut self.kind {
            *range = Some((low, high));
        }
        self
    }

    /// The call by which it is set.
    pub(crate) fn setting(&self) -> Result<Call> {
        match (self.causality, self.variability) {
            (Causality::Input, _) => Ok(Call::SetInput),
            (Causality::Parameter, Variability::Tunable) => Ok(Call::Set),
            (Causality::Parameter, _) => Ok(Call::SetFixed),
            (Causality::Output | Causality::CalculatedParameter | Causality::Local, _) => {
                let found = format!("`{}`, which is calculated", self.name);
                Err(Error::new("variable to set", found, "inputs and parameters"))
            }
        }
    }

    /// Refuses to set a variable that may never be set, or not now.
    pub(crate) fn check_settable(&self, kind: Kind, phase: Phase) -> Result<()> {
        let settable = self.setting().and_then(|call| calls::check(call, kind, phase));
        settable.map_err(|error| error.remedy(format!("value of `{}` not set", self.name)))
    }

    /// Refuses a value of another type or outside the range.
    ///
    /// # Errors
    /// The variable, the value, the range.
    pub fn check_range(&self, value: Value) -> Result<()> {
        if self.kind.contains(value) { Ok(()) } else { self.refuse(value) }
    }

    #[cold]
    fn refuse(&self, value: Value) -> Result<()> {
        let refuse =
            |found: String, allowed: String| Err(Error::new(format!("value of `{}`", self.name), found, allowed));
        match (&self.kind, value) {
            (Type::Real { range, unit, .. }, Value::Real(value)) => {
                let (min, max) = range.unwrap_or((f64::MIN, f64::MAX));
                let allowed = if range.is_some() { format!("{min} to {max} {unit}") } else { "finite numbers".into() };
                refuse(format!("{value} {unit}"), allowed)
            }
            (Type::Integer { min, max }, Value::Integer(value)) => refuse(value.to_string(), format!("{min} to {max}")),
            (Type::Enumeration(of), Value::Integer(value)) => {
                let items: Vec<String> =
                    of.items.iter().zip(1..).map(|(name, number)| format!("{number} = {name}")).collect();
                refuse(value.to_string(), items.join(", "))
            }
            (kind, value) => refuse(value.kind().into(), kind.name().into()),
        }
    }
}

/// The value reference of the variable with this name.
#[must_use]
pub fn index_of<Slot>(all: &[Variable<Slot>], name: &str) -> Option<u32> {
    all.iter().position(|variable| variable.name == name).and_then(|index| u32::try_from(index).ok())
}
