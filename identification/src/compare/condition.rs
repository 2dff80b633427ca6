//! Test condition of an actuator: surface, stage of the test, load case. The report's have fixed names; others are arbitrary.

use std::{fmt, str::FromStr};

use serde::{Serialize, Serializer};

use actuator_fmu::{
    error::{Error, Result},
    parameters::{LoadCase, SetName, Stage, Surface},
};

/// A condition.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Condition {
    /// Which actuator: `trailing_edge`, or any word.
    pub surface: String,
    /// Stage, i.e. state of wear: `early`, or any word.
    pub stage: String,
    /// With or without load.
    pub load_case: LoadCase,
}

impl Condition {
    /// With words in their full or short form.
    ///
    /// # Errors
    /// A word that is empty or contains characters other than letters, digits and `_`: it becomes a part of file names.
    pub fn new(surface: &str, stage: &str, load_case: LoadCase) -> Result<Self> {
        let known = Surface::ALL.iter().find(|known| known.short() == surface);
        let surface = known.map_or(surface, |known| known.name());
        for (what, word) in [("surface", surface), ("stage", stage)] {
            if word.is_empty() || !word.chars().all(|letter| letter.is_alphanumeric() || letter == '_') {
                return Err(Error::new(what, format!("`{word}`"), "letters, digits and _"));
            }
        }
        Ok(Self { surface: surface.into(), stage: stage.into(), load_case })
    }

    /// Whether it is of this surface.
    #[must_use]
    pub fn is_of(&self, surface: Surface) -> bool {
        self.surface == surface.name()
    }

    /// Whether it is at this stage.
    #[must_use]
    pub fn is_at(&self, stage: Stage) -> bool {
        self.stage == stage.name()
    }

    /// The set of the tables for this condition, if it is one of the report's.
    #[must_use]
    pub fn set_name(&self) -> Option<SetName> {
        let surface = *Surface::ALL.iter().find(|surface| self.is_of(**surface))?;
        let stage = *Stage::ALL.iter().find(|stage| self.is_at(**stage))?;
        Some(SetName { surface, stage, load_case: self.load_case })
    }
}

impl From<SetName> for Condition {
    fn from(name: SetName) -> Self {
        Self { surface: name.surface.name().into(), stage: name.stage.name().into(), load_case: name.load_case }
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known = Surface::ALL.iter().find(|surface| self.is_of(**surface));
        let surface = known.map_or(self.surface.as_str(), |known| known.short());
        write!(f, "{surface}-{}-{}", self.stage, self.load_case.name())
    }
}

impl FromStr for Condition {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let refuse = || {
            Error::new("condition", format!("`{text}`"), "SURFACE-STAGE-LOAD, LOAD being unloaded or loaded")
                .remedy("as in te-early-unloaded")
        };
        let mut words = text.split('-');
        let (Some(surface), Some(stage), Some(load), None) = (words.next(), words.next(), words.next(), words.next())
        else {
            return Err(refuse());
        };
        let load_case = LoadCase::ALL.iter().find(|load_case| load_case.name() == load).ok_or_else(refuse)?;
        Self::new(surface, stage, *load_case)
    }
}

impl Serialize for Condition {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use actuator_fmu::parameters::table;

    #[test]
    fn a_condition_is_spelled_as_the_set_of_the_tables() {
        for set in table() {
            let condition = Condition::from(set.name);
            assert_eq!(condition.to_string(), set.name.to_string());
            assert_eq!(condition.to_string().parse::<Condition>().unwrap(), condition);
            assert_eq!(condition.set_name(), Some(set.name));
        }
        let own: Condition = "rudder_2-after_overhaul-loaded".parse().unwrap();
        assert_eq!((own.to_string().as_str(), own.set_name()), ("rudder_2-after_overhaul-loaded", None));
        for bad in ["te-early", "te-early-heavy", "te--loaded", "a/b-c-loaded", "te-early-loaded-x"] {
            assert!(bad.parse::<Condition>().is_err(), "{bad}");
        }
    }
}
