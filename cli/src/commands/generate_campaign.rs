//! `actuator generate-campaign`

use crate::output;
use std::path::PathBuf;

use crate::{
    campaign::generate::{self, Options},
    files,
    progress::{
        Progress,
        estimate::{Expectation, Stage},
    },
};
use actuator_fmu::Result;
use serde::Serialize;

/// Write a synthetic BACT campaign: 34 records under 17 conditions, with known truth
#[derive(clap::Args)]
#[command(
    after_help = "Each condition of tables 1 and 2 gets a linear sweep and a random sequence of 0.5-12 Hz at 200 samples/s, with sensor \
noise and, under load, turbulence. The same seed writes the same files.\n\n\
Example:\n  actuator generate-campaign -o bact --seed 7\n  actuator campaign bact/manifest.toml -o bact-results"
)]
pub struct Arguments {
    /// Write manifest.toml, truth.toml and records/ here
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Seed of noise, turbulence and random sequences
    #[arg(long, default_value_t = Options::default().seed)]
    seed: u64,
    /// Length of each record [s]; the report's are 25 or 75
    #[arg(long, value_name = "S", default_value_t = Options::default().duration_s)]
    duration: f64,
    /// Peak command [deg]
    #[arg(long, value_name = "DEG", default_value_t = Options::default().amplitude_deg)]
    amplitude: f64,
    /// Sensor noise as a fraction of the position's rms
    #[arg(long, value_name = "SHARE", default_value_t = Options::default().noise_share)]
    noise: f64,
    /// Overwrite files in DIR
    #[arg(long)]
    force: bool,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Summary {
    manifest: PathBuf,
    records: usize,
    seed: u64,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    files::refuse_file(&arguments.output)?;
    let options = Options {
        seed: arguments.seed,
        duration_s: arguments.duration,
        amplitude_deg: arguments.amplitude,
        noise_share: arguments.noise,
    };
    let expectation = Expectation::Stages(vec![Stage::new(generate::RECORDS as u64, 1.0)]);
    let progress = Progress::new("generating records", expectation);
    let records = generate::write(&arguments.output, &options, arguments.force, &|done, of| {
        progress.done(done as u64, format!("{done} of {of} records generated"));
    })?;
    drop(progress);
    let summary = Summary { manifest: arguments.output.join("manifest.toml"), records, seed: arguments.seed };
    if arguments.json {
        return output::print_json(&summary);
    }
    output::print(&format!("{records} records, seed {}; manifest {}\n", summary.seed, summary.manifest.display()))
}
