//! Hold-out: which records are fitted and which ones check the fit.

use crate::signal::record::Record;
use actuator_fmu::error::{Error, Result};

/// Share of a single record that is held out at its end where no check record is given.
const HELD_OUT_SHARE: f64 = 0.3;

/// Records that a model is fitted to, and others on which it is judged.
pub struct Division {
    /// Fit records.
    pub fit: Vec<Record>,
    /// Check records.
    pub check: Vec<Record>,
    /// What was held out, in words, where no check record was given.
    pub note: Option<String>,
}

/// Divides records where none were given to check: the last one of several is held out, or the end of a single one.
///
/// # Errors
/// A single record too short to be divided.
pub fn divide(mut fit: Vec<Record>, check: Vec<Record>) -> Result<Division> {
    if !check.is_empty() {
        return Ok(Division { fit, check, note: None });
    }
    if fit.len() > 1 {
        let held: Vec<Record> = fit.pop().into_iter().collect();
        let note = format!("no check record was given: {} was held out", held[0].source().display());
        return Ok(Division { fit, check: held, note: Some(note) });
    }
    let Some(record) = fit.first() else { return Err(Error::new("records", "none", "one or more")) };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    // a count of samples
    let cut = ((1.0 - HELD_OUT_SHARE) * record.len() as f64) as usize;
    let note = format!(
        "no check record was given: the last {:.0} % of {} were held out",
        100.0 * HELD_OUT_SHARE,
        record.source().display()
    );
    let part = |range| {
        record.part(range).map_err(|error| {
            error.remedy(format!(
                "of {} samples {:.0} % are held out where no check record is given: give one (--check), or a longer record",
                record.len(),
                100.0 * HELD_OUT_SHARE
            ))
        })
    };
    Ok(Division { check: vec![part(cut..record.len())?], fit: vec![part(0..cut)?], note: Some(note) })
}
