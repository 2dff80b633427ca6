//! `actuator simulate`

use crate::output;
use std::path::PathBuf;

use crate::{files, importer};
use actuator_fmu::{Error, Result};
use identification::{
    signal::{Command, Interpolation, Response, write_csv},
    simulate::simulate,
};
use serde::Serialize;

/// Step a model, or an FMU, through a command
#[derive(clap::Args)]
#[command(after_help = "Writes time, command, position, deflection and rate; without -o to standard output.\n\n\
Examples:\n  actuator simulate us-late-loaded command.csv -o response.csv\n  \
actuator simulate model.toml command.csv --linear --fmu target/fmu/BactActuator.fmu -o response.csv")]
pub struct Arguments {
    /// Set name (see `actuator sets`) or model file
    model: String,
    /// CSV with the columns `time` [s] and `command` [deg]
    command: PathBuf,
    /// Step this FMU instead of the internal model; MODEL's parameters are set where it has them
    #[arg(long, value_name = "F.fmu")]
    fmu: Option<PathBuf>,
    /// The command is held between samples (default)
    #[arg(long, conflicts_with = "linear")]
    hold: bool,
    /// The command moves linearly between samples
    #[arg(long)]
    linear: bool,
    /// Write the response here
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
    /// Overwrite OUT.csv
    #[arg(long)]
    force: bool,
    /// Print the summary as JSON (to standard error when the response goes to standard output)
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Summary {
    model: String,
    fmu: Option<PathBuf>,
    samples: usize,
    duration_s: f64,
    peak_position_deg: f64,
    final_position_deg: f64,
    output: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let model = files::read_model(&arguments.model)?;
    let command = files::read_command(&arguments.command)?;
    let interpolation = if arguments.linear { Interpolation::Linear } else { Interpolation::Held };
    let (response, note) = match &arguments.fmu {
        None => (simulate(&model, &command, interpolation)?, ""),
        Some(path) => {
            let imported = importer::simulate(path, &model, &command, interpolation)?;
            let note =
                if imported.parameters_set == 0 { "; the FMU has no parameters of MODEL and kept its own" } else { "" };
            (imported.response, note)
        }
    };
    let failed = |error: std::io::Error| Error::new("response", error.to_string(), "a place that can be written to");
    let mut csv = Vec::new();
    write_csv(&mut csv, &command, &response).map_err(failed)?;
    let summary = summary(arguments, &command, &response);
    let text = if arguments.json {
        serde_json::to_string_pretty(&summary)
            .map_err(|error| Error::new("JSON", error.to_string(), "finite numbers"))?
    } else {
        format!(
            "{} samples over {} s; peak position {:.4} deg, final {:.4} deg{note}",
            summary.samples, summary.duration_s, summary.peak_position_deg, summary.final_position_deg
        )
    };
    match &arguments.output {
        Some(path) => {
            files::write_new(path, &csv, arguments.force)?;
            let place = if arguments.json { String::new() } else { format!("; written to {}", path.display()) };
            output::print(&format!("{text}{place}\n"))
        }
        None => {
            output::print(&String::from_utf8_lossy(&csv))?;
            eprintln!("{text}");
            Ok(())
        }
    }
}

fn summary(arguments: &Arguments, command: &Command, response: &Response) -> Summary {
    let peak =
        response.position.iter().fold(0.0, |peak: f64, value| if value.abs() > peak.abs() { *value } else { peak });
    Summary {
        model: arguments.model.clone(),
        fmu: arguments.fmu.clone(),
        samples: command.time.len(),
        duration_s: command.time[command.time.len() - 1] - command.time[0],
        peak_position_deg: peak,
        final_position_deg: response.position[response.position.len() - 1],
        output: arguments.output.clone(),
    }
}
