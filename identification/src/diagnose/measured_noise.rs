//! The noise of each record, measured without any explanation: repeats, periods, parts at rest, the spectrum above the band.

use super::quantiser::step_of;
use crate::{
    inspect::{
        compare_records, inspect_noise,
        noise::{Noise, Source},
    },
    parallel,
    signal::record::Record,
};

/// Noise of some records together.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredNoise {
    /// Of each record.
    pub records: Vec<Noise>,
}

impl MeasuredNoise {
    /// Measures records. Repeats among them, or among them and reference records, give the noise of both.
    pub fn of(records: &[&Record], reference: &[Record]) -> Self {
        let all: Vec<&Record> = records.iter().copied().chain(reference).collect();
        let mut inspections = parallel::map(&all, |record| inspect_noise(record));
        compare_records(&all, &mut inspections);
        let noise = inspections.into_iter().map(|inspection| inspection.noise);
        let of_record =
            |(noise, record): (Noise, &&Record)| Noise { rms: noise.rms.max(rounding_rms(record)), ..noise };
        Self { records: noise.zip(records).map(of_record).collect() }
    }

    /// Mean square of each record.
    pub fn mean_squares(&self) -> Vec<f64> {
        self.records.iter().map(|noise| noise.rms * noise.rms).collect()
    }

    /// Noise of the records from this one on together, with the weakest source among them.
    #[allow(clippy::cast_precision_loss)] // a count of records
    pub fn together(&self, from: usize) -> Noise {
        let some = &self.records[from.min(self.records.len())..];
        let square: f64 = some.iter().map(|noise| noise.rms * noise.rms).sum();
        let source = some.iter().map(|noise| noise.source).max_by_key(|source| *source as u8);
        Noise { rms: (square / some.len().max(1) as f64).sqrt(), source: source.unwrap_or(Source::Assumed) }
    }
}

/// Rms that rounding to the step of the positions adds while the position moves: at rest it does not show.
fn rounding_rms(record: &Record) -> f64 {
    step_of(&record.measured_positions()) / 12.0_f64.sqrt()
}

/// Whether a source gives the whole noise, and not a part of its spectrum or a bound.
pub fn is_whole(source: Source) -> bool {
    matches!(source, Source::Repeats | Source::Periods | Source::Quiet)
}
