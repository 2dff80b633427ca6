//! Deviation of an exported model: the target itself is run through a sweep by Python, and its positions are compared with ours.
//!
//! The scripts get the exported file, the name in it, the command as CSV, the step and the output path of positions; they print what ran.
//! The one for C needs a C compiler, the others the Python packages `jsbsim` and `mujoco`.

use std::{fs, path::Path, process::Command as Program};

use actuator_fmu::{
    error::{Error, Result},
    parameters::Model,
};
use identification::{
    digits::{significant, with_unit},
    signal::{
        Command, Interpolation, Response,
        excitation::{Excitation, Kind},
        record::rms,
        write_csv,
    },
    simulate::simulate,
};
use serde::Serialize;

use super::target::{Target, identifier};

/// Maximum difference over the sweep.
#[derive(Debug, Clone, Serialize)]
pub struct Deviation {
    /// What ran, with its version.
    pub ran: String,
    /// Amplitude of the command [unit of position].
    pub amplitude: f64,
    /// Maximum difference [unit of position].
    pub largest: f64,
    /// As a fraction of the maximum position [1].
    pub share: f64,
    /// Root mean square of the difference [unit of position].
    pub rms: f64,
}

impl Deviation {
    /// In one sentence.
    #[must_use]
    pub fn sentence(&self, model: &Model) -> String {
        let unit = model.unit().name();
        format!(
            "Largest deviation from ours over a sweep of 0.5 to 12 Hz, 75 s, of {}: {}, {} % of the greatest position, {} rms; measured with {}.",
            with_unit(self.amplitude, 3, unit),
            with_unit(self.largest, 3, unit),
            significant(100.0 * self.share, 2),
            with_unit(self.rms, 3, unit),
            self.ran
        )
    }
}

/// The script that runs a target; `None` if there is none.
fn script(target: Target) -> Option<&'static str> {
    match target {
        Target::Jsbsim => Some(include_str!("run_jsbsim.py")),
        Target::Mujoco => Some(include_str!("run_mujoco.py")),
        Target::C => Some(include_str!("run_c.py")),
        Target::Modelica => None,
    }
}

/// Whether a target can be run from here.
#[must_use]
pub fn can_measure(target: Target) -> bool {
    script(target).is_some()
}

/// Runs an exported text through the report's sweep of this amplitude.
///
/// # Errors
/// A target without a script; a missing Python or dependency; a target that fails.
pub fn measure(
    text: &str,
    model: &Model,
    name: &str,
    target: Target,
    python: &Path,
    amplitude: f64,
) -> Result<Deviation> {
    let Some(script) = script(target) else {
        return Err(Error::new("--measure", target.name(), "JSBSim, MuJoCo or C, which can be run from here")
            .remedy("leave --measure out, and compare the model in your own Modelica tool"));
    };
    let command = Excitation { amplitude, ..Excitation::new(Kind::Sweep) }.command()?;
    let ours = simulate(model, &command, Interpolation::Held)?.position;
    let (ran, theirs) = run(script, text, name, target, python, &command)?;
    let finite = theirs.iter().filter(|value| value.is_finite()).count();
    if finite != ours.len() {
        return Err(Error::new(target.name(), format!("{finite} finite positions"), ours.len().to_string())
            .remedy("the exported model does not run through the sweep: use the FMU"));
    }
    let differences: Vec<f64> = theirs.iter().zip(&ours).map(|(theirs, ours)| theirs - ours).collect();
    let greatest = |values: &[f64]| values.iter().fold(0.0_f64, |greatest, value| greatest.max(value.abs()));
    let largest = greatest(&differences);
    Ok(Deviation { ran, amplitude, largest, share: largest / greatest(&ours), rms: rms(&differences) })
}

/// What ran, and the positions at the times of the command.
fn run(
    script: &str,
    text: &str,
    name: &str,
    target: Target,
    python: &Path,
    command: &Command,
) -> Result<(String, Vec<f64>)> {
    let failed =
        |error: std::io::Error| Error::new("temporary file", error.to_string(), "a place that can be written to");
    let folder = tempfile::tempdir().map_err(failed)?;
    let file = |name: &str| folder.path().join(name);
    let exported = file("exported").with_extension(target.ending());
    let mut csv = Vec::new();
    write_csv(&mut csv, command, &Response::default()).map_err(failed)?;
    for (path, content) in [
        (file("run.py"), script.as_bytes()),
        (exported.clone(), text.as_bytes()),
        (file("command.csv"), csv.as_slice()),
    ] {
        fs::write(path, content).map_err(failed)?;
    }
    let output = Program::new(python)
        .arg(file("run.py"))
        .arg(&exported)
        .arg(identifier(name))
        .arg(file("command.csv"))
        .arg(target.step_s().unwrap_or_default().to_string())
        .arg(file("positions.txt"))
        .output()
        .map_err(|error| {
            Error::new("--measure", format!("{}: {error}", python.display()), "a Python interpreter")
                .remedy("name one: --measure /path/to/python")
        })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let last = said.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("nothing").to_owned();
        return Err(Error::new("--measure", last, "a target that runs").remedy(match target {
            Target::C => "install a C compiler (cc), or leave --measure out".to_owned(),
            _ => {
                format!("pip install {}, or name a Python that has it: --measure PYTHON", target.name().to_lowercase())
            }
        }));
    }
    let positions = fs::read_to_string(file("positions.txt")).map_err(failed)?;
    let positions = positions.split_whitespace().map(|word| word.parse().unwrap_or(f64::NAN)).collect();
    Ok((String::from_utf8_lossy(&output.stdout).trim().lines().last().unwrap_or_default().to_owned(), positions))
}
