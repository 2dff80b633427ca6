//! Pictures of a diagnosis: records before and after, spectra of what is left, responses against the limits, places.

use crate::{
    gap,
    report::{
        plot::{Axis, Dash, Panel, Plot, Style},
        spectra::{decibel, decibels, label},
    },
    workflow::account::Account,
};
use identification::{
    compare::LIMITS,
    diagnose::location::Location,
    frequency::{BAND_HZ, FrequencyResponse, phase_deg},
};

/// Seconds of a record that an overlay shows, around the greatest gap: some cycles of what it answers to.
const OVERLAY_S: f64 = 0.4;

/// Seconds of a record that a loop shows, around the greatest gap: more would cover each other.
const LOOP_S: f64 = 2.0;

/// Spectra are drawn up to here [Hz].
const HIGHEST_HZ: f64 = 40.0;

/// Caption, remark and picture of each chart on the gap.
pub fn gap(account: &Account) -> Vec<(String, String, Plot)> {
    let mut charts = Vec::new();
    if let Some(plot) = overlay(account) {
        charts.push(("A check record".to_owned(), "Around its largest difference.".to_owned(), plot));
    }
    if let Some(plot) = loops(account) {
        charts.push((
            "Position against command".to_owned(),
            "The same record, two seconds around its largest difference.".to_owned(),
            plot,
        ));
    }
    charts.push((
        "Residual over time".to_owned(),
        "A check record; dashed: twice the noise.".to_owned(),
        residuals(account),
    ));
    charts.push((
        "Residual over frequency".to_owned(),
        "Check records; averaged over segments of four seconds.".to_owned(),
        spectra(account),
    ));
    if let Some(plot) = responses(account) {
        charts.push((
            "Frequency responses: measured minus simulated".to_owned(),
            "Fit records; dashed: tolerance of a control law, 0.1 and 3 deg.".to_owned(),
            plot,
        ));
    }
    charts
}

/// Samples of the first check record around its greatest gap, and where they begin [s].
fn around_greatest_gap(account: &Account, duration_s: f64) -> Option<(Vec<usize>, f64)> {
    let time = account.check.first()?.time();
    let place = account.fit.len();
    let (_, settling) = account.diagnosis.starts[place];
    let (greatest, _) =
        account.before.residuals[place].iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let from = (time[greatest + settling] - 0.5 * duration_s).max(time[0]);
    let inside = |index: &usize| (from..=from + duration_s).contains(&time[*index]);
    Some(((0..time.len()).filter(inside).collect(), from))
}

fn loops(account: &Account) -> Option<Plot> {
    let (indices, _) = around_greatest_gap(account, LOOP_S)?;
    let (record, place, unit) = (account.check.first()?, account.fit.len(), account.unit());
    let commands = || indices.iter().map(|index| record.command()[*index]);
    let points = |values: &[f64]| commands().zip(&indices).map(|(command, index)| [command, values[*index]]).collect();
    let before = &account.before.simulated[place];
    let all = indices.iter().flat_map(|index| [record.position()[*index], before[*index]]);
    let position = Panel::new(Axis::around(format!("position, {unit}"), all))
        .line(Style::colour(5).faint(), "measured", points(record.position()))
        .line(Style::colour(1).dash(Dash::Dashed), "before", points(before))
        .line(Style::colour(0), "after", points(&account.after.simulated[place]))
        .height(220.0);
    Some(Plot::new("", Axis::around(format!("command, {unit}"), commands())).panel(position))
}

fn overlay(account: &Account) -> Option<Plot> {
    let record = account.check.first()?;
    let place = account.fit.len();
    let (indices, from) = around_greatest_gap(account, OVERLAY_S)?;
    let time = record.time();
    let points = |values: &[f64]| indices.iter().map(|index| [time[*index], values[*index]]).collect::<Vec<[f64; 2]>>();
    let unit = account.unit();
    let all = indices.iter().flat_map(|index| {
        [record.position()[*index], account.before.simulated[place][*index], account.after.simulated[place][*index]]
    });
    let position = Panel::new(Axis::around(format!("position, {unit}"), all))
        .marks(Style::colour(5), "measured", points(record.position()))
        .line(Style::colour(1).dash(Dash::Dashed), "before", points(&account.before.simulated[place]))
        .line(Style::colour(0), "after", points(&account.after.simulated[place]));
    Some(Plot::new("", Axis::linear("time, s", from, from + OVERLAY_S)).panel(position.height(220.0)))
}

