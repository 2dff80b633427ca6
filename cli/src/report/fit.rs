//! A fit as a page: parameters and how sure they are, the response that was measured beside that of the model, what is left, and how well
//! records are predicted that were not fitted.

mod charts;
mod page;

use identification::{
    estimate::{Fit, RecordFit},
    signal::record::Record,
};

use crate::invocation::Invocation;

/// What the page is made of.
pub struct Account<'a> {
    /// The result.
    pub fit: &'a Fit,
    /// Records that were fitted.
    pub records: &'a [Record],
    /// Records that were not.
    pub others: &'a [Record],
    /// How those are predicted.
    pub checks: &'a [RecordFit],
    /// What is suspect in the records, as sentences.
    pub warnings: &'a [String],
    /// Where the model file is; none if it was not written.
    pub model_file: Option<String>,
    /// How the program was called.
    pub invocation: &'a Invocation,
}
