//! `actuator diagnose`

use std::path::PathBuf;

use actuator_fmu::{Result, diagnose, files, signal::record::Record};

use super::records::FormatArguments;

/// Find where a model and records disagree, name what is missing, add it
#[derive(clap::Args)]
pub struct Arguments {
    /// Set name (see `actuator sets`) or model file
    #[arg(long)]
    model: String,
    /// Records to explain
    #[arg(long, required = true, num_args = 1.., value_name = "RECORD.csv")]
    fit: Vec<PathBuf>,
    /// Records to check on
    #[arg(long, num_args = 1.., value_name = "RECORD.csv")]
    check: Vec<PathBuf>,
    #[command(flatten)]
    format: FormatArguments,
    /// Folder
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Overwrite
    #[arg(long)]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let model = files::read_model(&arguments.model)?;
    let format = arguments.format.format();
    let read =
        |paths: &[PathBuf]| -> Result<Vec<Record>> { paths.iter().map(|path| Record::read(path, &format)).collect() };
    let division = diagnose::divide(read(&arguments.fit)?, read(&arguments.check)?)?;
    let diagnosis = diagnose::diagnose(&model, &division.fit, &division.check)?;
    println!("{:?} noise {} misfit {:?}", diagnosis.verdict, diagnosis.noise_rms, diagnosis.misfit);
    for finding in &diagnosis.findings {
        println!("{finding:?}");
    }
    for candidate in &diagnosis.candidates {
        println!(
            "{:32} {:10.1} {:.6} {:.6}",
            candidate.name, candidate.delta_bic, candidate.fit_rms, candidate.check_rms
        );
    }
    Ok(())
}