fn residuals(account: &Account) -> Plot {
    let first = account.fit.len();
    let mut panel = None;
    let (mut longest, mut beginning) = (0.0_f64, 0.0);
    if let Some(record) = account.check.first() {
        let (_, settling) = account.diagnosis.starts[first];
        let time = record.time();
        (beginning, longest) = (time[0], time[time.len() - 1]);
        let points = |values: &[f64]| {
            time[settling..].iter().zip(values).map(|(time, value)| [*time, *value]).collect::<Vec<[f64; 2]>>()
        };
        let noise = 2.0 * account.diagnosis.noise.rms;
        let (before, after) = (&account.before.residuals[first], &account.after.residuals[first]);
        let axis = Axis::around(format!("residual, {}", account.unit()), before.iter().chain(after).copied());
        panel = Some(
            Panel::new(axis)
                .line(Style::colour(1), "before", points(before))
                .line(Style::colour(0), "after", points(after))
                .limit(noise, "")
                .limit(-noise, "")
                .height(220.0),
        );
    }
    let plot = Plot::new("", Axis::linear("time, s", beginning, longest));
    match panel {
        Some(panel) => plot.panel(panel),
        None => plot,
    }
}

fn spectra(account: &Account) -> Plot {
    let first = account.fit.len();
    let interval = account.check.first().unwrap_or(&account.fit[0]).sampling().interval_s();
    let highest = 0.5 / interval;
    let of = |residuals: &[Vec<f64>]| decibels(&residuals[first..], interval);
    let (before, after) = (of(&account.before.residuals), of(&account.after.residuals));
    let noise = decibel(account.diagnosis.noise.rms.powi(2) / highest);
    let values = || before.iter().chain(&after).filter(|point| point[0] < HIGHEST_HZ).map(|point| point[1]);
    let panel = Panel::new(Axis::around(label(account.unit()), values().chain([noise])))
        .line(Style::colour(1), "before", before.clone())
        .line(Style::colour(0), "after", after.clone())
        .limit(noise, "white noise of the same rms")
        .height(220.0);
    Plot::new("", Axis::linear("frequency, Hz", 0.0, highest.min(HIGHEST_HZ))).panel(panel)
}

fn responses(account: &Account) -> Option<Plot> {
    let measured = account.measured.as_ref()?;
    let pairs = |response: &FrequencyResponse| -> Vec<[f64; 3]> {
        gap::known(measured)
            .filter_map(|point| {
                let other = response.points.iter().find(|other| other.frequency_hz == point.frequency_hz)?;
                let phase = phase_deg(point.response * other.response.conj());
                Some([point.frequency_hz, point.response.norm() - other.response.norm(), phase])
            })
            .collect()
    };
    let (before, after) = (pairs(account.before.response.as_ref()?), pairs(account.after.response.as_ref()?));
    if before.is_empty() {
        return None;
    }
    let column = |points: &[[f64; 3]], place: usize| -> Vec<[f64; 2]> {
        points.iter().map(|point| [point[0], point[place]]).collect()
    };
    let panel = |label: &str, place: usize, limit: f64| {
        let values = before.iter().chain(&after).map(|point| point[place]).chain([-1.2 * limit, 1.2 * limit]);
        Panel::new(Axis::around(label, values))
            .line(Style::colour(1), "before", column(&before, place))
            .line(Style::colour(0), "after", column(&after, place))
            .limit(limit, "")
            .limit(-limit, "")
    };
    let plot = Plot::new(
        "",
        Axis::linear("frequency, Hz", BAND_HZ[0], BAND_HZ[1]).ticks(&[0.5, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0]),
    );
    Some(plot.panel(panel("magnitude", 1, LIMITS.magnitude)).panel(panel("phase, deg", 2, LIMITS.phase_deg)))
}

/// Density of the gap along one axis.
pub fn location(location: &Location) -> Plot {
    let Location { axis, unit, density, range, .. } = location;
    let values = density.iter().map(|point| point[1]).chain([0.0, 1.0]);
    let (first, last) = (density.first().map_or(0.0, |point| point[0]), density.last().map_or(1.0, |point| point[0]));
    let panel = Panel::new(Axis::around("difference / record", values))
        .span(range[0].max(first), range[1].min(last), "")
        .line(Style::colour(0), "", density.clone())
        .marks(Style::colour(0), "", density.clone())
        .limit(1.0, "");
    let label = if *unit == "1" { (*axis).to_owned() } else { format!("{axis}, {unit}") };
    Plot::new(*axis, Axis::linear(label, first, last)).panel(panel)
}
