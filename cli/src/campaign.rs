//! A whole test campaign: records under many conditions to responses, fits and comparisons.
//!
//! 1. Every record of the [`Manifest`] is analysed alone ([`record`]), on all cores. One that fails is listed with its message; the others
//!    continue.
//! 2. The records of one condition are fitted together, or their fits combined if there are too many ([`condition`]).
//! 3. The records of each condition are searched for effects missing in its model ([`missing`]).
//! 4. Conditions are compared by wear and by load ([`identification::compare`]), with the uncertainty of the fits.
//!
//! Each result is written on completion, atomically, with hashes of its inputs (`store`): an interrupted run is resumed, and a changed
//! record or option recomputes only what depends on it.

pub mod combine;
pub mod condition;
pub mod differences;
pub mod generate;
pub mod manifest;
pub mod missing;
pub mod outcome;
pub mod record;
mod store;
pub mod summary;
pub mod truth;

use std::{
    path::Path,
    sync::atomic::{AtomicUsize, Ordering},
};

use rayon::prelude::*;
use serde::Serialize;

use crate::{files, invocation::Invocation, template};
use actuator_fmu::error::{Error, Result};
use identification::compare::{Comparison, Set};
pub use manifest::{Entry, Manifest};
pub use outcome::{ConditionOutcome, ConditionResult, How, Missing, Progress, RecordOutcome, RecordResult};
pub use summary::FitSummary;

/// Result of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Campaign {
    /// Its name.
    pub name: String,
    /// In the order of the manifest.
    pub records: Vec<RecordOutcome>,
    /// By surface, stage and load case.
    pub conditions: Vec<ConditionOutcome>,
    /// Comparison of the conditions.
    pub comparison: Comparison,
    /// Estimates against known parameters, if the campaign is generated.
    pub truth: Vec<truth::Deviation>,
}

/// How a campaign is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Recompute everything, and overwrite existing results in the folder.
    pub force: bool,
    /// Search for effects missing in the fitted models.
    pub diagnose: bool,
}

/// Copy of the manifest in the results folder; it marks the folder as that of a campaign.
const MANIFEST_COPY: &str = "manifest.toml";

/// Runs or resumes a campaign, and writes its results to a folder. The pages of its diagnoses state the command line.
///
/// # Errors
/// A folder with other content, unless `force` is true; no default FMU if models are diagnosed; those of the file system. A record that
/// fails is not an error.
pub fn run(
    manifest: &Manifest,
    folder: &Path,
    options: Options,
    invocation: &Invocation,
    progress: Progress,
) -> Result<Campaign> {
    let Options { force, diagnose } = options;
    let template = diagnose.then(|| template::read(None)).transpose()?;
    claim(folder, manifest, force)?;
    files::write_new(&folder.join(MANIFEST_COPY), manifest.text.as_bytes(), true)?;
    let all = manifest.records.len() + if diagnose { manifest.conditions().len() } else { 0 };
    let done = AtomicUsize::new(0);
    let advance = || progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);
    let records: Vec<RecordOutcome> = manifest
        .records
        .par_iter()
        .map(|entry| {
            let outcome = record::outcome(entry, &manifest.settings, folder, force);
            advance();
            outcome
        })
        .collect();
    let mut conditions = condition::outcomes(manifest, &records, folder, force);
    if let Some(template) = template {
        let place = missing::Place { folder, template: &template, force, invocation };
        missing::find(manifest, &records, &mut conditions, &place, &advance);
    }
    let comparison = compare(&manifest.name, &conditions);
    let truth = match &manifest.truth {
        Some(path) => truth::deviations(path, &conditions)?,
        None => Vec::new(),
    };
    Ok(Campaign { name: manifest.name.clone(), records, conditions, comparison, truth })
}

/// Refuses a folder with other content, so that nothing is overwritten. Removes temporary files of a killed run.
fn claim(folder: &Path, manifest: &Manifest, force: bool) -> Result<()> {
    remove_temporary_files(folder);
    let empty = std::fs::read_dir(folder).map_or(true, |mut entries| entries.next().is_none());
    if empty || force {
        return Ok(());
    }
    let refuse = |found: String| {
        Err(Error::new("output folder", found, "a new or empty folder, or that of this campaign")
            .remedy("give another folder, or --force to overwrite")
            .at(folder, None))
    };
    match Manifest::read(&folder.join(MANIFEST_COPY)) {
        Err(_) => refuse("files of something else".into()),
        // Otherwise the copy, named by its file, would have its own name.
        Ok(before) if before.name != manifest.name && before.name != "manifest" => {
            refuse(format!("the campaign `{}`", before.name))
        }
        Ok(_) => Ok(()),
    }
}

/// In a folder and its subfolders. Files that cannot be removed do no harm.
fn remove_temporary_files(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            remove_temporary_files(&entry.path());
        } else if entry.file_name().to_string_lossy().starts_with(fmu_build::TEMPORARY_PREFIX) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

fn compare(name: &str, conditions: &[ConditionOutcome]) -> Comparison {
    let sets = conditions.iter().filter_map(|outcome| {
        let set = outcome.result.as_ref()?.estimate.set(outcome.condition.to_string())?;
        Some(Set { condition: Some(outcome.condition.clone()), ..set })
    });
    Comparison::of(name, sets.collect())
}
