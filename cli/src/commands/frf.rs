//! `actuator frf`

use std::{
    path::PathBuf,
    sync::{Arc, atomic::AtomicU64},
    time::Instant,
};

use crate::{
    files, output,
    progress::{Progress, estimate::Expectation},
};
use actuator_fmu::{Error, Result};
use clap::ValueEnum;
use identification::{
    frequency::{FrequencyResponse, LineChoice, phase_deg, polynomial, welch::Welch},
    inspect::ExpectedGain,
    signal::stream::Stream,
};
use serde::Serialize;

use super::records::RecordArguments;

/// Estimate the frequency response from records
#[derive(clap::Args)]
#[command(
    after_help = "Writes frequency, magnitude, phase, coherence, standard errors and whether the command excited the \
frequency. What the command does between samples (--hold, --linear) is divided out: the response is the actuator's own.\n\n\
Examples:\n  actuator frf sweep.csv random.csv -o frf.csv\n  \
actuator frf chirp.csv --columns time=t_s,command=cmd_mm,position=pos_mm --unit mm --method report"
)]
pub struct Arguments {
    #[command(flatten)]
    records: RecordArguments,
    /// Estimation method
    #[arg(long, value_enum, default_value_t = MethodArgument::Polynomial)]
    method: MethodArgument,
    /// Frequencies of --method polynomial, all between the lowest and the highest that the command excites
    #[arg(long, value_enum, default_value_t = LinesArgument::Resolved)]
    lines: LinesArgument,
    /// Write the response here
    #[arg(short, long, value_name = "FRF.csv")]
    output: Option<PathBuf>,
    /// Overwrite FRF.csv
    #[arg(long)]
    force: bool,
    /// Print the response as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodArgument {
    /// Local polynomials over whole records
    Polynomial,
    /// The report's: Hann window, 2048 samples, 75 % overlap
    Report,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LinesArgument {
    /// Spaced by one over the duration; for records longer than 100 s by 0.01 Hz up to 20 Hz and by 1/2000 of the frequency above: each is
    /// estimated from the lines within 0.25 Hz, so that more would add no information
    Resolved,
    /// All lines, spaced by one over the duration
    All,
}

impl From<LinesArgument> for LineChoice {
    fn from(lines: LinesArgument) -> Self {
        match lines {
            LinesArgument::Resolved => Self::Resolved,
            LinesArgument::All => Self::All,
        }
    }
}

#[derive(Serialize)]
struct Json<'a> {
    method: &'static str,
    records: Vec<String>,
    averages: Option<f64>,
    excited_band_hz: Option<[f64; 2]>,
    notes: &'a [String],
    warnings: &'a [String],
    points: Vec<Point>,
    output: Option<PathBuf>,
}

#[derive(Serialize)]
struct Point {
    frequency_hz: f64,
    magnitude: f64,
    phase_deg: f64,
    coherence: f64,
    magnitude_std_error: f64,
    phase_std_error_deg: f64,
    excited: bool,
}

/// Median ratio of the time of an estimate to that of reading and checking its records.
const USUAL_OF_READING: f64 = 2.0;

pub fn run(arguments: &Arguments) -> Result<()> {
    let mut warnings = Vec::new();
    let began = Instant::now();
    let progress = Progress::new("reading the records", Expectation::Usual(0.0));
    let response = match arguments.method {
        MethodArgument::Polynomial => {
            let (records, _, found) = arguments.records.read_admitted(&[], ExpectedGain::Any)?;
            warnings = found;
            progress.step("estimating", Expectation::Usual(USUAL_OF_READING * began.elapsed().as_secs_f64()));
            polynomial::estimate(&records, arguments.lines.into())?
        }
        // Block by block, so that a record may exceed memory.
        MethodArgument::Report => {
            let mut welch = Welch::default();
            let format = arguments.records.format();
            let sizes = arguments.records.paths().iter().filter_map(|path| Some(path.metadata().ok()?.len()));
            let read = Arc::new(AtomicU64::new(0));
            progress.step("reading the records", Expectation::Bytes(sizes.sum(), Arc::clone(&read)));
            for path in arguments.records.paths() {
                warnings.extend(files::admit_beginning(path, &format)?);
                welch.add_stream(&mut files::open_counted(path, &format, Stream::BLOCK, Arc::clone(&read))?)?;
            }
            welch.finish()?
        }
    };
    drop(progress);
    if let Some(path) = &arguments.output {
        let mut csv = Vec::new();
        response
            .write_csv(&mut csv)
            .map_err(|error| Error::new("response", error.to_string(), "a place that can be written to"))?;
        files::write_new(path, &csv, arguments.force)?;
    }
    if arguments.json {
        let points = response.points.iter().map(|point| Point {
            frequency_hz: point.frequency_hz,
            magnitude: point.response.norm(),
            phase_deg: phase_deg(point.response),
            coherence: point.coherence,
            magnitude_std_error: point.magnitude_std_error,
            phase_std_error_deg: point.phase_std_error_deg,
            excited: point.excited,
        });
        return output::print_json(&Json {
            method: response.method.name(),
            records: arguments.records.paths().iter().map(|path| path.display().to_string()).collect(),
            averages: response.averages,
            excited_band_hz: response.excited_band_hz(),
            notes: &response.notes,
            warnings: &warnings,
            points: points.collect(),
            output: arguments.output.clone(),
        });
    }
    let warned: String = warnings.iter().map(|warning| format!("warning: {warning}\n")).collect();
    output::print(&(text(&response, arguments) + &warned))
}

/// A dozen rows over the excited band, and notes.
fn text(response: &FrequencyResponse, arguments: &Arguments) -> String {
    const ROWS: usize = 12;
    let excited: Vec<_> = response.points.iter().filter(|point| point.excited).collect();
    let mut lines = vec!["frequency, Hz  magnitude          phase, deg        coherence".to_owned()];
    let stride = excited.len().div_ceil(ROWS).max(1);
    lines.extend(excited.iter().skip(stride / 2).step_by(stride).map(|point| {
        format!(
            "{:13.3}  {:.4} +- {:.4}  {:8.2} +- {:5.2}  {:.4}",
            point.frequency_hz,
            point.response.norm(),
            point.magnitude_std_error,
            phase_deg(point.response),
            point.phase_std_error_deg,
            point.coherence
        )
    }));
    if let Some([low, high]) = response.excited_band_hz() {
        lines.push(format!("excited from {low:.3} to {high:.3} Hz, {} frequencies", excited.len()));
    }
    lines.extend(response.notes.iter().map(|note| format!("note: {note}")));
    lines.extend(arguments.output.iter().map(|path| format!("written to {}", path.display())));
    lines.join("\n") + "\n"
}
