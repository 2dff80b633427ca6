//! The records of one condition together.
//!
//! Up to [`MOST_JOINT_SAMPLES`] samples they are fitted jointly, with common parameters. Beyond, that would take too much memory and hours,
//! and their fits are combined instead ([`super::combine`]). The agreement of the records is stated in both cases.

use std::path::Path;

use rayon::prelude::*;

use super::{
    combine::combined,
    manifest::{Entry, Manifest, in_its_words},
    outcome::{ConditionOutcome, ConditionResult, How, RecordOutcome, RecordResult},
    store,
    summary::FitSummary,
};
use crate::files;
use actuator_fmu::{
    error::{Error, Result},
    parameters::{Identity, LoadCase, Model, Provenance, Stage, Surface, find},
};
use identification::{
    compare::{Condition, Difference, Set},
    estimate::{Settings, fit},
    inspect,
};

/// Ten records of 100 s at 200 samples/s: a second or two of work.
pub const MOST_JOINT_SAMPLES: usize = 200_000;

/// All conditions of the records, by surface, stage and load case: the report's in its order, then others in order of occurrence.
pub(super) fn outcomes(
    manifest: &Manifest,
    records: &[RecordOutcome],
    folder: &Path,
    force: bool,
) -> Vec<ConditionOutcome> {
    let mut conditions = manifest.conditions();
    let place = |word: &str, known: &[&str], first: usize| {
        known.iter().position(|name| *name == word).unwrap_or(known.len() + first)
    };
    let met = conditions.clone();
    let first = |of: &dyn Fn(&Condition) -> bool| met.iter().position(|condition| of(condition)).unwrap_or(0);
    conditions.sort_by_key(|condition| {
        let surface = first(&|other| other.surface == condition.surface);
        let stage = first(&|other| other.stage == condition.stage);
        let load_case = LoadCase::ALL.iter().position(|load_case| *load_case == condition.load_case);
        (place(&condition.surface, Surface::NAMES, surface), load_case, place(&condition.stage, Stage::NAMES, stage))
    });
    let outcome = |condition: &Condition| {
        let own = manifest.records.iter().zip(records).filter(|(_, record)| record.condition == *condition);
        let mut analysed: Vec<Analysed> =
            own.filter_map(|(entry, outcome)| Some(Analysed { entry, result: outcome.result.as_ref()? })).collect();
        // Sums depend on the order of their terms; results must not depend on that of the manifest.
        analysed.sort_by_key(|record| &record.entry.name);
        let result = outcome_of(condition, &analysed, &manifest.settings, folder, force);
        ConditionOutcome {
            condition: condition.clone(),
            failure: result.as_ref().err().map(|error| in_its_words(&error.to_string())),
            result: result.ok(),
            missing: None,
            missing_failure: None,
        }
    };
    conditions.into_par_iter().map(outcome).collect()
}

/// An analysed record.
#[derive(Clone, Copy)]
struct Analysed<'a> {
    entry: &'a Entry,
    result: &'a RecordResult,
}

fn outcome_of(
    condition: &Condition,
    records: &[Analysed],
    settings: &Settings,
    folder: &Path,
    force: bool,
) -> Result<ConditionResult> {
    let Some(first) = records.first() else {
        return Err(Error::new("records", "none that could be analysed", "one or more"));
    };
    let unit = first.result.fit.unit;
    for record in records {
        record.result.fit.unit.convert(1.0, unit).map_err(|error| error.at(&record.entry.file, None))?;
    }
    let samples = records.iter().map(|record| record.result.samples).sum();
    let fits: Vec<&FitSummary> = records.iter().map(|record| &record.result.fit).collect();
    let (how, estimate) = match records {
        [alone] => (How::Alone, alone.result.fit.clone()),
        several if samples <= MOST_JOINT_SAMPLES => {
            // The records' own fits, combined, are a start close to the minimum.
            let starts = combined(&fits).ok().map(|(start, _)| vec![start.values]);
            let settings = Settings { starts, ..settings.clone() };
            (How::Joint, joint(condition, several, &settings, folder, force)?)
        }
        _ => (How::Combined, combined(&fits)?.0),
    };
    let result = ConditionResult {
        records: records.iter().map(|record| record.entry.name.clone()).collect(),
        samples,
        mach: range(records.iter().filter_map(|record| record.entry.mach)),
        dynamic_pressure_psf: range(records.iter().filter_map(|record| record.entry.dynamic_pressure_psf)),
        how,
        against_table: against_table(condition, &estimate),
        scatter: combined(&fits).ok().and_then(|(_, scatter)| scatter),
        estimate,
    };
    write_model(condition, records, &result, folder)?;
    Ok(result)
}

fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |range: Option<[f64; 2]>, value| {
        Some(range.map_or([value; 2], |[least, greatest]| [least.min(value), greatest.max(value)]))
    })
}

/// One fit of all records, or the stored one of an earlier run.
fn joint(
    condition: &Condition,
    records: &[Analysed],
    settings: &Settings,
    folder: &Path,
    force: bool,
) -> Result<FitSummary> {
    let hashes: Vec<&str> = records.iter().map(|record| record.result.sha256.as_str()).collect();
    let formats: Vec<String> = records.iter().map(|record| format!("{:?}", record.entry.format)).collect();
    let key = store::Key::new(store::text_sha256(&hashes.join(" ")), &format!("{formats:?} {settings:?}"));
    let path = folder.join("conditions").join(format!("{condition}.json"));
    if let Some(summary) = store::read(&path, &key).filter(|_| !force) {
        return Ok(summary);
    }
    let unit = records[0].entry.format.unit;
    let read = |record: &Analysed| files::read_record(&record.entry.file, &record.entry.format)?.in_unit(unit);
    let read_records = records.iter().map(read).collect::<Result<Vec<_>>>()?;
    let segments: Vec<_> = read_records.into_iter().flat_map(inspect::segments).collect();
    let mut summary = FitSummary::of(&fit(&segments, settings)?);
    if let Some(other) = records.iter().map(|record| record.entry.format.unit).find(|other| *other != unit) {
        summary.notes.push(format!("records in {other} were converted to {unit}"));
    }
    store::write(&path, &key, &summary)?;
    Ok(summary)
}

fn against_table(condition: &Condition, estimate: &FitSummary) -> Option<Difference> {
    let table = find(condition.set_name()?).ok()?;
    let tabulated = Set::new(table.name.to_string(), Model::from_set(table));
    Some(Difference::between(&tabulated, &estimate.set("this campaign")?))
}

/// Models of the conditions, as files for other commands.
fn write_model(condition: &Condition, records: &[Analysed], result: &ConditionResult, folder: &Path) -> Result<()> {
    let Some(model) = result.estimate.model() else { return Ok(()) };
    let known = match result.estimate.pole_above {
        Some(bound) => format!("; p is not identifiable, above {bound:.0} 1/s (95 %)"),
        None => String::new(),
    };
    let provenance = Provenance {
        records: records.iter().map(|record| record.entry.file.display().to_string()).collect(),
        hashes: records.iter().map(|record| record.result.sha256.clone()).collect(),
        method: Some(format!("campaign, records {}{known}", result.how.word())),
        ..Provenance::default()
    };
    let identity = Identity { name: Some(condition.to_string()), ..model.identity };
    let text = Model { identity, provenance, ..model }.to_toml()?;
    files::write_new(&folder.join("models").join(format!("{condition}.toml")), text.as_bytes(), true)
}
