//! The GUID of a model: a hash of everything that its description contains, start values included.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use super::{
    identifier::MODEL_IDENTIFIER,
    settings::Settings,
    start_values::start_value,
    variables::{ENUMERATIONS, UNITS, variables},
};

/// GUID of the FMU with these start values, in the form `{8-4-4-4-12}`.
#[must_use]
pub fn guid(start: &Settings) -> String {
    // Debug output of floating-point numbers is exact: two values that differ in one bit differ here.
    let mut text = format!("{MODEL_IDENTIFIER} {} {UNITS:?} {ENUMERATIONS:?}", env!("CARGO_PKG_VERSION"));
    for variable in variables() {
        // Writing to a String cannot fail.
        let _ = write!(text, "{variable:?} {:?}", start_value(variable.slot, start));
    }
    let hash = Sha256::digest(text.as_bytes());
    let hex: String = hash.iter().take(16).fold(String::new(), |hex, byte| hex + &format!("{byte:02x}"));
    format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_that_differ_in_one_bit_have_different_guids() {
        let one = Settings::default();
        let mut other = one.clone();
        other.custom[2] = f64::from_bits(other.custom[2].to_bits() + 1);
        assert_ne!(guid(&one), guid(&other));
        assert_eq!(guid(&one), guid(&Settings::default()));
        assert_eq!(guid(&one).len(), 38);
    }
}
