//! `actuator diagnose`

use std::path::{Path, PathBuf};

use crate::{
    files,
    gap::{measure, measured_response},
    package,
    report::diagnosis::Account,
};
use actuator_fmu::{Error, Result, parameters::Model};
use fmu_build::{Archive, Overwrite};
use identification::{
    diagnose::{self, Diagnosis, RecordTerms, Verdict, location::locate, next_test::next_test},
    signal::{Response, record::Record, write_csv},
};
use indicatif::{ProgressBar, ProgressStyle};

use super::{
    records::FormatArguments,
    template::{any_fmu, failed},
};

/// Find where a model and measured records disagree, name the missing effect, add it, show the gap shrink
#[derive(clap::Args)]
#[command(
    after_help = "Writes diagnosis.json, report.html, model.toml and model.fmu into DIR; next_test.csv as well where two effects explain \
the records equally well. The gap before and after is measured on packaged FMUs. Without --check, a part of the records is held \
out.\n\nExamples:\n  actuator diagnose --model te-early-unloaded --fit sweep.csv random.csv --check multisine.csv -o diagnosis\n  \
actuator diagnose --model fitted.toml --fit chirp.csv --columns time=t_s,command=cmd_mm,position=pos_mm --unit mm -o diagnosis --json"
)]
pub struct Arguments {
    /// Set name (see `actuator sets`) or model file
    #[arg(long, value_name = "MODEL")]
    pub(super) model: String,
    /// Records to explain
    #[arg(long, required = true, num_args = 1.., value_name = "RECORD.csv")]
    pub(super) fit: Vec<PathBuf>,
    /// Records to check the explanation on
    #[arg(long, num_args = 1.., value_name = "RECORD.csv")]
    pub(super) check: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) format: FormatArguments,
    /// Folder for the results
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: PathBuf,
    /// Take the binary from this FMU
    #[arg(long, value_name = "F.fmu")]
    pub(super) from: Option<PathBuf>,
    /// Date to be noted in the model file
    #[arg(long, value_name = "TEXT")]
    pub(super) date: Option<String>,
    /// Write over files in DIR
    #[arg(long)]
    pub(super) force: bool,
    /// Print diagnosis.json
    #[arg(long)]
    pub(super) json: bool,
}

const FILES: [&str; 5] = ["diagnosis.json", "report.html", "model.toml", "model.fmu", "next_test.csv"];

pub fn run(arguments: &Arguments) -> Result<()> {
    let given = files::read_model(&arguments.model)?;
    let format = arguments.format.format();
    let read =
        |paths: &[PathBuf]| paths.iter().map(|path| files::read_record(path, &format)).collect::<Result<Vec<Record>>>();
    let (fit, check) = (read(&arguments.fit)?, read(&arguments.check)?);
    refuse_existing(arguments)?;
    let template = match &arguments.from {
        Some(path) => path.clone(),
        None => any_fmu()?,
    };
    let bar = ProgressBar::new(3);
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}, step {pos} of {len}, {elapsed}") {
        bar.set_style(style);
    }
    bar.set_message("explaining the records");
    let diagnose::Division { fit, check, note } = diagnose::divide(fit, check)?;
    let mut diagnosis = diagnose::diagnose(&given, &fit, &check)?;
    note_origin(&mut diagnosis, &fit, arguments);
    bar.inc(1);
    bar.set_message("measuring the gap on the FMUs");
    let work = tempfile::tempdir()
        .map_err(|error| Error::new("temporary folder", error.to_string(), "a place to write to"))?;
    let archive = Archive::read(&template).map_err(failed)?;
    let (before_fmu, after_fmu) = (work.path().join("before.fmu"), work.path().join("after.fmu"));
    let measured = measured_response(&fit);
    let nothing = vec![Vec::new(); fit.len() + check.len()];
    let gap = |model: &Model, fmu: &Path, starts: &[RecordTerms]| {
        package(&archive, model, fmu)?;
        measure(fmu, model, &fit, &check, &diagnosis, starts, measured.as_ref())
    };
    let (before, after) = rayon::join(
        || gap(&given, &before_fmu, &nothing),
        || gap(&diagnosis.after, &after_fmu, &diagnosis.record_terms),
    );
    let (before, after) = (before?, after?);
    bar.inc(1);
    bar.set_message("writing the report");
    let records: Vec<Record> = fit.iter().chain(&check).cloned().collect();
    let locations = locate(&diagnosis.best, &records, &diagnosis.residuals);
    let test = if diagnosis.verdict == Verdict::Ambiguous {
        let models: Vec<Model> = std::iter::once(&diagnosis.after).chain(&diagnosis.rivals).cloned().collect();
        next_test(&models, &fit, diagnosis.noise_rms)?
    } else {
        None
    };
    let notes: Vec<String> = note.into_iter().chain(diagnosis.notes.iter().cloned()).collect();
    let account = Account {
        diagnosis: &diagnosis,
        fit: &fit,
        check: &check,
        before: &before,
        after: &after,
        measured: measured.as_ref(),
        locations: &locations,
        carriers: &diagnosis.carriers,
        next_test: test.as_ref(),
        notes: &notes,
    };
    let json = super::to_json(&account.json())?;
    let mut written = vec![
        (FILES[0].to_owned(), format!("{json}\n").into_bytes()),
        (FILES[1].to_owned(), account.html().into_bytes()),
        (FILES[2].to_owned(), diagnosis.after.to_toml()?.into_bytes()),
        (FILES[3].to_owned(), bytes(&after_fmu)?),
    ];
    if let Some(test) = &test {
        let mut csv = Vec::new();
        write_csv(&mut csv, &test.command, &Response::default())
            .map_err(|error| Error::new("next_test.csv", error.to_string(), "a command"))?;
        written.push((FILES[4].to_owned(), csv));
    }
    files::write_folder(&arguments.output, &written, arguments.force)?;
    bar.finish_and_clear();
    if arguments.json {
        return super::print(&format!("{json}\n"));
    }
    let page = arguments.output.join(FILES[1]);
    super::print(&format!("{}open {}\n", account.text(), page.display()))
}

/// Before the work, not after it.
fn refuse_existing(arguments: &Arguments) -> Result<()> {
    let there = FILES.iter().map(|name| arguments.output.join(name)).find(|path| path.exists());
    match there.filter(|_| !arguments.force) {
        Some(path) => Err(Error::new("output file", "an existing file", "a new or empty folder")
            .remedy("give --force to overwrite, or another folder")
            .at(path, None)),
        None => Ok(()),
    }
}

fn note_origin(diagnosis: &mut Diagnosis, fit: &[Record], arguments: &Arguments) {
    if diagnosis.findings.is_empty() {
        return;
    }
    let names: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.name).collect();
    let provenance = &mut diagnosis.after.provenance;
    provenance.records = fit.iter().map(|record| record.source().display().to_string()).collect();
    provenance.hashes = fit.iter().map(|record| record.sha256().to_owned()).collect();
    provenance.method = Some(format!("diagnosis from {}: {}", arguments.model, names.join(", ")));
    provenance.date.clone_from(&arguments.date);
}

fn package(template: &Archive, model: &Model, path: &Path) -> Result<()> {
    package::for_model(template.clone(), model)?.write(path, Overwrite::Allow).map_err(failed)
}

fn bytes(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|error| Error::new("FMU", error.to_string(), "a readable file").at(path, None))
}
