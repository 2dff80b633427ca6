//! `actuator compare`

use crate::output;
use std::path::PathBuf;

use crate::{
    files,
    invocation::Invocation,
    report::{
        comparison,
        head::{FileRow, file_name},
    },
};
use actuator_fmu::{Error, Result};
use identification::compare::Comparison;

/// Compare wear and load: differences of the responses against 0.1 and 3 deg
#[derive(clap::Args)]
#[command(
    after_help = "Without MODEL: tables 1 and 2 of NASA/TM-1998-208452, and what the report says checked against them.\n\
With MODELs whose conditions are known, wear and load are compared; otherwise all against the first. A set name, a file that \
is called like one (te-early-unloaded.toml), or NAME=FILE says the condition.\n\n\
Examples:\n  actuator compare\n  actuator compare -o comparison\n  \
actuator compare te-early-unloaded=fit-1.toml te-late-unloaded=fit-9.toml\n  actuator compare before.toml after.toml --json"
)]
pub struct Arguments {
    /// Set names or model files; NAME= before a file states its condition
    #[arg(value_name = "MODEL")]
    models: Vec<String>,
    /// Write figures 6 to 13 and A1 to A10 (SVG), compare.json and compare.html here
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Overwrite files in DIR
    #[arg(long)]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments, invocation: &Invocation) -> Result<()> {
    arguments.output.as_deref().map_or(Ok(()), files::refuse_file)?;
    if let [one] = arguments.models.as_slice() {
        return Err(Error::new("MODEL", format!("one, `{one}`"), "two or more, or none for the tables of the report")
            .remedy("name what it is to be compared with"));
    }
    let comparison = if arguments.models.is_empty() {
        Comparison::of_tables()
    } else {
        let sets = arguments.models.iter().map(|model| files::read_set(model)).collect::<Result<Vec<_>>>()?;
        Comparison::of("given models", sets)
    };
    let written = match &arguments.output {
        None => String::new(),
        Some(folder) => {
            let files = comparison::files(&comparison, rows(&arguments.models), invocation)?;
            files::write_folder(folder, &files, arguments.force)?;
            format!("{} files written; open {}\n", files.len(), folder.join("compare.html").display())
        }
    };
    if arguments.json {
        return output::print_json(&comparison);
    }
    output::print(&format!("{}{written}", comparison::text(&comparison)))
}

/// The given models: set names, and files with their hashes.
fn rows(models: &[String]) -> Vec<FileRow> {
    let row = |model: &String| {
        let path = files::path_of_set(model);
        let sha256 = files::model_sha256(path);
        FileRow {
            name: file_name(path),
            role: (if sha256.is_some() { "model" } else { "tabulated set" }).to_owned(),
            samples: None,
            duration_s: None,
            sha256,
        }
    };
    models.iter().map(row).collect()
}
