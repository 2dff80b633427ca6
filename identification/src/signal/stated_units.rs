//! A row of units after a header, compared with the units in which the file is read: a different one would silently cause an error by a
//! factor.

use std::path::Path;

use super::format::{Format, PositionUnit, TimeUnit};
use actuator_fmu::error::{Error, Result};

/// Checks the columns that are read, by role and index.
///
/// # Errors
/// A known unit other than the one in which the column is read. Words that are not units of time or position are ignored.
pub fn check(
    units: &[&str],
    columns: &[(&str, usize)],
    format: &Format,
    path: &Path,
    line: Option<usize>,
) -> Result<()> {
    for (role, place) in columns {
        let Some(word) = units.get(*place).map(|unit| bare(unit)) else { continue };
        let (stated, read, option) = if *role == "time" {
            let read = format.time_unit.unwrap_or(TimeUnit::Second);
            (time_unit(&word).map(TimeUnit::name), read.name(), "--time-unit")
        } else {
            (position_unit(&word).map(PositionUnit::name), format.unit.name(), "--unit")
        };
        if let Some(stated) = stated.filter(|stated| *stated != read) {
            return Err(Error::new(
                format!("unit of the {role}"),
                format!("`{stated}` in the row of units, and {read} where the file is read"),
                "the same",
            )
            .remedy(format!("give {option} {stated}, or correct the row"))
            .at(path, line));
        }
    }
    Ok(())
}

/// Without brackets, in lower case.
fn bare(unit: &str) -> String {
    unit.trim_matches(|mark: char| mark.is_whitespace() || "[]()".contains(mark)).to_lowercase()
}

fn time_unit(word: &str) -> Option<TimeUnit> {
    match word {
        "sec" | "second" | "seconds" => Some(TimeUnit::Second),
        "msec" | "millisecond" | "milliseconds" => Some(TimeUnit::Millisecond),
        "µs" | "μs" | "usec" | "microsecond" | "microseconds" => Some(TimeUnit::Microsecond),
        _ => word.parse().ok(),
    }
}

fn position_unit(word: &str) -> Option<PositionUnit> {
    match word {
        "°" | "degree" | "degrees" => "deg".parse().ok(),
        "radian" | "radians" => "rad".parse().ok(),
        // A fraction, a count, or not a unit.
        "1" => None,
        _ => word.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_that_is_another_one_is_refused_with_its_column_and_what_to_do() {
        let columns = [("time", 0), ("command", 2), ("position", 1)];
        let check = |units: &[&str], format: &Format| check(units, &columns, format, Path::new("run.csv"), Some(2));
        let degrees = Format::default();
        for fits in [["s", "deg", "deg"], ["[s]", "(Deg)", "degrees"], ["sec", "°", "V"], ["-", "", "counts"]] {
            assert!(check(&fits, &degrees).is_ok(), "{fits:?}");
        }
        let said = |units: &[&str]| check(units, &degrees).unwrap_err().to_string();
        let position = said(&["s", "mm", "deg"]);
        assert!(
            position.contains("position") && position.contains("--unit mm") && position.contains("run.csv"),
            "{position}"
        );
        assert!(said(&["s", "deg", "rad"]).contains("command"));
        let time = said(&["ms", "deg", "deg"]);
        assert!(time.contains("time") && time.contains("--time-unit ms"), "{time}");
        let of_logger = Format { unit: PositionUnit::Millimetre, time_unit: Some(TimeUnit::Microsecond), ..degrees };
        assert!(check(&["µs", "mm", "mm"], &of_logger).is_ok() && check(&["s", "mm", "mm"], &of_logger).is_err());
    }
}
