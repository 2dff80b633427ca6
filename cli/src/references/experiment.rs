//! The experiment behind the reference responses: its files, its sampling.

use actuator_fmu::parameters::ParameterSet;

/// File of the command.
pub const STIMULUS: &str = "step-command.csv";

/// File of the experiments.
pub const EXPERIMENTS: &str = "step-responses.exp";

/// Number of the last sample, 0.45 s: the slowest set has come to rest within 1e-3 deg.
pub const LAST_SAMPLE: usize = 90;

/// Sampling of the report's records [1/s].
pub const SAMPLES_PER_SECOND: f64 = 200.0;

/// File of a parameter set.
pub fn values_name(set: &ParameterSet) -> String {
    format!("{}.ssv", set.name)
}

/// File of the response of a set.
pub fn response_name(set: &ParameterSet) -> String {
    format!("{}-response.csv", set.name)
}

/// Time of the last sample [s].
pub fn stop_time_s() -> f64 {
    LAST_SAMPLE as f64 / SAMPLES_PER_SECOND
}
