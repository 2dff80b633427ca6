//! The gap between packaged FMUs and measured records: in time and over frequency, through an importer.

pub mod dependence;

use std::path::Path;

use serde::Serialize;

use crate::importer::{Drive, UnpackedFmu};
use actuator_fmu::{actuator::Actuator, error::Result, parameters::Model};
use identification::diagnose::{Diagnosis, pooled_rms};
use identification::{
    frequency::{BAND_HZ, FrequencyPoint, FrequencyResponse, Method, estimate, phase_deg},
    signal::{Command, Interpolation, record::Record},
};

/// A command that moves linearly between samples is stepped in this many held pieces, each at its middle: what that leaves out is
/// below a thousandth of what a sample brings.
const PIECES: usize = 16;

/// The gap of one FMU.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Gap {
    /// Root mean square over the fitted records \[deg\].
    pub fit_rms: f64,
    /// Root mean square over the check records \[deg\].
    pub check_rms: f64,
    /// Greatest |measured - simulated| magnitude of the responses where they are known [deg/deg].
    pub magnitude_max: Option<f64>,
    /// Greatest |phase of measured over simulated| there \[deg\].
    pub phase_max_deg: Option<f64>,
}

/// An FMU on all records.
pub struct Measured {
    /// The gap.
    pub gap: Gap,
    /// Simulated positions, fitted records first \[deg\].
    pub simulated: Vec<Vec<f64>>,
    /// Measured less simulated positions after settling, fitted records first; zero where none was measured \[deg\].
    pub residuals: Vec<Vec<f64>>,
    /// Response of the simulated records.
    pub response: Option<FrequencyResponse>,
}

/// Steps the FMU of a model through all records. `starts` are start values of each record beside those of the FMU.
///
/// # Errors
/// An FMU that refuses.
pub fn measure(
    fmu: &Path,
    model: &Model,
    fit: &[Record],
    check: &[Record],
    diagnosis: &Diagnosis,
    starts: &[Vec<(&str, f64)>],
    measured: Option<&FrequencyResponse>,
) -> Result<Measured> {
    let unit = UnpackedFmu::open(fmu)?;
    let actuator = Actuator::new(model.base, model.order, &model.effects);
    let mut simulated = Vec::new();
    let mut residuals: Vec<Vec<Option<f64>>> = Vec::new();
    for (index, record) in fit.iter().chain(check).enumerate() {
        let (start, settling) = diagnosis.starts[index];
        let mut values = vec![("initial_position", actuator.nearest_held(start))];
        values.extend(&starts[index]);
        let position = respond(&unit, record, &values)?;
        let left = |sample: usize| {
            let counts = record.is_measured(sample);
            counts.then(|| record.position()[sample] - position[sample])
        };
        residuals.push((settling..record.len()).map(left).collect());
        simulated.push(position);
    }
    let response = response(fit, &simulated);
    let (magnitude_max, phase_max_deg) = match (measured, &response) {
        (Some(measured), Some(response)) => differences(measured, response),
        _ => (None, None),
    };
    let that_count = |some: &[Vec<Option<f64>>]| pooled_rms(&[some.iter().flatten().flatten().copied().collect()]);
    let (fit_residuals, check_residuals) = residuals.split_at(fit.len());
    let gap = Gap {
        fit_rms: that_count(fit_residuals),
        check_rms: that_count(check_residuals),
        magnitude_max,
        phase_max_deg,
    };
    let residuals =
        residuals.into_iter().map(|record| record.into_iter().map(Option::unwrap_or_default).collect()).collect();
    Ok(Measured { gap, simulated, residuals, response })
}

/// Measured position of an FMU at the times of a record.
fn respond(unit: &UnpackedFmu, record: &Record, starts: &[(&str, f64)]) -> Result<Vec<f64>> {
    if record.interpolation() == Interpolation::Held {
        let command = record.to_command();
        let drive = Drive { command: &command, interpolation: Interpolation::Held, load: record.load(), starts };
        return Ok(unit.respond(&drive)?.position);
    }
    let time = record.time();
    let mut fine = Command::default();
    let mut loads = record.load().map(|_| Vec::new());
    #[allow(clippy::cast_precision_loss)] // a count of pieces
    for (index, pair) in time.windows(2).enumerate() {
        for piece in 0..PIECES {
            let (begin, middle) = (piece as f64 / PIECES as f64, (piece as f64 + 0.5) / PIECES as f64);
            let between = |values: &[f64]| values[index] + middle * (values[index + 1] - values[index]);
            fine.time.push(pair[0] + begin * (pair[1] - pair[0]));
            fine.command.push(between(record.command()));
            if let (Some(loads), Some(load)) = (&mut loads, record.load()) {
                loads.push(between(load));
            }
        }
    }
    fine.time.push(time[time.len() - 1]);
    fine.command.push(record.command()[time.len() - 1]);
    let drive = Drive { command: &fine, interpolation: Interpolation::Held, load: loads.as_deref(), starts };
    Ok(unit.respond(&drive)?.position.into_iter().step_by(PIECES).collect())
}

/// Response of records with other positions; none where they do not tell one.
fn response(records: &[Record], positions: &[Vec<f64>]) -> Option<FrequencyResponse> {
    let simulated: Option<Vec<Record>> = records
        .iter()
        .zip(positions)
        .map(|(record, position)| {
            let source = record.source();
            Record::new(record.to_command(), position.clone(), record.unit(), record.interpolation(), source).ok()
        })
        .collect();
    estimate(&simulated?, Method::Polynomial).ok()
}

/// Response of the measured records, where they tell one.
#[must_use]
pub fn measured_response(fit: &[Record]) -> Option<FrequencyResponse> {
    estimate(fit, Method::Polynomial).ok()
}

/// Frequencies at which a response is known well enough to be compared: standard errors below what a control law can bear.
pub fn known(response: &FrequencyResponse) -> impl Iterator<Item = &FrequencyPoint> {
    const MAGNITUDE: f64 = 0.1;
    const PHASE_DEG: f64 = 3.0;
    response
        .inside(BAND_HZ)
        .filter(|point| point.excited && point.magnitude_std_error < MAGNITUDE && point.phase_std_error_deg < PHASE_DEG)
}

/// Greatest differences of magnitude and phase [deg].
fn differences(measured: &FrequencyResponse, simulated: &FrequencyResponse) -> (Option<f64>, Option<f64>) {
    let pairs = known(measured).filter_map(|point| {
        let other = simulated.points.iter().find(|other| other.frequency_hz == point.frequency_hz)?;
        Some((point.response, other.response))
    });
    let (mut magnitude, mut phase) = (None, None);
    for (one, other) in pairs {
        let grow = |greatest: &mut Option<f64>, value: f64| {
            *greatest = Some(greatest.map_or(value, |old: f64| old.max(value)))
        };
        grow(&mut magnitude, (one.norm() - other.norm()).abs());
        grow(&mut phase, phase_deg(one * other.conj()).abs());
    }
    (magnitude, phase)
}

/// Share of the gap's variance above the noise that was closed on the check records.
#[must_use]
pub fn closed(before: &Gap, after: &Gap, noise_rms: f64) -> f64 {
    let noise = noise_rms * noise_rms;
    let gap = before.check_rms.powi(2) - noise;
    if gap <= 0.0 { 0.0 } else { 1.0 - (after.check_rms.powi(2) - noise) / gap }
}
