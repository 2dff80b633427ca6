//! Local polynomials: the frequency response from a whole record, without window and without leakage.
//!
//! The line spectra of a record, U of the command and Y of the position, are related by the response and by the transient due to the ends
//! of the record, and both are smooth over frequency:
//!
//! ```text
//! Y(k) = G(k) U(k) + T(k) + noise
//! G(k + r) = g0 + g1 r + g2 r²,   T(k + r) = t0 + t1 r + t2 r²,   |r| <= n
//! ```
//!
//! Least squares over the 2n + 1 lines around k give g0, with the variance from their residual (R. Pintelon and J. Schoukens, System
//! Identification, chapter 7). The truncation error is the third derivative of G and T over n lines. To reduce it there are two passes: the
//! first fits a reference model (`reference_model`); in the second the polynomials only have to follow the difference of G and T
//! from it, in Y / G_model.
//!
//! Several records are estimated separately, at the same frequencies, and averaged with the weights 1/variance.

use nalgebra::Complex;

use super::{
    line_grid::LineChoice,
    local_regression::LocalRegression,
    measured::{FrequencyResponse, LineEstimate, Method},
    noise_profile::NoiseProfile,
    reference_model::{self, ReferenceModel},
    spectrum::lines,
};
use crate::{
    signal::record::Record,
    spikes::{bridge, spikes},
};
use actuator_fmu::error::Result;

/// Number of points of the first pass.
const FIRST_PASS: usize = 100;

/// The response from these records together.
///
/// # Errors
/// None for valid records; for symmetry with other methods.
pub fn estimate(records: &[Record], choice: LineChoice) -> Result<FrequencyResponse> {
    let regressions: Vec<LocalRegression> =
        records.iter().map(|record| LocalRegression::new(lines(record, record.position()))).collect();
    let grid = grid(&regressions, choice);
    let mut notes = Vec::new();
    let mut each = Vec::with_capacity(records.len());
    for (record, mut local) in records.iter().zip(regressions) {
        let source = record.source().display();
        let spacing = local.interval_s().map(|interval| (interval, record.interpolation()));
        let first_pass = |local: &mut LocalRegression| {
            let every = grid.len().div_ceil(FIRST_PASS).max(1);
            let first: Vec<LineEstimate> = grid.iter().step_by(every).map(|frequency| local.at(*frequency)).collect();
            reference_model::fit(&first, spacing)
        };
        let mut reference = first_pass(&mut local);
        let Rest { rest, repaired } = Rest::of(record, reference.as_ref());
        if let Some((position, count)) = repaired {
            notes.push(format!(
                "{source}: {count} of {} positions are spikes, and replaced from their neighbours",
                record.len()
            ));
            local = LocalRegression::new(lines(record, &position));
            reference = first_pass(&mut local);
        }
        let profile = NoiseProfile::new(record.command(), &rest, record.sampling().interval_s());
        drop(rest);
        if profile.is_some() {
            notes.push(format!(
                "{source}: the noise differs between parts of the record; standard errors at a frequency are those of the times at which the \
                 command had power there"
            ));
        }
        if let Some(reference) = &reference {
            local.divide_by(reference);
        }
        let raw = grid.iter().map(|frequency| {
            let here = match &reference {
                Some(reference) => local.at(*frequency).times(reference.actuator(*frequency)),
                None => local.at(*frequency).times(reference_model::correction(None, spacing, *frequency)),
            };
            let factor = profile.as_ref().map_or(1.0, |profile| profile.factor(*frequency));
            LineEstimate { variance: here.variance * factor, ..here }
        });
        let raw: Vec<LineEstimate> = raw.collect();
        let lost = raw.iter().filter(|line| !line.excited && local.has_power(line.frequency_hz)).count();
        each.push(raw);
        if lost > 0 {
            notes.push(format!(
                "{source}: {lost} of the frequencies at which the command has power are left out: the response there cannot be distinguished \
                 from the transient of the ends of the record; a command that rests at both ends (excite --quiet) recovers more of them"
            ));
        }
        match (spacing, reference) {
            (None, _) => notes.push(format!(
                "{source}: uneven samples; position interpolated by a spline, accurate to about 0.002 at 12 Hz and 200 samples/s"
            )),
            (Some(_), None) => notes.push(format!("{source}: {}", reference_model::UNCORRECTED_IMAGES)),
            _ => {}
        }
    }
    let points = (0..grid.len()).filter_map(|index| {
        let here: Vec<LineEstimate> = each.iter().map(|raw| raw[index]).collect();
        average(&here).map(LineEstimate::into_point)
    });
    Ok(FrequencyResponse { method: Method::Polynomial, points: points.collect(), averages: None, notes })
}

