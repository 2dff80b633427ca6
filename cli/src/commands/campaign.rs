//! `actuator campaign`

use crate::output;
use std::path::PathBuf;

use crate::{
    campaign::{self, Manifest, Options, differences::Differences},
    files,
    invocation::Invocation,
    progress::{
        Progress,
        estimate::{Expectation, Stage},
    },
    report::campaign as report,
};
use actuator_fmu::{Error, Result};

/// Analyse a whole test campaign: responses and fits of all records in a manifest, missing effects, wear and load
#[derive(clap::Args)]
#[command(
    after_help = "MANIFEST is TOML; paths in it are relative to it:\n\n  [campaign]\n  name = \"Bench, spring\"\n\n  [[record]]\n  \
file = \"records/te-early.csv\"\n  surface = \"trailing_edge\"   # or any word\n  stage = \"early\"             # or any word\n  \
load_case = \"unloaded\"      # or \"loaded\"\n  mach = 0.0                  # optional, as is all that follows\n  \
name = \"te-early\"           # of its results; else made of the path of the file\n  \
dynamic_pressure_psf = 0.0\n  unit = \"rad\"\n  \
time_unit = \"ms\"            # s, ms or us\n  hold = false                # the command moves linearly between samples\n  \
columns = { time = \"t_s\", command = \"cmd\", position = \"pos\" }\n\n\
A record that fails is listed and the rest goes on. Results are kept per record: a run that was interrupted, or whose manifest has \
grown, goes on where it was.\n\n\
Examples:\n  actuator generate-campaign -o bact --seed 7\n  actuator campaign bact/manifest.toml -o bact-results"
)]
pub struct Arguments {
    /// Manifest of the records
    manifest: PathBuf,
    /// Write report.html, campaign.json, models/ and the results of each record here
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Recompute everything, and overwrite files in DIR
    #[arg(long)]
    force: bool,
    /// Do not search for effects missing in the fitted models, which takes longer than everything else
    #[arg(long)]
    no_diagnosis: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Duration of a diagnosis of two records relative to the analysis of one, both on all cores.
const DIAGNOSIS_OF_RECORD: f64 = 15.0;

pub fn run(arguments: &Arguments, invocation: &Invocation) -> Result<()> {
    files::refuse_file(&arguments.output)?;
    let manifest = Manifest::read(&arguments.manifest)?;
    let options = Options { force: arguments.force, diagnose: !arguments.no_diagnosis };
    let records = manifest.records.len();
    let conditions = if options.diagnose { manifest.conditions().len() } else { 0 };
    let stages = vec![Stage::new(records as u64, 1.0), Stage::new(conditions as u64, DIAGNOSIS_OF_RECORD)];
    let progress = Progress::new("analysing the records", Expectation::Stages(stages));
    let campaign = campaign::run(&manifest, &arguments.output, options, invocation, &|done, of| {
        let words = if done < records { "records analysed" } else { "records and conditions done" };
        progress.done(done as u64, format!("{done} of {of} {words}"));
    })?;
    drop(progress);
    let json = serde_json::to_string_pretty(&campaign)
        .map_err(|error| Error::new("JSON", error.to_string(), "values that JSON can hold"))?;
    files::write_new(&arguments.output.join("campaign.json"), format!("{json}\n").as_bytes(), true)?;
    let page = arguments.output.join("report.html");
    let conditions = campaign.conditions.iter();
    let differences: Vec<_> = conditions.map(|outcome| Differences::of(outcome, &arguments.output)).collect();
    files::write_new(&page, report::html(&campaign, &differences, invocation).as_bytes(), true)?;
    if arguments.json {
        output::print(&format!("{json}\n"))?;
    } else {
        output::print(&format!("{}open {}\n", report::text(&campaign), page.display()))?;
    }
    if campaign.records.iter().any(|record| record.result.is_some()) {
        return Ok(());
    }
    Err(Error::new("records of the campaign", "none that could be analysed", "one or more")
        .remedy("see the messages above")
        .at(&arguments.manifest, None))
}
