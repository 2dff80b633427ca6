//! `actuator inspect`

use std::path::PathBuf;

use actuator_fmu::Result;
use identification::{
    inspect::{Inspection, compare_records, finding::Severity, inspect},
    signal::record::Record,
};

use super::records::RecordArguments;
use crate::{
    files,
    invocation::Invocation,
    output::{self, to_json},
    report::inspection,
};

/// Describe records: sampling, units, response, noise, and anomalies
#[derive(clap::Args)]
#[command(
    after_help = "frf, fit, diagnose and campaign make the same checks first: what is refused here is refused there, and warnings go into \
their results. Beside a record that follows and moves more, frf, fit and diagnose admit small motion that does not follow. Writes inspection.json and \
inspection.html into DIR.\n\nExamples:\n  actuator inspect sweep.csv random.csv\n  \
actuator inspect chirp.csv --columns time=t_s,command=cmd_mm,position=pos_mm --unit mm -o inspection"
)]
pub struct Arguments {
    #[command(flatten)]
    records: RecordArguments,
    /// Folder for the page
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Overwrite files in DIR
    #[arg(long)]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Exit with 10 if a record is usable with care, with 11 if one is refused
    #[arg(long)]
    exit_code: bool,
}

/// Names of the files.
const NAMES: [&str; 2] = ["inspection.json", "inspection.html"];

pub fn run(arguments: &Arguments, invocation: &Invocation) -> Result<u8> {
    arguments.output.as_deref().map_or(Ok(()), files::refuse_file)?;
    let (read, unreadable): (Vec<_>, Vec<_>) = arguments.records.read_each().into_iter().partition(Result::is_ok);
    let records: Vec<Record> = read.into_iter().flatten().collect();
    let mut inspections: Vec<_> = records.iter().map(inspect).collect();
    compare_records(&records.iter().collect::<Vec<&Record>>(), &mut inspections);
    if let Some(Err(error)) = unreadable.into_iter().next() {
        // The other records are still reported; nothing is written.
        if !arguments.json && !inspections.is_empty() {
            output::print(&inspection::text(&inspections))?;
        }
        return Err(error);
    }
    let json = inspection::json(&inspections);
    if let Some(folder) = &arguments.output {
        let contents = [format!("{}\n", to_json(&json)?), inspection::html(&records, &inspections, invocation)];
        let written: Vec<(String, Vec<u8>)> =
            NAMES.iter().map(|name| (*name).to_owned()).zip(contents.map(String::into_bytes)).collect();
        files::write_folder(folder, &written, arguments.force)?;
    }
    let code = if arguments.exit_code { code(inspections.iter().map(Inspection::severity).max()) } else { 0 };
    if arguments.json {
        return output::print_json(&json).map(|()| code);
    }
    let place = arguments.output.as_ref().map(|folder| format!("open {}\n", folder.join(NAMES[1]).display()));
    output::print(&format!("{}{}", inspection::text(&inspections), place.unwrap_or_default())).map(|()| code)
}

fn code(gravest: Option<Severity>) -> u8 {
    match gravest {
        None | Some(Severity::Note) => 0,
        Some(Severity::Warning) => 10,
        Some(Severity::Refusal) => 11,
    }
}
