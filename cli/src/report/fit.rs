//! A fit as a page: parameters and their uncertainty, measured and modelled response, residual, and prediction of records that were not
//! fitted.

mod charts;
mod page;

use identification::{
    estimate::{Fit, RecordFit},
    signal::record::Record,
};

use crate::invocation::Invocation;

/// Content of the page.
pub struct Account<'a> {
    /// The result.
    pub fit: &'a Fit,
    /// Records that were fitted.
    pub records: &'a [Record],
    /// Check records, not fitted.
    pub others: &'a [Record],
    /// Their prediction errors.
    pub checks: &'a [RecordFit],
    /// Warnings on the records, as sentences.
    pub warnings: &'a [String],
    /// Path of the model file; `None` if it was not written.
    pub model_file: Option<String>,
    /// The command line.
    pub invocation: &'a Invocation,
}
