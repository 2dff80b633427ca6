//! A whole test campaign: records under many conditions to responses, fits and comparisons.
//!
//! 1. Every record of the [`Manifest`] is analysed alone ([`record`]), on all cores. One that fails is listed with its message; the
//!    rest goes on.
//! 2. The records of one condition are fitted together, or their fits combined where there are too many ([`condition`]).
//! 3. What the model of a condition misses is looked for in its records ([`missing`]).
//! 4. Conditions are compared by wear and by load ([`identification::compare`]), with what the fits are unsure of.
//!
//! Each result is written when it is there, in one piece, with hashes of what it was made from ([`store`]): a run that was
//! interrupted goes on where it was, and a changed record or option makes anew only what depends on it.

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

/// What became of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Campaign {
    /// Its name.
    pub name: String,
    /// In the order of the manifest.
    pub records: Vec<RecordOutcome>,
    /// By surface, stage and load case.
    pub conditions: Vec<ConditionOutcome>,
    /// The conditions against each other.
    pub comparison: Comparison,
    /// Estimates against known parameters, where the campaign is generated.
    pub truth: Vec<truth::Deviation>,
}

/// How a campaign is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Make everything anew, and write over what is in the folder.
    pub force: bool,
    /// Look for what the fitted models miss.
    pub diagnose: bool,
}

/// Copy of the manifest in the folder of the results; it marks the folder as that of a campaign.
const MANIFEST_COPY: &str = "manifest.toml";

/// Runs a campaign, or goes on with one, and leaves its results in a folder. The pages of its diagnoses say how the program was called.
///
/// # Errors
/// A folder that holds something else, unless `force` is true; no default FMU where models are diagnosed; the file system's own. A
/// record that fails is no error.
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

/// Refuses a folder with other things in it, so that nothing is written over. Removes what a killed run was writing.
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
        // Named by its file, the copy would be called after itself.
        Ok(before) if before.name != manifest.name && before.name != "manifest" => {
            refuse(format!("the campaign `{}`", before.name))
        }
        Ok(_) => Ok(()),
    }
}

/// In a folder and those below it. What cannot be removed disturbs nobody.
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
