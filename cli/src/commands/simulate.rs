//! `actuator simulate`

use crate::output;
use std::path::PathBuf;

use crate::{files, importer};
use actuator_fmu::{
    Error, Result,
    parameters::{Model, Order, PositionUnit},
};
use identification::{
    digits::{significant, with_unit},
    signal::{
        Command, Interpolation, Response,
        format::{Columns, Format, TimeUnit},
        write_csv,
    },
    simulate::simulate,
};
use serde::Serialize;

/// Step a model, or an FMU, through a command
#[derive(clap::Args)]
#[command(
    after_help = "Writes time, command, position, deflection and rate, in the unit of the model; without -o to standard output.\n\n\
Examples:\n  actuator simulate us-late-loaded command.csv -o response.csv\n  \
actuator simulate model.toml command.csv --linear --fmu target/fmu/BactActuator.fmu -o response.csv"
)]
pub struct Arguments {
    /// Set name (see `actuator sets`) or model file
    model: String,
    /// CSV with the columns `time` [s] and `command`; a record will do
    command: PathBuf,
    /// Column names if not the default ones, as in `time=t_s,command=cmd_deg`, or numbers, as in `time=1,command=2`
    #[arg(long, value_name = "ROLE=NAME|NUMBER,...")]
    columns: Option<Columns>,
    /// Unit of the time column: s (default), ms or us
    #[arg(long, value_name = "UNIT")]
    time_unit: Option<TimeUnit>,
    /// Unit of the command, if it is another one than the model's: rad, deg, mm, m or 1; it is converted to the model's
    #[arg(long)]
    unit: Option<PositionUnit>,
    /// Step this FMU instead of the internal model; MODEL's parameters are set where it has them. This runs the program in the FMU:
    /// take FMUs only from those whose programs you would run
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
    unit: &'static str,
    peak_position: f64,
    final_position: f64,
    notes: Vec<String>,
    output: Option<PathBuf>,
}

/// Significant digits of positions in the summary.
const DIGITS: usize = 5;

pub fn run(arguments: &Arguments) -> Result<()> {
    let mut model = files::read_model(&arguments.model)?;
    let mut notes = Vec::new();
    let of_fmu = arguments.fmu.as_deref().map(importer::position_unit).transpose()?.flatten();
    if let Some(unit) = of_fmu.filter(|unit| *unit != model.unit()) {
        notes.push(format!("MODEL was converted from {} to {unit}, the unit of the FMU", model.unit()));
        model = model.in_unit(unit).map_err(|error| error.or_at(&arguments.model))?;
    }
    let unit = model.unit();
    let format = Format {
        columns: arguments.columns.clone().unwrap_or_default(),
        unit: arguments.unit.unwrap_or(unit),
        time_unit: arguments.time_unit,
        ..Format::default()
    };
    let mut command = files::read_command(&arguments.command, &format)?;
    notes.extend(note_on_long_steps(&model, &command));
    if let Some(from) = arguments.unit.filter(|from| *from != unit) {
        let converted = command.command.iter().map(|value| from.convert(*value, unit)).collect::<Result<_>>();
        command.command = converted.map_err(|error| error.or_at(&arguments.command))?;
        notes.push(format!("the command was converted from {from} to {unit}, the unit of the model"));
    }
    let interpolation = if arguments.linear { Interpolation::Linear } else { Interpolation::Held };
    let response = match &arguments.fmu {
        None => simulate(&model, &command, interpolation)?,
        Some(path) => {
            let imported = importer::simulate(path, &model, &command, interpolation)?;
            if imported.parameters_set == 0 {
                notes.push("the FMU has no parameters of MODEL and kept its own".to_owned());
            }
            imported.response
        }
    };
    let failed = |error: std::io::Error| Error::new("response", error.to_string(), "a place that can be written to");
    let mut csv = Vec::new();
    write_csv(&mut csv, &command, &response).map_err(failed)?;
    let summary = summary(arguments, unit, &command, &response, notes);
    let text = if arguments.json {
        serde_json::to_string_pretty(&summary)
            .map_err(|error| Error::new("JSON", error.to_string(), "finite numbers"))?
    } else {
        format!(
            "{} samples over {} s; peak position {}, final {}{}",
            summary.samples,
            summary.duration_s,
            with_unit(summary.peak_position, DIGITS, summary.unit),
            with_unit(summary.final_position, DIGITS, summary.unit),
            summary.notes.iter().map(|note| format!("; {note}")).collect::<String>()
        )
    };
    match &arguments.output {
        Some(path) => {
            files::write_new(path, &csv, arguments.force)?;
            let place = if arguments.json { String::new() } else { format!("; written to {}", path.display()) };
            output::print(&format!("{text}{place}\n"))
        }
        None => output::print_with_summary(&csv, &text),
    }
}

/// Whether an actuator settles many times over within each step, as for times read in the wrong unit.
fn note_on_long_steps(model: &Model, command: &Command) -> Option<String> {
    /// In time constants of the slowest pole.
    const LONG: f64 = 50.0;
    let mut steps: Vec<f64> = command.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let usual = *steps.get(steps.len() / 2)?;
    let pair = model.base.pair_decay();
    let slowest = 1.0 / if model.order == Order::Third { pair.min(model.base.p()) } else { pair };
    (usual > LONG * slowest).then(|| {
        format!(
            "a step of {} s is {} time constants of the actuator, which comes to rest in each: if times are in milliseconds, give --time-unit ms",
            significant(usual, 3),
            significant(usual / slowest, 2)
        )
    })
}

fn summary(
    arguments: &Arguments,
    unit: PositionUnit,
    command: &Command,
    response: &Response,
    notes: Vec<String>,
) -> Summary {
    let peak =
        response.position.iter().fold(0.0, |peak: f64, value| if value.abs() > peak.abs() { *value } else { peak });
    Summary {
        model: arguments.model.clone(),
        fmu: arguments.fmu.clone(),
        samples: command.time.len(),
        duration_s: command.time[command.time.len() - 1] - command.time[0],
        unit: unit.name(),
        peak_position: peak,
        notes,
        final_position: response.position[response.position.len() - 1],
        output: arguments.output.clone(),
    }
}
