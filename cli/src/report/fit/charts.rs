//! Charts of a fit: measured and modelled response, residual over frequency and time, a check record.

use identification::{
    compare::{LIMITS, Set},
    frequency::{FrequencyPoint, FrequencyResponse, Method, estimate, phase_deg},
    signal::record::Record,
};
use nalgebra::Complex;

use super::Account;
use crate::report::{
    head::file_name,
    plot::{Axis, Dash, Panel, Plot, Style},
    spectra::{decibels, label},
};

/// Number of points of a model's curve.
const POINTS: u32 = 180;

/// Maximum number of measured points; more add no information in a chart that is 350 units wide.
const MOST_POINTS: usize = 400;

/// Seconds shown of a check record, around its maximum difference.
const OVERLAY_S: f64 = 1.0;

/// Caption, note and chart, of each.
pub fn figures(account: &Account<'_>) -> Vec<(String, String, Plot)> {
    let mut charts = Vec::new();
    let set = Set { delay_s: account.fit.delay_s, ..Set::new("", account.fit.model.clone()) };
    // If the records do not allow a response estimate there is none to show.
    let measured = estimate(account.records, Method::Polynomial).ok();
    let points = measured.as_ref().map_or_else(Vec::new, |measured| known(measured, &set));
    if let [first, .., last] = points.as_slice() {
        let band = [first.frequency_hz, last.frequency_hz];
        let remark = "Fitted records, where the response is known to a fifth; line: the model.".to_owned();
        charts.push(("Response".to_owned(), remark, bode(&points, &set, band)));
        let remark = "Dashed: tolerance of a control law, 0.1 and 3 deg.".to_owned();
        charts.push(("Response: measured minus model".to_owned(), remark, difference(&points, &set, band)));
    }
    charts.extend(over_frequency(account));
    charts.extend(account.others.first().into_iter().flat_map(|record| predicted(account, record)));
    charts
}

/// Maximum standard error of a point that is shown, relative to the model's magnitude.
const LARGEST_ERROR: f64 = 0.2;

/// The points excited by the command with a sufficiently small standard error, thinned to the resolution of a chart.
fn known<'a>(measured: &'a FrequencyResponse, set: &Set) -> Vec<&'a FrequencyPoint> {
    let is_known = |point: &&FrequencyPoint| {
        let greatest = LARGEST_ERROR * set.response(point.frequency_hz).norm();
        point.excited && point.frequency_hz > 0.0 && point.magnitude_std_error < greatest
    };
    let known: Vec<&FrequencyPoint> = measured.points.iter().filter(is_known).collect();
    let every = known.len().div_ceil(MOST_POINTS).max(1);
    known.into_iter().step_by(every).collect()
}

/// Frequencies and unwrapped phases of a model [deg].
fn unwrapped(responses: &[(f64, Complex<f64>)]) -> Vec<[f64; 2]> {
    let mut before: Option<(Complex<f64>, f64)> = None;
    responses
        .iter()
        .map(|(frequency, response)| {
            let phase = before
                .map_or_else(|| phase_deg(*response), |(other, phase)| phase + phase_deg(response * other.conj()));
            before = Some((*response, phase));
            [*frequency, phase]
        })
        .collect()
}

fn bode(points: &[&FrequencyPoint], set: &Set, [low, high]: [f64; 2]) -> Plot {
    let step = (high / low).powf(1.0 / f64::from(POINTS));
    let model: Vec<(f64, Complex<f64>)> = (0..=POINTS)
        .map(|index| low * step.powf(f64::from(index)))
        .map(|frequency| (frequency, set.response(frequency)))
        .collect();
    let of_magnitude: Vec<[f64; 2]> = model.iter().map(|(frequency, response)| [*frequency, response.norm()]).collect();
    let of_phase = unwrapped(&model);
    // Next to the phase of the model, so that no measured one is a turn away from it.
    let phase = |point: &FrequencyPoint| {
        let nearest = of_phase.partition_point(|[frequency, _]| *frequency < point.frequency_hz).min(POINTS as usize);
        of_phase[nearest][1] + phase_deg(point.response * model[nearest].1.conj())
    };
    let each = |value: &dyn Fn(&FrequencyPoint) -> f64| -> Vec<[f64; 2]> {
        points.iter().map(|point| [point.frequency_hz, value(point)]).collect()
    };
    let (magnitudes, phases) = (each(&|point| point.response.norm()), each(&phase));
    let panel = |label: &str, measured: Vec<[f64; 2]>, model: Vec<[f64; 2]>, least: &[f64]| {
        let values = measured.iter().chain(&model).map(|point| point[1]).chain(least.iter().copied());
        Panel::new(Axis::around(label, values.collect::<Vec<f64>>()))
            .marks(Style::colour(5), "measured", measured)
            .line(Style::colour(0), "model", model)
    };
    let coherence = Panel::new(Axis::linear("coherence", 0.0, 1.0)).marks(
        Style::colour(5),
        "measured",
        each(&|point| point.coherence),
    );
    Plot::new("", Axis::logarithmic("frequency, Hz", low, high))
        .panel(panel("magnitude", magnitudes, of_magnitude, &[0.0]))
        .panel(panel("phase, deg", phases, of_phase.clone(), &[]))
        .panel(coherence.height(80.0))
}

