//! `actuator excite`

use crate::output;
use std::path::PathBuf;

use crate::files;
use actuator_fmu::{Error, Result};
use clap::ValueEnum;
use identification::digits::significant;
use identification::signal::{
    Response,
    excitation::{Excitation, Kind},
    record::rms,
    write_csv,
};
use serde::Serialize;

/// Generate a command that excites an actuator for identification
#[derive(clap::Args)]
#[command(
    after_help = "Writes time and command as CSV; without -o to standard output. Defaults are the report's: 75 s at 200 \
samples/s, 0.5-12 Hz.\n\nExamples:\n  actuator excite sweep --duration 25 --amplitude 2 -o sweep.csv\n  \
actuator excite multisine --seed 7 -o multisine.csv"
)]
pub struct Arguments {
    /// Kind of excitation
    kind: KindArgument,
    /// Write the command here
    #[arg(short, long, value_name = "F.csv")]
    output: Option<PathBuf>,
    /// Length, s
    #[arg(long, value_name = "S", default_value_t = Excitation::LONG_S)]
    duration: f64,
    /// Samples per second
    #[arg(long, value_name = "HZ", default_value_t = Excitation::RATE_HZ)]
    rate: f64,
    /// Lowest and highest frequency, Hz; triangles use the lowest, steps neither
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"], default_values_t = actuator_fmu::parameters::BAND_HZ)]
    band: Vec<f64>,
    /// Peak value, deg or the unit of the actuator
    #[arg(long, value_name = "A", default_value_t = 1.0)]
    amplitude: f64,
    /// Rest at both ends, part of the length, s
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    quiet: f64,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Overwrite F.csv
    #[arg(long)]
    force: bool,
    /// Print the summary as JSON (to standard error when the command goes to standard output)
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum KindArgument {
    /// Sine whose frequency rises linearly
    Sweep,
    /// Gaussian noise in the band
    Random,
    /// Sines of equal size at odd multiples of one frequency, random phases
    Multisine,
    /// Steps up and down, large and small
    Steps,
    /// Slow triangles, large and small
    Triangles,
}

#[derive(Serialize)]
struct Summary {
    kind: &'static str,
    samples: usize,
    duration_s: f64,
    rate_hz: f64,
    band_hz: [f64; 2],
    amplitude: f64,
    rms: f64,
    seed: u64,
    output: Option<PathBuf>,
}

/// Properties of the command in the band.
fn band_text(excitation: &Excitation) -> String {
    let [low, high] = excitation.band_hz;
    match excitation.kind {
        Kind::Sweep | Kind::Random | Kind::Multisine => format!(", {low} to {high} Hz"),
        Kind::Triangles => format!(", {low} Hz"),
        Kind::Steps => String::new(),
    }
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let kind = match arguments.kind {
        KindArgument::Sweep => Kind::Sweep,
        KindArgument::Random => Kind::Random,
        KindArgument::Multisine => Kind::Multisine,
        KindArgument::Steps => Kind::Steps,
        KindArgument::Triangles => Kind::Triangles,
    };
    let excitation = Excitation {
        kind,
        duration_s: arguments.duration,
        rate_hz: arguments.rate,
        band_hz: [arguments.band[0], arguments.band[1]],
        amplitude: arguments.amplitude,
        quiet_s: arguments.quiet,
        seed: arguments.seed,
    };
    let command = excitation.command()?;
    let mut csv = Vec::new();
    write_csv(&mut csv, &command, &Response::default())
        .map_err(|error| Error::new("command", error.to_string(), "a place that can be written to"))?;
    let summary = Summary {
        kind: kind.name(),
        samples: command.time.len(),
        duration_s: excitation.duration_s,
        rate_hz: excitation.rate_hz,
        band_hz: excitation.band_hz,
        amplitude: excitation.amplitude,
        rms: rms(&command.command),
        seed: excitation.seed,
        output: arguments.output.clone(),
    };
    let text = if arguments.json {
        output::to_json(&summary)?
    } else {
        format!(
            "{} of {} s at {} samples/s{}, up to {}, rms {}, seed {}",
            summary.kind,
            summary.duration_s,
            summary.rate_hz,
            band_text(&excitation),
            summary.amplitude,
            significant(summary.rms, 5),
            summary.seed
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
