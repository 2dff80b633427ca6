//! Additional content of an FMU according to the layered standard FMI-LS-REF: the 17 parameter sets, and for each the reference response,
//! so that an import of the FMU into a tool can be verified immediately.
//!
//! The stimulus steps at communication points only, so that it is the same signal whether a tool holds a command or interpolates linearly
//! between samples: at a step the time occurs twice, with the command before and after it.

mod experiment;
mod manifest;

use std::fmt::Write as _;

use crate::ssp;
use actuator_fmu::{
    error::Result,
    parameters::{Model, ParameterSet, table},
};
use experiment::{EXPERIMENTS, LAST_SAMPLE, SAMPLES_PER_SECOND, STIMULUS, response_name, stop_time_s};
use identification::{
    signal::{Command, Interpolation},
    simulate::simulate,
};

/// Folder of the FMU, named by the layered standard.
pub const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
/// Path of the explanation in the layered standard.
pub const EXPLANATION: &str = "documentation/fmi-ls-ref.txt";

/// Its text in the FMU of a model file.
pub const NO_REFERENCES: &str =
    "This FMU starts with the values of a model file; it carries no references (FMI-LS-REF).\n";

/// Steps [deg] with their sample, at 200 samples/s: both directions, a reversal, and back to rest.
const STEPS: [(usize, f64); 3] = [(10, 1.0), (30, -1.0), (50, 0.0)];
/// Expected agreement [deg]: double precision along different ways, with a margin for a tool's own arithmetic.
const AGREEMENT_DEG: f64 = 1e-9;

/// The files of [`FOLDER`] with their names, and below them that of [`EXPLANATION`].
///
/// # Errors
/// None in practice: those of the XML writer, a divergent motion.
pub fn files() -> Result<Vec<(String, Vec<u8>)>> {
    let inside = |name: &str| format!("{FOLDER}/{name}");
    let mut files = vec![
        (inside("fmi-ls-manifest.xml"), manifest::manifest()?.into_bytes()),
        (inside(EXPERIMENTS), manifest::experiments()?.into_bytes()),
        (inside(STIMULUS), stimulus().into_bytes()),
    ];
    files.extend(ssp::parameter_set_files(None)?.into_iter().map(|(name, bytes)| (inside(&name), bytes)));
    for set in table() {
        files.push((inside(&response_name(set)), response(set)?.into_bytes()));
    }
    files.push((EXPLANATION.into(), explanation().into_bytes()));
    Ok(files)
}

/// The corners of the command.
fn stimulus() -> String {
    let mut text = String::from("time,command\n0,0\n");
    let mut before = 0.0;
    for (sample, after) in STEPS {
        let time = sample as f64 / SAMPLES_PER_SECOND;
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{time},{before}\n{time},{after}");
        before = after;
    }
    let _ = writeln!(text, "{},{before}", stop_time_s());
    text
}

/// The response of the set at every sample.
fn response(set: &ParameterSet) -> Result<String> {
    let time: Vec<f64> = (0..=LAST_SAMPLE).map(|sample| sample as f64 / SAMPLES_PER_SECOND).collect();
    let last_step = |sample: usize| STEPS.iter().rev().find(|(made_at, _)| *made_at <= sample);
    let held = |sample| last_step(sample).map_or(0.0, |(_, command)| *command);
    let command = Command { time, command: (0..=LAST_SAMPLE).map(held).collect() };
    let response = simulate(&Model::from_set(set), &command, Interpolation::Held)?;
    let mut text = String::from("time,position,rate\n");
    for ((time, position), rate) in command.time.iter().zip(&response.position).zip(&response.rate) {
        let _ = writeln!(text, "{time},{position},{rate}");
    }
    Ok(text)
}

fn explanation() -> String {
    format!(
        "References (FMI-LS-REF)\n\n\
         The folder {FOLDER} holds\n\
         - one parameter set per identified actuator (*.ssv, SSP 1.0); it sets set_number and applies as it is;\n\
         - one experiment per set ({EXPERIMENTS}): the command {STIMULUS} [deg], steps at communication points, and the\n\
         \x20 response to it: position [deg] and rate [deg/s] every 5 ms, third order, no effects.\n\n\
         A position should agree within {AGREEMENT_DEG:e} deg at any communication step that meets the steps of the command.\n\
         A time that stands twice in the command is a step: the first value holds before it, the second from it on.\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slowest_set_has_come_to_rest_at_the_end() {
        for set in table() {
            let text = response(set).unwrap();
            assert_eq!(text.lines().count(), LAST_SAMPLE + 2);
            let last: f64 = text.lines().next_back().unwrap().split(',').nth(1).unwrap().parse().unwrap();
            assert!(last.abs() < 1e-3, "{} {last}", set.name);
        }
    }

    #[test]
    fn a_step_stands_twice_in_the_stimulus() {
        assert_eq!(stimulus(), "time,command\n0,0\n0.05,0\n0.05,1\n0.15,1\n0.15,-1\n0.25,-1\n0.25,0\n0.45,0\n");
    }
}
