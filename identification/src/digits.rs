//! Numbers in words, with sufficient digits in any unit.

/// A value with this many significant digits, including trailing zeros; in exponential form far from 1.
#[must_use]
pub fn significant(value: f64, digits: usize) -> String {
    const LEAST_EXPONENT: i32 = -4;
    const GREATEST_EXPONENT: i32 = 6;
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let scientific = format!("{value:.*e}", digits.saturating_sub(1));
    // The exponent after rounding, which may turn 9.99 into 10.
    let exponent = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok()).unwrap_or(0);
    if !(LEAST_EXPONENT..=GREATEST_EXPONENT).contains(&exponent) {
        return scientific;
    }
    let before_point = usize::try_from(exponent + 1).unwrap_or(0);
    let zeros = usize::try_from(-exponent - 1).unwrap_or(0);
    format!("{value:.*}", if exponent < 0 { digits + zeros } else { digits.saturating_sub(before_point) })
}

/// A value with this many significant digits and its unit; unit 1 is omitted.
#[must_use]
pub fn with_unit(value: f64, digits: usize, unit: &str) -> String {
    let number = significant(value, digits);
    if unit == "1" { number } else { format!("{number} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_digits_as_asked_for_in_any_unit() {
        for (value, digits, text) in [
            (0.0123456, 4, "0.01235"),
            (1.23456e-5, 4, "1.235e-5"),
            (0.3, 4, "0.3000"),
            (-12.3456, 4, "-12.35"),
            (123_456.0, 4, "123456"),
            (9.9996, 4, "10.00"),
            (0.99996, 4, "1.000"),
            (0.099_999_6, 4, "0.1000"),
            (3e9, 3, "3.00e9"),
            (0.0, 4, "0"),
            (f64::NAN, 4, "NaN"),
        ] {
            assert_eq!(significant(value, digits), text);
        }
    }

    #[test]
    fn a_number_without_unit_has_none_in_words() {
        assert_eq!([with_unit(0.25, 2, "mm"), with_unit(0.25, 2, "1")], ["0.25 mm", "0.25"]);
    }
}
