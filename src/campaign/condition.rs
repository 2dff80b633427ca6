//! The records of one condition together.
//!
//! Up to [`MOST_JOINT_SAMPLES`] samples they are fitted as one, sharing the parameters. Beyond, that would take memory and hours,
//! and their fits are combined instead, x = (ln k, ln ω, ln ζ) with the inverse covariances as weights:
//!
//! ```text
//! C = (Σ Cᵢ⁻¹)⁻¹,   x = C Σ Cᵢ⁻¹ xᵢ,   s² = Σ (xᵢ - x)' Cᵢ⁻¹ (xᵢ - x) / (3 (n - 1))
//! ```
//!
//! which for long records is the same thing. s is Birge's ratio: 1 where records differ as their standard errors say. Above 1 they
//! differ by more (the actuator was not the same, or the model is not right), and C is multiplied by s² (R. T. Birge, Phys. Rev.
//! 40, 1932).
//!
//! What the records cannot tell of the lag 1/p makes ω and ζ unsure in the same way in all of them and does not average out. Where p is
//! not found, the stated standard errors are therefore those of one record. Responses hardly depend on it, since ω and ζ make up for
//! the lag; their errors follow from the covariances at one lag, which do average out.

use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{ConditionOutcome, Entry, FitSummary, Manifest, RecordOutcome, RecordResult, store, summary::IDENTIFIABLE};
use crate::{
    compare::{Condition, Difference, Set},
    error::{Error, Result},
    estimate::{Settings, fit},
    files,
    parameters::{LoadCase, Model, Provenance, Stage, Surface, find},
    signal::record::Record,
};

/// Ten records of 100 s at 200 samples/s: a second or two of work.
pub const MOST_JOINT_SAMPLES: usize = 200_000;

/// How the parameters of a condition were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum How {
    /// One record.
    Alone,
    /// All records fitted as one.
    Joint,
    /// Fits of the records combined.
    Combined,
}

impl How {
    /// In a word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Alone => "alone",
            Self::Joint => "joint",
            Self::Combined => "combined",
        }
    }
}

/// What the records of one condition give.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConditionResult {
    /// Names of the records behind it.
    pub records: Vec<String>,
    /// Their samples.
    pub samples: usize,
    /// Least and greatest Mach number.
    pub mach: Option<[f64; 2]>,
    /// Least and greatest dynamic pressure [psf].
    pub dynamic_pressure_psf: Option<[f64; 2]>,
    /// How the parameters were found.
    pub how: How,
    /// The parameters.
    pub estimate: FitSummary,
    /// Birge's ratio of the records' own fits; none for one record, or where fits state no errors.
    pub scatter: Option<f64>,
    /// Against the set of the tables for this condition, if it is one of the report's.
    pub against_table: Option<Difference>,
}

/// Every condition that a record has, by surface, stage and load case: the report's in its order, then others as they come.
pub(super) fn outcomes(
    manifest: &Manifest,
    records: &[RecordOutcome],
    folder: &Path,
    force: bool,
) -> Vec<ConditionOutcome> {
    let mut conditions: Vec<&Condition> = Vec::new();
    for record in records {
        if !conditions.contains(&&record.condition) {
            conditions.push(&record.condition);
        }
    }
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
        let analysed: Vec<Analysed> =
            own.filter_map(|(entry, outcome)| Some(Analysed { entry, result: outcome.result.as_ref()? })).collect();
        let result = outcome_of(condition, &analysed, &manifest.settings, folder, force);
        ConditionOutcome {
            condition: condition.clone(),
            failure: result.as_ref().err().map(ToString::to_string),
            result: result.ok(),
        }
    };
    conditions.into_par_iter().map(outcome).collect()
}

