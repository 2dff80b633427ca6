//! The GUID of a model: a hash of the content of its description, start values included, and of the version number of its equations.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use super::{
    identifier::{BEHAVIOUR, MODEL_IDENTIFIER},
    start::Start,
    start_values::start_value,
    units::units,
    variables::{ENUMERATIONS, variables},
};

/// GUID of the FMU with these start values, for a model with this name, description and unit, in the form `{8-4-4-4-12}`.
#[must_use]
pub fn guid(start: &Start) -> String {
    let Start { settings, identity } = start;
    // Debug output of floating-point numbers is exact: values that differ in one bit give different text.
    let mut text = format!(
        "{MODEL_IDENTIFIER} {} {BEHAVIOUR} {identity:?} {:?} {ENUMERATIONS:?}",
        env!("CARGO_PKG_VERSION"),
        units(identity.unit)
    );
    for variable in variables() {
        // Writing to a String cannot fail.
        let _ = write!(text, "{variable:?} {:?}", start_value(variable.slot, settings));
    }
    let hash = Sha256::digest(text.as_bytes());
    let hex: String = hash.iter().take(16).fold(String::new(), |hex, byte| hex + &format!("{byte:02x}"));
    format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{Identity, PositionUnit};

    #[test]
    fn models_that_differ_in_one_bit_have_different_guids() {
        let one = Start::default();
        let mut other = one.clone();
        other.settings.custom[2] = f64::from_bits(other.settings.custom[2].to_bits() + 1);
        assert_ne!(guid(&one), guid(&other));
        assert_eq!(guid(&one), guid(&Start::default()));
        assert_eq!(guid(&one).len(), 38);
    }

    #[test]
    fn models_that_differ_in_name_description_or_unit_have_different_guids() {
        let named = |name: Option<&str>, description: Option<&str>, unit| {
            let (name, description) = (name.map(str::to_owned), description.map(str::to_owned));
            guid(&Start { identity: Identity { name, description, unit }, ..Start::default() })
        };
        let all = [
            named(None, None, PositionUnit::Degree),
            named(Some("a"), None, PositionUnit::Degree),
            named(None, Some("a"), PositionUnit::Degree),
            named(None, None, PositionUnit::Radian),
        ];
        for (index, one) in all.iter().enumerate() {
            assert!(all[..index].iter().all(|other| other != one));
        }
    }
}
