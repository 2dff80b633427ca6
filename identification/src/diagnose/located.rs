//! A part of an axis in which a difference is denser than the record, and what its search needs on every axis.

use serde::Serialize;

/// A part of an axis in which the difference is denser than the record.
#[derive(Debug, Clone, Serialize)]
pub struct Location {
    /// `frequency`, `amplitude`, `rate`, `direction`, `reversal`, `position`, `time` or `load`.
    pub axis: &'static str,
    /// Lower and upper end.
    pub range: [f64; 2],
    /// Unit of the range.
    pub unit: &'static str,
    /// Share of the squared difference that lies there.
    pub share_of_gap: f64,
    /// Share of the record that lies there.
    pub share_of_record: f64,
    /// p-value of the share.
    pub p_value: f64,
    /// In words.
    pub sentence: String,
    /// Density of the difference over that of the record along the whole axis: middle of a bin, ratio.
    pub density: Vec<[f64; 2]>,
}

/// Parts into which an axis is divided, each with the same share of the record.
pub const BINS: usize = 12;

/// Circular shifts against which a share is tested.
pub const SHIFTS: usize = 99;

/// Largest p-value of a location that is stated.
pub const SIGNIFICANCE_LEVEL: f64 = 0.05;

/// Shifts, or draws of noise, with a larger share at which a location is not significant: their number is not counted further.
pub const TOO_MANY: usize = (SIGNIFICANCE_LEVEL * (SHIFTS + 1) as f64) as usize;

/// The run of bins in which the share of the difference exceeds that of the record most.
pub fn densest(gap: &[f64], record: &[f64]) -> (usize, usize) {
    let (mut best, mut range) = (f64::NEG_INFINITY, (0, 0));
    let (mut sum, mut first) = (0.0, 0);
    for (bin, (gap, record)) in gap.iter().zip(record).enumerate() {
        if sum <= 0.0 {
            (sum, first) = (0.0, bin);
        }
        sum += gap - record;
        if sum > best {
            (best, range) = (sum, (first, bin));
        }
    }
    range
}

#[allow(clippy::cast_precision_loss)] // counts
pub fn located(
    axis: &'static str,
    unit: &'static str,
    range: [f64; 2],
    [share_of_gap, share_of_record]: [f64; 2],
    exceedances: usize,
    density: Vec<[f64; 2]>,
    phrase: &dyn Fn(f64, f64) -> String,
) -> Location {
    let sentence = format!(
        "{:.0} % of the difference lies {}, which is {:.0} % of the record",
        100.0 * share_of_gap,
        phrase(range[0], range[1]),
        100.0 * share_of_record
    );
    let p_value = (exceedances + 1) as f64 / (SHIFTS + 1) as f64;
    Location { axis, range, unit, share_of_gap, share_of_record, p_value, sentence, density }
}

/// Values of the samples that a difference was evaluated at: the last ones of a record, since its start settles.
pub fn evaluated<'a>(values: &'a [f64], gap: &[f64]) -> &'a [f64] {
    &values[values.len().saturating_sub(gap.len())..]
}
