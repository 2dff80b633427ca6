//! Frequency responses: of a model ([`response`]), of a model between samples of a record ([`sampled`]), and from records ([`estimate`]):
//! by Welch's method as in the report ([`welch`]) or by local polynomials ([`polynomial`]).

mod delayed_model;
mod excited_lines;
mod exponential_sums;
mod line_grid;
mod local_regression;
mod measured;
mod noise_profile;
pub mod polynomial;
mod power_density;
mod reference_model;
pub mod sampled;
mod spectrum;
mod transfer_function;
mod triangular_factor;
pub mod welch;

use crate::signal::record::Record;
use actuator_fmu::error::{Error, Result};

pub use actuator_fmu::parameters::BAND_HZ;
pub use delayed_model::DelayedModel;
pub use line_grid::LineChoice;
pub use measured::{FrequencyPoint, FrequencyResponse, Method};
pub use power_density::power_density;
pub use transfer_function::{phase_deg, response};
use welch::Welch;

/// The response from these records together.
///
/// # Errors
/// No record; for the report's method, records that are unevenly sampled, at different rates or shorter than a block.
pub fn estimate(records: &[Record], method: Method) -> Result<FrequencyResponse> {
    if records.is_empty() {
        return Err(Error::new("records", "none", "one or more"));
    }
    match method {
        Method::Report => {
            let mut welch = Welch::default();
            for record in records {
                welch.add(record)?;
            }
            welch.finish()
        }
        Method::Polynomial => polynomial::estimate(records, LineChoice::Resolved),
    }
}
