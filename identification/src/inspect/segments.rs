//! A record cut at its gaps, with its dropped rows reinserted.

use std::path::Path;

use super::{dropped_rows::completed, sampling};
use crate::signal::record::Record;

/// Separator between the name of a record and the place of a part in it.
const PART: &str = ", segment ";

/// The record from which a part was cut, or the record itself.
#[must_use]
pub fn whole_record(source: &Path) -> String {
    let name = source.display().to_string();
    name.split(PART).next().unwrap_or_default().to_owned()
}

/// The parts of a record between its gaps, as records with separate start states; parts that are too short for a record, or in which the
/// command rests, are left out. A record without gaps is a single part. Dropped single rows are reinserted (`dropped_rows`).
#[must_use]
pub fn segments(record: Record) -> Vec<Record> {
    let clock = sampling::clock(record.time());
    let gaps = &clock.gaps;
    if gaps.is_empty() {
        return vec![completed(record, &clock)];
    }
    let ends: Vec<usize> = gaps.iter().map(|gap| gap + 1).chain([record.len()]).collect();
    let starts = std::iter::once(0).chain(ends.iter().copied());
    let parts: Vec<Record> = starts
        .zip(&ends)
        .enumerate()
        .filter_map(|(index, (start, end))| {
            let name = format!("{}{PART}{} of {}", record.source().display(), index + 1, ends.len());
            record.part(start..*end).ok().map(|part| completed(part.named(name), &clock))
        })
        .collect();
    if parts.is_empty() { vec![record] } else { parts }
}
