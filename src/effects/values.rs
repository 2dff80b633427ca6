//! Checked values of the parameters of all effects.

use super::{
    chain::{CHAIN, PARAMETERS, find},
    effect::{Effect, Parameter},
};
use crate::error::{Error, Result};

/// Values of all parameters, in the order of the chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Effects([f64; PARAMETERS]);

impl Default for Effects {
    /// All effects neutral.
    fn default() -> Self {
        let mut values = [0.0; PARAMETERS];
        values.iter_mut().zip(Self::parameters()).for_each(|(value, (_, parameter))| *value = parameter.neutral);
        Self(values)
    }
}

impl Effects {
    /// All parameters with their effects, in the order of their values.
    pub fn parameters() -> impl Iterator<Item = (&'static Effect, &'static Parameter)> {
        CHAIN.iter().flat_map(|effect| effect.parameters.iter().map(|parameter| (*effect, parameter)))
    }

    /// All effects with their values.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Effect, &[f64])> {
        CHAIN.iter().scan(0, |start, effect| {
            let values = &self.0[*start..*start + effect.parameters.len()];
            *start += effect.parameters.len();
            Some((*effect, values))
        })
    }

    /// Those that are not neutral.
    pub fn active(&self) -> impl Iterator<Item = (&'static Effect, &[f64])> {
        self.iter().filter(|(effect, values)| !effect.is_neutral(values))
    }

    /// All values, in the order of [`Effects::parameters`].
    #[must_use]
    pub fn values(&self) -> &[f64; PARAMETERS] {
        &self.0
    }

    /// Effects with these values.
    ///
    /// # Errors
    /// A wrong number of values, one outside its range, values that violate the constraint of an effect.
    pub fn with_values(values: &[f64]) -> Result<Self> {
        let Ok(all) = <[f64; PARAMETERS]>::try_from(values) else {
            return Err(Error::new("effect parameters", values.len().to_string(), PARAMETERS.to_string()));
        };
        for ((effect, parameter), value) in Self::parameters().zip(values) {
            check(effect, parameter, *value)?;
        }
        let effects = Self(all);
        for (effect, values) in effects.iter() {
            if let Some(constraint) = effect.constraint.as_ref().filter(|constraint| !(constraint.holds)(values)) {
                return Err(Error::new(
                    format!("parameters of {}", effect.name),
                    format!("{values:?}"),
                    constraint.words,
                ));
            }
        }
        Ok(effects)
    }

    /// Index of a parameter among the values.
    ///
    /// # Errors
    /// No such effect or parameter.
    pub fn index(effect: &str, parameter: &str) -> Result<usize> {
        Self::parameters().position(|(one, other)| one.name == effect && other.name == parameter).ok_or_else(|| {
            let known: Vec<&str> = match find(effect) {
                None => CHAIN.iter().map(|effect| effect.name).collect(),
                Some(effect) => effect.parameters.iter().map(|parameter| parameter.name).collect(),
            };
            Error::new("effect parameter", format!("{effect}.{parameter}"), known.join(", "))
        })
    }

    /// The values of an effect, in the order of its parameters; `None` if there is no such effect.
    #[must_use]
    pub fn values_of(&self, effect: &str) -> Option<&[f64]> {
        self.iter().find(|(other, _)| other.name == effect).map(|(_, values)| values)
    }

    /// As above, `None` if the effect is neutral.
    #[must_use]
    pub fn active_values_of(&self, effect: &str) -> Option<&[f64]> {
        self.active().find(|(other, _)| other.name == effect).map(|(_, values)| values)
    }

    /// A copy with one effect neutral.
    #[must_use]
    pub fn without(&self, effect: &Effect) -> Self {
        let mut values = self.0;
        for (value, (other, parameter)) in values.iter_mut().zip(Self::parameters()) {
            *value = if other.name == effect.name { parameter.neutral } else { *value };
        }
        Self(values)
    }

    /// A copy with one effect's values replaced, in the order of its parameters.
    ///
    /// # Errors
    /// As [`Effects::with_values`].
    pub fn with(&self, effect: &Effect, values: &[f64]) -> Result<Self> {
        let mut all = self.0;
        for (parameter, value) in effect.parameters.iter().zip(values) {
            all[Self::index(effect.name, parameter.name)?] = *value;
        }
        Self::with_values(&all)
    }
}

fn check(effect: &Effect, parameter: &Parameter, value: f64) -> Result<()> {
    let Parameter { name, unit, min, max, .. } = parameter;
    if (*min..=*max).contains(&value) {
        return Ok(());
    }
    Err(Error::new(
        format!("parameter {}.{name}", effect.name),
        format!("{value} {unit}"),
        format!("{min} to {max} {unit}"),
    ))
}
