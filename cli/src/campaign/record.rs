//! One record: response, fit, and the distance between them.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

use super::{
    manifest::{Entry, in_its_words},
    outcome::{RecordOutcome, RecordResult, ResponsePoint},
    store,
    summary::FitSummary,
};
use crate::files;
use actuator_fmu::error::{Error, Result};
use identification::{
    compare::{InBand, LIMITS},
    estimate::{Settings, fit},
    frequency::{BAND_HZ, FrequencyPoint, FrequencyResponse, Method, estimate},
    inspect::{self, ExpectedGain},
    signal::record::Record,
};

/// Band in which the report judged its fits \[Hz\].
pub const JUDGED_BAND_HZ: [f64; 2] = [2.0, 10.0];

/// More points add no information: neighbours share their data, and a chart is 350 units wide.
const MOST_POINTS: usize = 240;

/// The outcome of a record: reused from an earlier run, or analysed and stored.
pub(super) fn outcome(entry: &Entry, settings: &Settings, folder: &Path, force: bool) -> RecordOutcome {
    let (result, reused) = match analyse_or_reuse(entry, settings, folder, force) {
        Ok((result, reused)) => (Ok(result), reused),
        Err(error) => (Err(error), false),
    };
    RecordOutcome {
        name: entry.name.clone(),
        file: entry.file.display().to_string(),
        line: entry.line,
        condition: entry.condition.clone(),
        mach: entry.mach,
        dynamic_pressure_psf: entry.dynamic_pressure_psf,
        reused,
        failure: result.as_ref().err().map(|error| in_its_words(&error.to_string())),
        result: result.ok(),
    }
}

fn analyse_or_reuse(entry: &Entry, settings: &Settings, folder: &Path, force: bool) -> Result<(RecordResult, bool)> {
    let path = folder.join("records").join(format!("{}.json", entry.name));
    let key = store::Key::new(store::file_sha256(&entry.file)?, &format!("{:?} {settings:?}", entry.format));
    if let Some(result) = store::read(&path, &key).filter(|_| !force) {
        return Ok((result, true));
    }
    // A bug triggered by one record must not affect the other results.
    let result = catch_unwind(AssertUnwindSafe(|| analyse(entry, settings))).unwrap_or_else(|_| {
        Err(Error::new("analysis", "a panic", "a result or a reason")
            .remedy("this is a bug of the program: please report it with the record")
            .at(&entry.file, None))
    })?;
    store::write(&path, &key, &result)?;
    Ok((result, false))
}

/// The result of a record in a file.
///
/// # Errors
/// A record that cannot be read or does not allow a response or fit; with its file.
pub fn analyse(entry: &Entry, settings: &Settings) -> Result<RecordResult> {
    let record = files::read_record(&entry.file, &entry.format)?;
    let warnings = inspect::admit(&[&record], ExpectedGain::Positive)?;
    let warnings = warnings.iter().map(|warning| in_its_words(warning)).collect();
    let result = of_record(record, settings).map_err(|error| error.or_at(&entry.file))?;
    Ok(RecordResult { warnings, ..result })
}

/// The result of a record in memory.
///
/// # Errors
/// A record that does not allow a response or fit.
pub fn of_record(record: Record, settings: &Settings) -> Result<RecordResult> {
    let (sha256, samples, duration_s) = (record.sha256().to_owned(), record.len(), record.duration_s());
    let unit = record.unit().name().to_owned();
    let segments = inspect::segments(record);
    let measured = estimate(&segments, Method::Polynomial)?;
    let fitted = fit(&segments, settings)?;
    let summary = FitSummary::of(&fitted);
    Ok(RecordResult {
        warnings: Vec::new(),
        sha256,
        samples,
        duration_s,
        unit,
        excited_band_hz: measured.excited_band_hz(),
        response: thinned(&measured),
        gap: gap(&measured, &summary),
        fit: summary,
    })
}

fn thinned(measured: &FrequencyResponse) -> Vec<ResponsePoint> {
    let finite = |point: &&FrequencyPoint| {
        let errors = point.magnitude_std_error.is_finite() && point.phase_std_error_deg.is_finite();
        point.excited && errors && point.response.norm().is_finite()
    };
    let points: Vec<&FrequencyPoint> = measured.inside(BAND_HZ).filter(finite).collect();
    let every = points.len().div_ceil(MOST_POINTS).max(1);
    let thin = points.into_iter().step_by(every).map(|point| ResponsePoint {
        frequency_hz: point.frequency_hz,
        magnitude: point.response.norm(),
        phase_deg: identification::frequency::phase_deg(point.response),
        magnitude_std_error: point.magnitude_std_error,
        phase_std_error_deg: point.phase_std_error_deg,
        coherence: point.coherence,
    });
    thin.collect()
}

fn gap(measured: &FrequencyResponse, fit: &FitSummary) -> Option<[f64; 2]> {
    let sure = |point: &&FrequencyPoint| {
        let below = point.magnitude_std_error < LIMITS.magnitude && point.phase_std_error_deg < LIMITS.phase_deg;
        point.excited && below
    };
    let model = fit.set("")?;
    let pairs: Vec<_> = measured
        .inside(JUDGED_BAND_HZ)
        .filter(sure)
        .map(|point| (point.frequency_hz, point.response, model.response(point.frequency_hz)))
        .collect();
    let band = InBand::over(pairs.iter().copied(), JUDGED_BAND_HZ);
    (!pairs.is_empty()).then_some([band.magnitude.max, band.phase_deg.max])
}