/// A record that was analysed.
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
    if let Some(other) = records.iter().find(|record| record.result.unit != first.result.unit) {
        let found = format!("{} and {}", first.result.unit, other.result.unit);
        return Err(Error::new("units of the records", found, "one unit").at(&other.entry.file, None));
    }
    let samples = records.iter().map(|record| record.result.samples).sum();
    let fits: Vec<&FitSummary> = records.iter().map(|record| &record.result.fit).collect();
    let (how, estimate) = match records {
        [alone] => (How::Alone, alone.result.fit.clone()),
        several if samples <= MOST_JOINT_SAMPLES => {
            // The records' own fits, combined, are a start next to the end.
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

/// One fit of all records, or that of an earlier run.
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
    let read = |record: &Analysed| Record::read(&record.entry.file, &record.entry.format);
    let summary = FitSummary::of(&fit(&records.iter().map(read).collect::<Result<Vec<_>>>()?, settings)?);
    store::write(&path, &key, &summary)?;
    Ok(summary)
}

/// The fits combined, and Birge's ratio. Fits that state no covariance count alike, and what they scatter by becomes the standard
/// error.
///
/// # Errors
/// No fit; covariances that cannot be inverted.
pub fn combined(fits: &[&FitSummary]) -> Result<(FitSummary, Option<f64>)> {
    let Some(first) = fits.first() else { return Err(Error::new("fits", "none", "one or more")) };
    let stated: Option<Vec<Matrix3<f64>>> =
        fits.iter().map(|fit| fit.covariance_of_all_lags()?.try_inverse()).collect();
    let weights = stated.clone().unwrap_or_else(|| vec![Matrix3::identity(); fits.len()]);
    let total: Matrix3<f64> = weights.iter().sum();
    let covariance = total
        .try_inverse()
        .ok_or_else(|| Error::new("covariance of the fits", "singular", "parameters that the records can tell"))?;
    let sum: Vector3<f64> = fits.iter().zip(&weights).map(|(fit, weight)| weight * fit.logarithms()).sum();
    let mean = covariance * sum;
    let squares: f64 = fits
        .iter()
        .zip(&weights)
        .map(|(fit, weight)| {
            let away = fit.logarithms() - mean;
            away.dot(&(weight * away))
        })
        .sum();
    // Three numbers from each record, three of them used up by the mean.
    let freedom = 3.0 * (fits.len() as f64 - 1.0);
    let birge = (freedom > 0.0).then(|| (squares / freedom).sqrt());
    let excess = birge.unwrap_or(1.0).max(1.0).powi(2);
    let shared = if fits.iter().any(|fit| fit.pole_above.is_some()) { fits.len() as f64 } else { 1.0 };
    let widened = match (&stated, birge) {
        (Some(_), _) => covariance * shared.max(excess),
        (None, Some(birge)) => covariance * birge.powi(2),
        (None, None) => covariance * f64::NAN,
    };
    let at_one_lag: Option<Matrix3<f64>> =
        fits.iter().map(|fit| fit.covariance_at_one_lag()?.try_inverse()).sum::<Option<Matrix3<f64>>>();
    let at_one_lag = at_one_lag.and_then(|total| total.try_inverse()).map_or(widened, |covariance| covariance * excess);
    let mut values = first.values;
    let mut std_errors = [None; 4];
    for (place, index) in IDENTIFIABLE.into_iter().enumerate() {
        values[index] = mean[place].exp().copysign(first.values[index]);
        let error = widened[(place, place)].sqrt() * values[index].abs();
        std_errors[index] = error.is_finite().then_some(error);
    }
    // Each record's bound holds with 95 %; the one most records agree on is the middle one.
    let mut bounds: Vec<f64> = fits.iter().filter_map(|fit| fit.pole_above).collect();
    bounds.sort_unstable_by(f64::total_cmp);
    let squares_mean = fits.iter().map(|fit| fit.residual_rms * fit.residual_rms).sum::<f64>() / fits.len() as f64;
    let third = fits.iter().filter(|fit| fit.order == 3).count();
    let unidentified = fits.iter().flat_map(|fit| fit.not_identifiable.clone());
    let summary = FitSummary {
        order: if 2 * third > fits.len() { 3 } else { 2 },
        values,
        std_errors,
        covariance: std_errors[0].map(|_| without_lag(&at_one_lag)),
        pole_above: bounds.get(bounds.len() / 2).copied(),
        delay_s: fits.iter().map(|fit| fit.delay_s).sum::<f64>() / fits.len() as f64,
        converged: fits.iter().all(|fit| fit.converged),
        ending: format!(
            "{} fits combined, {} of them converged",
            fits.len(),
            fits.iter().filter(|fit| fit.converged).count()
        ),
        at_bound: unique(fits.iter().flat_map(|fit| fit.at_bound.clone())),
        not_identifiable: unique(unidentified),
        residual_rms: squares_mean.sqrt(),
        notes: Vec::new(),
    };
    Ok((summary, birge.filter(|_| stated.is_some())))
}

fn without_lag(covariance: &Matrix3<f64>) -> [[f64; 4]; 4] {
    let at = |row: usize, column: usize| if row < 3 && column < 3 { covariance[(row, column)] } else { 0.0 };
    std::array::from_fn(|row| std::array::from_fn(|column| at(row, column)))
}

fn unique(texts: impl Iterator<Item = String>) -> Vec<String> {
    texts.fold(Vec::new(), |mut unique, text| {
        if !unique.contains(&text) {
            unique.push(text);
        }
        unique
    })
}

fn against_table(condition: &Condition, estimate: &FitSummary) -> Option<Difference> {
    let table = find(condition.set_name()?).ok()?;
    let tabulated = Set::new(table.name.to_string(), Model::from_set(table));
    let estimated = Set { covariance: estimate.covariance, ..Set::new("this campaign", estimate.model()?) };
    Some(Difference::between(&tabulated, &estimated))
}

/// Models of the conditions, as files that other commands take.
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
    let text = Model { provenance, ..model }.to_toml()?;
    files::write_new(&folder.join("models").join(format!("{condition}.toml")), text.as_bytes(), true)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With p found, unless said otherwise.
    fn fitted(omega: f64, error: f64) -> FitSummary {
        let covariance = without_lag(&Matrix3::new(
            1e-6,
            0.0,
            0.0,
            0.0,
            error * error,
            0.5 * error * 0.01,
            0.0,
            0.5 * error * 0.01,
            1e-4,
        ));
        FitSummary {
            order: 2,
            values: [-1.1, 1e4, omega, 0.6],
            std_errors: [Some(1e-3), None, Some(error * omega), Some(6e-3)],
            covariance: Some(covariance),
            pole_above: None,
            delay_s: 0.0,
            converged: true,
            ending: String::new(),
            at_bound: Vec::new(),
            not_identifiable: Vec::new(),
            residual_rms: 0.1,
            notes: Vec::new(),
        }
    }

    #[test]
    fn equal_fits_combine_to_themselves_with_errors_that_shrink_as_their_root() {
        let one = fitted(165.0, 0.01);
        let (sum, scatter) = combined(&[&one, &one, &one, &one]).unwrap();
        for (found, expected) in sum.values.iter().zip(one.values) {
            assert!((found / expected - 1.0).abs() < 1e-12);
        }
        assert!((sum.std_errors[2].unwrap() / one.std_errors[2].unwrap() - 0.5).abs() < 1e-9);
        assert!(scatter.unwrap() < 1e-9);
        let unknown = FitSummary { pole_above: Some(1e4), ..one.clone() };
        let (sum, _) = combined(&[&unknown, &unknown, &unknown, &unknown]).unwrap();
        assert!(
            (sum.std_errors[2].unwrap() / one.std_errors[2].unwrap() - 1.0).abs() < 1e-9 && sum.pole_above == Some(1e4)
        );
    }

    #[test]
    fn the_surer_fit_counts_more_and_disagreement_widens_the_errors() {
        // With ζ the same in both, ω alone is weighted with its conditional variances; by symmetry of ρ with 1/σ².
        let (near, far) = (fitted(165.0, 0.001), fitted(180.0, 0.01));
        let (sum, scatter) = combined(&[&near, &far]).unwrap();
        assert!((sum.values[2] - 165.0).abs() < 1.0, "{sum:?}");
        assert!(
            scatter.unwrap() > 3.0 && sum.std_errors[2].unwrap() > 3.0 * 0.001 * 160.0 * 0.9,
            "{scatter:?} {sum:?}"
        );
    }

    #[test]
    fn fits_without_covariance_count_alike() {
        let fits = [150.0, 160.0, 170.0].map(|omega| FitSummary { covariance: None, ..fitted(omega, 0.01) });
        let (sum, scatter) = combined(&fits.each_ref()).unwrap();
        assert!((sum.values[2] - (150.0_f64 * 160.0 * 170.0).cbrt()).abs() < 1e-9 && scatter.is_none());
        assert!(sum.std_errors[2].unwrap() > 1.0);
    }
}
