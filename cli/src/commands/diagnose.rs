//! `actuator diagnose`

use std::{
    path::PathBuf,
    sync::OnceLock,
    time::{Duration, Instant},
};

use actuator_fmu::{Error, Result, parameters::Model};
use identification::signal::record::Record;

use super::records::FormatArguments;
use crate::{
    files,
    invocation::Invocation,
    output,
    progress::{Progress, estimate::Expectation},
    report::diagnosis::files::{NAMES, files},
    template,
    workflow::{
        self, Step, Task,
        account::{Account, Origin},
    },
};

/// Find where a model and measured records disagree, identify the missing effect, add it, and show the reduced difference
#[derive(clap::Args)]
#[command(
    after_help = "Writes diagnosis.json, report.html, model.toml and model.fmu into DIR; next_test.csv as well where two effects explain \
the records equally well. The difference before and after is measured on packaged FMUs. Without --check, a part of the records is held \
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
    /// Records of the healthy actuator: they determine the noise, and an effect leads only if more is missing than in them
    #[arg(long, num_args = 1.., value_name = "RECORD.csv")]
    pub(super) reference: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) format: FormatArguments,
    /// Folder for the results
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: PathBuf,
    /// Take the binary from this FMU, and run it [default: ACTUATOR_FMU, beside the program, or target/fmu]
    #[arg(long, value_name = "F.fmu")]
    pub(super) from: Option<PathBuf>,
    /// Name of the corrected model, for model.toml and model.fmu [default: that of MODEL]
    #[arg(long, value_name = "TEXT")]
    pub(super) name: Option<String>,
    /// Date for the model file
    #[arg(long, value_name = "TEXT")]
    pub(super) date: Option<String>,
    /// End the search after this time with the best result so far
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(super) time_limit: Option<Duration>,
    /// Overwrite files in DIR
    #[arg(long)]
    pub(super) force: bool,
    /// Print diagnosis.json
    #[arg(long)]
    pub(super) json: bool,
    /// Exit with the verdict: 0 nothing missing, 10 named, 11 leading, 12 ambiguous, 13 unexplained
    #[arg(long)]
    pub(super) exit_code: bool,
}

pub fn run(arguments: &Arguments, invocation: &Invocation) -> Result<u8> {
    // On one of the threads that do the work: otherwise each piece of it is handed to them, in memory of their own.
    let account = rayon::scope(|_| diagnose(arguments, invocation))?;
    let json = account.json();
    if arguments.json {
        output::print_json(&json)?;
    } else {
        output::print(&format!("{}open {}\n", account.text(), arguments.output.join(NAMES[1]).display()))?;
    }
    let verdict = json["verdict"].as_str().unwrap_or_default();
    Ok(if arguments.exit_code { code(verdict) } else { 0 })
}

/// Exit codes of verdicts, above those of shells and of errors of this program.
const CODES: [(&str, u8); 5] =
    [("nothing_missing", 0), ("named", 10), ("leading", 11), ("ambiguous", 12), ("unexplained", 13)];

fn code(verdict: &str) -> u8 {
    CODES.iter().find(|(name, _)| *name == verdict).map_or(0, |(_, code)| *code)
}

fn diagnose(arguments: &Arguments, invocation: &Invocation) -> Result<Account> {
    files::refuse_file(&arguments.output)?;
    let mut model: Model = files::read_model(&arguments.model)?;
    if arguments.name.is_some() {
        model.identity.name.clone_from(&arguments.name);
    }
    let format = arguments.format.format();
    let (began, progress) = (Instant::now(), Progress::new("reading the records", Expectation::Usual(0.0)));
    let read = |paths: &[PathBuf]| -> Result<Vec<Record>> {
        paths.iter().map(|path| files::read_record(path, &format)).collect()
    };
    let (fit, check) = (read(&arguments.fit)?, read(&arguments.check)?);
    refuse_existing(arguments)?;
    let task = Task {
        model: &model,
        model_name: &arguments.model,
        fit,
        check,
        reference: read(&arguments.reference)?,
        time_limit: arguments.time_limit,
        command: invocation.command.clone(),
        origin: Origin { model: files::describe_model(&arguments.model), invocation: invocation.clone() },
        template: &template::read(arguments.from.as_deref())?,
        date: arguments.date.clone(),
    };
    let reading_s = OnceLock::new();
    let account = workflow::run(task, &|step| {
        let reading_s = *reading_s.get_or_init(|| began.elapsed().as_secs_f64());
        let expectation = match step {
            Step::Explained(share) => return progress.share(share),
            Step::Explain => Expectation::shares(arguments.time_limit),
            Step::Measure | Step::Describe => Expectation::Usual(MEASUREMENT_OF_READING * reading_s),
        };
        progress.step(words(step), expectation);
    })?;
    files::write_folder(&arguments.output, &files(&account)?, arguments.force)?;
    Ok(account)
}

fn seconds(text: &str) -> std::result::Result<Duration, String> {
    let value = text.parse().map_err(|_| "seconds from 0 on are needed".to_owned())?;
    Duration::try_from_secs_f64(value).map_err(|_| "seconds from 0 on are needed".to_owned())
}

/// Usual ratio of the time for stepping both FMUs through the records to that for reading and checking them.
const MEASUREMENT_OF_READING: f64 = 2.0;

fn words(step: Step) -> &'static str {
    match step {
        Step::Explain | Step::Explained(_) => "explaining the records",
        Step::Measure => "measuring the difference on the FMUs",
        Step::Describe => "writing the report",
    }
}

/// Checked before the work.
fn refuse_existing(arguments: &Arguments) -> Result<()> {
    let there = NAMES.iter().map(|name| arguments.output.join(name)).find(|path| path.exists());
    match there.filter(|_| !arguments.force) {
        Some(path) => Err(Error::new("output file", "an existing file", "a new or empty folder")
            .remedy("give --force to overwrite, or another folder")
            .at(path, None)),
        None => Ok(()),
    }
}
