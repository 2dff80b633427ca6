//! The statements of the report, checked against its own tables.
//!
//! Every sentence that can be checked by a number is here, paraphrased and in the report's order, with the number and a verdict. Where a
//! sentence uses a word such as "similar" or "about", the finding states its interpretation. "Significant" is what the report itself
//! defines: more than 0.1 in magnitude or 3 deg in phase.

mod analysis;
mod application;
mod conclusion;
mod estimation;
mod introduction;
mod load;
mod order_statistics;
mod pairs;
mod parameter_values;
mod section;

use super::{comparison::Comparison, statement::Statement};

/// All statements, in the order of the report.
#[must_use]
pub(super) fn of(tables: &Comparison) -> Vec<Statement> {
    [
        introduction::statements,
        estimation::statements,
        application::statements,
        analysis::statements,
        conclusion::statements,
    ]
    .iter()
    .flat_map(|section| section(tables))
    .collect()
}