fn difference(points: &[&FrequencyPoint], set: &Set, [low, high]: [f64; 2]) -> Plot {
    let differences: Vec<[f64; 3]> = points
        .iter()
        .map(|point| {
            let model = set.response(point.frequency_hz);
            let phase = phase_deg(point.response * model.conj());
            [point.frequency_hz, point.response.norm() - model.norm(), phase]
        })
        .collect();
    let panel = |label: &str, place: usize, limit: f64| {
        let values = differences.iter().map(|point| point[place]).chain([-1.2 * limit, 1.2 * limit]);
        Panel::new(Axis::around(label, values))
            .marks(Style::colour(0), "", differences.iter().map(|point| [point[0], point[place]]).collect())
            .limit(limit, "")
            .limit(-limit, "")
    };
    Plot::new("", Axis::logarithmic("frequency, Hz", low, high))
        .panel(panel("magnitude", 1, LIMITS.magnitude))
        .panel(panel("phase, deg", 2, LIMITS.phase_deg))
}

/// Residuals of records, as many as have the sampling of the first.
fn residuals(account: &Account<'_>, records: &[Record]) -> Option<(Vec<Vec<f64>>, f64)> {
    let interval_s = records.first()?.sampling().interval_s();
    let same = records.iter().filter(|record| (record.sampling().interval_s() / interval_s - 1.0).abs() < 1e-6);
    let residuals: Vec<Vec<f64>> = same.filter_map(|record| account.fit.residual_on(record).ok()).collect();
    (!residuals.is_empty()).then_some((residuals, interval_s))
}

/// Residuals of fit and check records, over frequency.
fn over_frequency(account: &Account<'_>) -> Option<(String, String, Plot)> {
    let (fitted, interval_s) = residuals(account, account.records)?;
    let fitted = decibels(&fitted, interval_s);
    let unseen = residuals(account, account.others).map(|(left, interval_s)| decibels(&left, interval_s));
    let positions: Vec<Vec<f64>> = account
        .records
        .iter()
        .take(1)
        .map(|record| {
            let mean = record.position().iter().sum::<f64>() / record.len() as f64;
            record.position().iter().map(|position| position - mean).collect()
        })
        .collect();
    let position = decibels(&positions, interval_s);
    let all = fitted.iter().chain(unseen.iter().flatten()).chain(&position).map(|point| point[1]);
    let mut panel = Panel::new(Axis::around(label(account.fit.unit), all))
        .line(Style::colour(5).faint(), "position", position.clone())
        .line(Style::colour(0), "residual of fitted records", fitted.clone());
    if let Some(unseen) = unseen {
        panel = panel.line(Style::colour(1).dash(Dash::Dashed), "residual of check records", unseen);
    }
    let highest = fitted.last().map_or(1.0, |point| point[0]);
    let plot = Plot::new("", Axis::linear("frequency, Hz", 0.0, highest)).panel(panel.height(220.0));
    let remark = "Measured minus modelled position, beside the position of the first record; averaged over segments of four seconds.";
    Some(("Residual over frequency".to_owned(), remark.to_owned(), plot))
}

/// A check record: around its maximum difference, and that difference over time.
fn predicted(account: &Account<'_>, record: &Record) -> Vec<(String, String, Plot)> {
    let Ok(left) = account.fit.residual_on(record) else { return Vec::new() };
    let (time, unit, name) = (record.time(), account.fit.unit, file_name(record.source()));
    let greatest = left.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map_or(0, |(at, _)| at);
    let from = (time[greatest] - 0.5 * OVERLAY_S).max(time[0]);
    let inside: Vec<usize> =
        (0..time.len()).filter(|index| (from..=from + OVERLAY_S).contains(&time[*index])).collect();
    let measured: Vec<[f64; 2]> = inside.iter().map(|index| [time[*index], record.position()[*index]]).collect();
    let model: Vec<[f64; 2]> =
        inside.iter().map(|index| [time[*index], record.position()[*index] - left[*index]]).collect();
    let values = measured.iter().chain(&model).map(|point| point[1]);
    let overlay = Panel::new(Axis::around(format!("position, {unit}"), values))
        .marks(Style::colour(5), "measured", measured.clone())
        .line(Style::colour(0), "model", model.clone())
        .height(220.0);
    let over_time = Panel::new(Axis::around(format!("residual, {unit}"), left.iter().copied()))
        .line(Style::colour(0), "", time.iter().zip(&left).map(|(time, left)| [*time, *left]).collect())
        .height(220.0);
    let (first, last) = (time[0], time[time.len() - 1]);
    vec![
        (
            "A record that was not fitted".to_owned(),
            format!("{name}, around its greatest difference."),
            Plot::new("", Axis::linear("time, s", from, from + OVERLAY_S)).panel(overlay),
        ),
        (
            "Residual over time".to_owned(),
            format!("{name}: measured minus predicted position."),
            Plot::new("", Axis::linear("time, s", first, last)).panel(over_time),
        ),
    ]
}
