//! Effects missing in the fitted model of a condition: [`crate::workflow`] on its records.

use std::path::Path;

use actuator_fmu::{error::Result, parameters::Model};
use fmu_build::Archive;
use identification::signal::record::Record;

use super::{
    condition::MOST_JOINT_SAMPLES,
    manifest::{Entry, Manifest, in_its_words},
    outcome::{ConditionOutcome, Missing, MissingEffect, MissingParameter, RecordOutcome},
    store,
};
use crate::{
    files,
    invocation::Invocation,
    report::diagnosis::files::files as account_files,
    workflow::{self, Task, account::Origin},
};

/// Folder and inputs of the diagnoses, and the command line.
pub(super) struct Place<'a> {
    pub folder: &'a Path,
    pub template: &'a Archive,
    pub force: bool,
    pub invocation: &'a Invocation,
}

/// Diagnoses every condition that has a model, one after another: each uses all cores.
pub(super) fn find(
    manifest: &Manifest,
    records: &[RecordOutcome],
    conditions: &mut [ConditionOutcome],
    place: &Place<'_>,
    advance: &dyn Fn(),
) {
    for outcome in conditions {
        let model = outcome.result.as_ref().and_then(|result| result.estimate.model());
        if let Some(model) = model {
            let own = manifest.records.iter().zip(records).filter(|(_, record)| record.condition == outcome.condition);
            let mut own: Vec<(&Entry, &str, usize)> = own
                .filter_map(|(entry, record)| {
                    record.result.as_ref().map(|result| (entry, result.sha256.as_str(), result.samples))
                })
                .collect();
            own.sort_by_key(|(entry, ..)| &entry.name); // results must not depend on the order of the manifest
            let name = outcome.condition.to_string();
            match of_records(&model, &name, &own, place) {
                Ok(missing) => outcome.missing = Some(missing),
                Err(error) => outcome.missing_failure = Some(in_its_words(&error.to_string())),
            }
        }
        advance();
    }
}

/// The diagnosis of as many records as can be fitted together, or the stored one of an earlier run.
fn of_records(
    model: &Model,
    model_name: &str,
    records: &[(&Entry, &str, usize)],
    place: &Place<'_>,
) -> Result<Missing> {
    let path = &place.folder.join("diagnoses").join(format!("{model_name}.json"));
    let mut samples = 0;
    let together = records.iter().take_while(|(_, _, of)| {
        samples += of;
        samples <= MOST_JOINT_SAMPLES
    });
    let count = together.count().max(1);
    let chosen = &records[..count.min(records.len())];
    let hashes: Vec<&str> = chosen.iter().map(|(_, sha256, _)| *sha256).collect();
    let formats: Vec<String> = chosen.iter().map(|(entry, ..)| format!("{:?}", entry.format)).collect();
    let key = store::Key::new(store::text_sha256(&hashes.join(" ")), &format!("{formats:?} {:?}", model.base));
    if let Some(missing) = store::read(path, &key).filter(|_| !place.force) {
        return Ok(missing);
    }
    let read = chosen.iter().map(|(entry, ..)| files::read_record(&entry.file, &entry.format));
    let task = Task {
        model,
        model_name,
        fit: read.collect::<Result<Vec<Record>>>()?,
        check: Vec::new(),
        reference: Vec::new(),
        time_limit: None,
        command: Vec::new(),
        origin: Origin {
            model: format!("models/{model_name}.toml beside the folder of the diagnoses"),
            invocation: place.invocation.clone(),
        },
        template: place.template,
        date: None,
    };
    let account = workflow::run(task, &|_| {})?;
    // In a separate folder beside the summary, which is written last: a result with a summary is complete.
    files::write_folder(&path.with_extension(""), &account_files(&account)?, true)?;
    let diagnosis = account.diagnosis;
    let effects = diagnosis.findings.iter().map(|finding| MissingEffect {
        name: finding.name.to_owned(),
        parameters: finding.parameters.iter().map(MissingParameter::of).collect(),
        alternatives: finding.alternatives.clone(),
    });
    let missing = Missing {
        verdict: diagnosis.verdict,
        effects: effects.collect(),
        noise_rms: diagnosis.noise.rms,
        records: chosen.len(),
    };
    store::write(path, &key, &missing)?;
    Ok(missing)
}
