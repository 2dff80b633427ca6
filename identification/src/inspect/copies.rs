//! Copies of a record: they add no evidence, and check nothing.

use crate::signal::record::Record;

/// Whether two records have the same samples. Two motions never have the same noise; only times may have a different origin.
#[must_use]
pub fn is_copy(one: &Record, other: &Record) -> bool {
    one.sha256() == other.sha256() || (one.command() == other.command() && one.position() == other.position())
}

/// Fit and check records without duplicates, and the omitted ones in words. A fit record is not used as a check record.
#[must_use]
pub fn without_copies(fit: Vec<Record>, check: Vec<Record>) -> (Vec<Record>, Vec<Record>, Vec<String>) {
    let mut words = Vec::new();
    let mut kept: Vec<Record> = Vec::with_capacity(fit.len() + check.len());
    let fitted = fit.len();
    let mut kept_to_fit = 0;
    for (index, record) in fit.into_iter().chain(check).enumerate() {
        if let Some(same) = kept.iter().position(|earlier| is_copy(earlier, &record)) {
            let does = match (index < fitted, same < kept_to_fit) {
                (true, _) => "a copy adds no evidence, and is left out",
                (false, true) => "a copy of a fitted record checks nothing, and is left out of the checks",
                (false, false) => "a copy checks nothing more, and is left out of the checks",
            };
            let (copy, original) = (record.source().display(), kept[same].source().display());
            words.push(format!("{copy}: it holds the same data as {original}: {does}; give another record"));
            continue;
        }
        kept_to_fit += usize::from(index < fitted);
        kept.push(record);
    }
    let check = kept.split_off(kept_to_fit);
    (kept, check, words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::{Command, Interpolation, format::PositionUnit};

    fn record(name: &str, phase: f64, start_s: f64) -> Record {
        let time: Vec<f64> = (0..200).map(|n| start_s + 0.01 * f64::from(n)).collect();
        let command: Vec<f64> = (0..200).map(|n| (0.1 * f64::from(n) + phase).sin()).collect();
        let position = command.iter().map(|value| 0.9 * value).collect();
        Record::new(Command { time, command }, position, PositionUnit::Degree, Interpolation::Held, name).unwrap()
    }

    #[test]
    fn each_record_counts_once_and_a_fitted_one_does_not_check() {
        let fit = vec![record("a", 0.0, 0.0), record("b", 1.0, 0.0), record("a again", 0.0, 0.0)];
        let check = vec![record("a later", 0.0, 5.0), record("c", 2.0, 0.0), record("c again", 2.0, 0.0)];
        let (fit, check, words) = without_copies(fit, check);
        let names = |records: &[Record]| -> Vec<String> {
            records.iter().map(|record| record.source().display().to_string()).collect()
        };
        assert_eq!((names(&fit), names(&check)), (vec!["a".to_owned(), "b".into()], vec!["c".to_owned()]));
        assert_eq!(words.len(), 3, "{words:?}");
        assert!(
            words[1].starts_with("a later: it holds the same data as a:")
                && words[1].contains("left out of the checks")
        );
    }
}