/// Residual of a record for a reference model, without spikes.
struct Rest {
    rest: Vec<f64>,
    /// The position without its spikes, and their number; `None` if there are none.
    repaired: Option<(Vec<f64>, usize)>,
}

impl Rest {
    /// Without a model the position is compared with itself, and only the command indicates bends.
    fn of(record: &Record, reference: Option<&ReferenceModel>) -> Self {
        let motion = reference.and_then(|reference| reference.position(record));
        let mut rest: Vec<f64> = match &motion {
            Some(motion) => record.position().iter().zip(motion).map(|(measured, model)| measured - model).collect(),
            None => record.position().to_vec(),
        };
        let motion_or_command = motion.as_deref().unwrap_or_else(|| record.command());
        let spikes = spikes(&rest, motion_or_command, record.position());
        bridge(&mut rest, &spikes);
        let repaired = (!spikes.is_empty()).then(|| {
            let mut position = record.position().to_vec();
            spikes.iter().for_each(|n| position[*n] = rest[*n] + motion.as_ref().map_or(0.0, |motion| motion[*n]));
            (position, spikes.len())
        });
        Self { rest, repaired }
    }
}

/// From the lowest to the highest frequency excited by a record, in steps of the longest record.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of lines
fn grid(regressions: &[LocalRegression], choice: LineChoice) -> Vec<f64> {
    let least = |value: fn(&LocalRegression) -> f64| regressions.iter().map(value).fold(f64::INFINITY, f64::min);
    let (step, half_width) = (least(LocalRegression::step_hz), least(LocalRegression::half_width_hz));
    let bands: Vec<[f64; 2]> = regressions.iter().filter_map(LocalRegression::excited_hz).collect();
    let lowest = bands.iter().map(|band| band[0]).fold(f64::INFINITY, f64::min);
    let highest = bands.iter().map(|band| band[1]).fold(0.0, f64::max);
    // Ends are lines of one of the records, up to rounding.
    const ROUNDING: f64 = 1e-6;
    choice.grid(step, [(lowest / step - ROUNDING).ceil() as usize, (highest / step + ROUNDING) as usize], half_width)
}

/// Weighted with 1/variance, over the records that excite the frequency; `None` if there is no such record.
fn average(raw: &[LineEstimate]) -> Option<LineEstimate> {
    let taken = || raw.iter().filter(|point| point.excited);
    let weight = |point: &LineEstimate| 1.0 / point.variance.max(f64::MIN_POSITIVE);
    // Relative to the maximum, so that records without noise do not overflow.
    let greatest = taken().map(weight).fold(0.0, f64::max);
    if greatest == 0.0 {
        return None;
    }
    let sum: f64 = taken().map(|point| weight(point) / greatest).sum();
    let mean = |value: &dyn Fn(&LineEstimate) -> f64| {
        taken().map(|point| value(point) * weight(point) / greatest).sum::<f64>() / sum
    };
    Some(LineEstimate {
        frequency_hz: raw[0].frequency_hz,
        response: Complex::new(mean(&|point| point.response.re), mean(&|point| point.response.im)),
        variance: 1.0 / (greatest * sum),
        coherence: mean(&|point| point.coherence),
        excited: true,
    })
}
