//! `actuator export`

use std::path::PathBuf;

use actuator_fmu::Result;
use clap::ValueEnum;
use serde::Serialize;

use crate::{
    export::{
        export,
        measure::{Deviation, can_measure, measure},
        target::Target,
    },
    files, output,
};

/// Write a model in the language of a simulator that does not import FMUs
#[derive(clap::Args)]
#[command(
    after_help = "What the target cannot express is refused by name. With --measure the target itself is run through the report's sweep, and \
the largest deviation from this program's own simulation is printed and written into the head of the file: that takes Python with the \
package jsbsim or mujoco, or a C compiler.\n\nExamples:\n  actuator export us-late-loaded --to jsbsim -o us.xml\n  \
actuator export model.toml --to c --measure -o rudder.c\n  actuator export model.toml --to mujoco --measure .venv/bin/python"
)]
pub struct Arguments {
    /// Set name (see `actuator sets`) or model file
    model: String,
    /// Simulator or language
    #[arg(long, value_enum, value_name = "TARGET")]
    to: TargetArgument,
    /// Output file [default: the name of the set or model file, for XML with that of the target, and the extension]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Run the target with this Python and write its deviation into the file
    #[arg(long, value_name = "PYTHON", num_args = 0..=1, default_missing_value = "python3")]
    measure: Option<PathBuf>,
    /// Amplitude of the sweep for this measurement, in the model's unit
    #[arg(long, value_name = "A", default_value_t = 2.0)]
    amplitude: f64,
    /// Overwrite FILE
    #[arg(long)]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum TargetArgument {
    /// A `<system>` for JSBSim
    Jsbsim,
    /// A model in MJCF for MuJoCo
    Mujoco,
    /// C99
    C,
    /// Modelica; not run here
    Modelica,
}

#[derive(Serialize)]
struct Summary {
    model: String,
    target: &'static str,
    output: PathBuf,
    notes: Vec<String>,
    deviation: Option<Deviation>,
}

/// If nothing was measured: how to do it, if possible.
fn not_measured(target: Target) -> &'static str {
    if can_measure(target) {
        "Deviation from ours: not measured (actuator export --measure)."
    } else {
        "Deviation from ours: not measured."
    }
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let target = match arguments.to {
        TargetArgument::Jsbsim => Target::Jsbsim,
        TargetArgument::Mujoco => Target::Mujoco,
        TargetArgument::C => Target::C,
        TargetArgument::Modelica => Target::Modelica,
    };
    let model = files::read_model(&arguments.model)?;
    let name = model.identity.name.clone().unwrap_or_else(|| arguments.model.clone());
    let path =
        arguments.output.clone().unwrap_or_else(|| PathBuf::from(target.file_name(&files::stem(&arguments.model))));
    files::refuse_existing(&path, arguments.force)?;
    let exported = export(&model, &name, target)?;
    let deviation = match &arguments.measure {
        None => None,
        Some(python) => {
            let text = exported.text(target, &model, &name, not_measured(target));
            Some(measure(&text, &model, &name, target, python, arguments.amplitude)?)
        }
    };
    let sentence =
        deviation.as_ref().map_or_else(|| not_measured(target).to_owned(), |deviation| deviation.sentence(&model));
    files::write_new(&path, exported.text(target, &model, &name, &sentence).as_bytes(), arguments.force)?;
    if arguments.json {
        let (model, target, notes) = (arguments.model.clone(), target.name(), exported.notes);
        return output::print_json(&Summary { model, target, output: path, notes, deviation });
    }
    let notes: String = exported.notes.iter().map(|note| format!("note: {note}\n")).collect();
    output::print(&format!("{}: {name} for {}\n{notes}{sentence}\n", path.display(), target.name()))
}
