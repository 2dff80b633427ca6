//! The workflow of a diagnosis: records and a model in; verdict, account, model and FMU out.
//!
//! ```text
//! records, model -> divide -> diagnose -> package both models -> step both FMUs -> locate the gap -> Account
//! ```
//!
//! `actuator diagnose`, `demo` and `campaign` call [`run`]; nothing else puts these steps together. What an account says on paper is
//! [`crate::report::diagnosis`].

pub mod account;
mod interpolation;

use std::{
    path::Path,
    time::{Duration, Instant},
};

use actuator_fmu::{
    error::{Error, Result},
    parameters::{Model, PositionUnit},
};
use fmu_build::Archive;
use identification::{
    diagnose::{self, Diagnosis, Division, ROUNDING, RecordTerms, Verdict, location::locate, next_test::next_test},
    inspect::{self, ExpectedGain},
    progress::Done,
    signal::record::{Record, rms},
};

use account::{Account, Origin};

use crate::{
    files::write_new,
    gap::{Measured, measure, measured_response},
    package,
    template::refused,
};

/// What is diagnosed.
pub struct Task<'a> {
    /// The model that the records are compared with.
    pub model: &'a Model,
    /// What the model is called in the provenance of the corrected one: a set name or a file.
    pub model_name: &'a str,
    /// Records to explain.
    pub fit: Vec<Record>,
    /// Records to check the explanation on; without any, a part of the others is held out.
    pub check: Vec<Record>,
    /// Repeats of healthy motion: their scatter is noise.
    pub reference: Vec<Record>,
    /// The default FMU, around whose binary both models are packaged.
    pub template: &'a Archive,
    /// Time after which the search ends with the best so far.
    pub time_limit: Option<Duration>,
    /// The command line that repeats the run.
    pub command: Vec<String>,
    /// What the page says of the given model, and how the program was called.
    pub origin: Origin,
    /// Date to be noted in the corrected model.
    pub date: Option<String>,
}

/// Where a run stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// The records are being explained; a second time where it sounds as if their commands had another interpolation.
    Explain,
    /// This share of the search for an explanation is done.
    Explained(f64),
    /// Both FMUs are being packaged and stepped through the records.
    Measure,
    /// The gap is being located, and the next test designed.
    Describe,
}

/// Diagnoses; `progress` hears of each step as it begins, and of its share.
///
/// # Errors
/// Records that cannot be divided or whose unit is of another kind than the model's; a model that cannot move through them; an FMU that refuses.
pub fn run(mut task: Task<'_>, progress: &(dyn Fn(Step) + Sync)) -> Result<Account> {
    let (fit, check, copies) = inspect::without_copies(task.fit, task.check);
    (task.fit, task.check) = (fit, check);
    let mut warnings = admit(&task)?;
    warnings.extend(copies);
    let (fit, converted) = in_unit(task.fit, task.model.unit())?;
    let (check, also_converted) = in_unit(task.check, task.model.unit())?;
    let Division { fit, check, note } = diagnose::divide(fit, check)?;
    let (fit, left_out) = prepared(fit);
    let (check, also_left_out) = prepared(check);
    let (reference, _) = in_unit(task.reference, task.model.unit())?;
    let began = Instant::now();
    let explain = |fit: &[Record], check: &[Record], reference: &[Record]| {
        let left = task.time_limit.map(|limit| limit.saturating_sub(began.elapsed()));
        progress(Step::Explain);
        let share = |done: Done| progress(Step::Explained(done.share));
        diagnose::diagnose_reporting(task.model, fit, check, reference, left, Some(&share))
    };
    let mut diagnosis = explain(&fit, &check, &reference)?;
    let (mut fit, mut check) = (fit, check);
    let declared = [fit.as_slice(), &check].concat();
    if let Some(other) = interpolation::suspected(&diagnosis, task.model, &declared) {
        let [other_fit, other_check, reference] =
            [&fit, &check, &reference].map(|records| interpolation::read(records, other));
        let explained = explain(&other_fit, &other_check, &reference)?;
        let as_other = [other_fit.as_slice(), &other_check].concat();
        if interpolation::is_simpler((&explained, &as_other), (&diagnosis, &declared)) {
            (fit, check, diagnosis) = (other_fit, other_check, explained);
            warnings.push(interpolation::warning(other));
        }
    }
    note_origin(&mut diagnosis, &fit, task.model_name, task.date);

    progress(Step::Measure);
    let work = tempfile::tempdir()
        .map_err(|error| Error::new("temporary folder", error.to_string(), "a place to write to"))?;
    let (before_fmu, after_fmu) = (work.path().join("before.fmu"), work.path().join("after.fmu"));
    let measured = measured_response(&fit);
    let nothing = vec![Vec::new(); fit.len() + check.len()];
    let packaged_and_measured =
        |diagnosis: &Diagnosis, model: &Model, fmu: &Path, starts: &[RecordTerms]| -> Result<Measured> {
            let packaged = package::for_model(task.template.clone(), model)?.to_bytes().map_err(refused)?;
            write_new(fmu, &packaged, true)?;
            measure(fmu, model, &fit, &check, diagnosis, starts, measured.as_ref())
        };
    let (before, after) = rayon::join(
        || packaged_and_measured(&diagnosis, task.model, &before_fmu, &nothing),
        || packaged_and_measured(&diagnosis, &diagnosis.after, &after_fmu, &diagnosis.record_terms),
    );
    let (before, mut after) = (before?, after?);
    let leaves_rounding_out = grown_on(&before, &after, &check).is_some() && diagnosis.leave_rounding_out();
    if leaves_rounding_out {
        after = packaged_and_measured(&diagnosis, &diagnosis.after, &after_fmu, &diagnosis.record_terms)?;
    }
    let objection = if diagnosis.findings.is_empty() {
        None
    } else if changes_nothing(&before, &after) {
        Some("it does not change the simulated position on any record".to_owned())
    } else {
        grown_on(&before, &after, &check)
            .map(|record| format!("it increases the residual on the unseen record {record}"))
    };
    if let Some(objection) = objection {
        diagnosis.withdraw(&objection, task.model, leaves_rounding_out);
        after = packaged_and_measured(&diagnosis, task.model, &after_fmu, &nothing)?;
    }
    let fmu = std::fs::read(&after_fmu)
        .map_err(|error| Error::new("FMU", error.to_string(), "a readable file").at(&after_fmu, None))?;

    progress(Step::Describe);
    let records: Vec<Record> = fit.iter().chain(&check).cloned().collect();
    let locations = locate(&diagnosis.best, &records, &diagnosis.residuals);
    let next_test = if diagnosis.verdict == Verdict::Ambiguous {
        let models: Vec<Model> = std::iter::once(&diagnosis.after).chain(&diagnosis.rivals).cloned().collect();
        next_test(&models, &fit, diagnosis.noise.rms)
    } else {
        None
    };
    let no_test = diagnosis.verdict == Verdict::Ambiguous && next_test.is_none();
    let no_test = no_test.then(|| {
        "no command within the amplitudes and rates of the records discriminates between the explanations: faster or larger motion may".to_owned()
    });
    let notes = converted
        .or(also_converted)
        .into_iter()
        .chain(note)
        .chain(left_out)
        .chain(also_left_out)
        .chain(diagnosis.notes.iter().cloned())
        .chain(no_test)
        .collect();
    Ok(Account {
        diagnosis,
        fit,
        check,
        before,
        after,
        measured,
        locations,
        next_test,
        notes,
        warnings,
        command: task.command,
        origin: task.origin,
        fmu,
    })
}

/// Whether what was found is never met: a limit beyond all motion.
fn changes_nothing(before: &Measured, after: &Measured) -> bool {
    let mut pairs = before.residuals.iter().zip(&after.residuals);
    pairs.all(|(before, after)| {
        let change: Vec<f64> = before.iter().zip(after).map(|(before, after)| after - before).collect();
        rms(&change) <= ROUNDING * rms(before)
    })
}

/// The first check record on which the gap is larger than before, its segments taken together. A name never widens it.
fn grown_on(before: &Measured, after: &Measured, check: &[Record]) -> Option<String> {
    let fitted = before.residuals.len() - check.len();
    let of_record = |measured: &Measured, name: &str| {
        let unseen = measured.residuals[fitted..].iter().zip(check);
        let own = unseen.filter(|(_, record)| inspect::whole_record(record.source()) == name);
        rms(&own.flat_map(|(residual, _)| residual).copied().collect::<Vec<f64>>())
    };
    let mut names = check.iter().map(|record| inspect::whole_record(record.source()));
    names.find(|name| of_record(after, name) > (1.0 + ROUNDING) * of_record(before, name))
}

/// Records cut at their gaps, and without what their sensors did by themselves; the latter in words.
fn prepared(records: Vec<Record>) -> (Vec<Record>, Vec<String>) {
    let segments = records.into_iter().flat_map(inspect::segments);
    let (records, words): (Vec<Record>, Vec<Vec<String>>) = segments.map(inspect::without_sensor_faults).unzip();
    (records, words.concat())
}

/// Refuses records that are no response to their command, or one in another unit or of another sign than the model's.
fn admit(task: &Task<'_>) -> Result<Vec<String>> {
    let records: Vec<&Record> = task.fit.iter().chain(&task.check).chain(&task.reference).collect();
    inspect::admit(&records, ExpectedGain::Like(task.model.base.k()))
}

/// Records in the unit of a model, and what was converted in words.
fn in_unit(records: Vec<Record>, unit: PositionUnit) -> Result<(Vec<Record>, Option<String>)> {
    let other = records.iter().map(Record::unit).find(|other| *other != unit);
    let note = other.map(|other| format!("records in {other} were converted to {unit}, the unit of the model"));
    Ok((records.into_iter().map(|record| record.in_unit(unit)).collect::<Result<_>>()?, note))
}

fn note_origin(diagnosis: &mut Diagnosis, fit: &[Record], model_name: &str, date: Option<String>) {
    if diagnosis.findings.is_empty() {
        return;
    }
    let names: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.name).collect();
    let provenance = &mut diagnosis.after.provenance;
    provenance.records = fit.iter().map(|record| record.source().display().to_string()).collect();
    provenance.hashes = fit.iter().map(|record| record.sha256().to_owned()).collect();
    provenance.method = Some(format!("diagnosis from {model_name}: {}", names.join(", ")));
    provenance.date = date;
}
