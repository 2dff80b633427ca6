//! One chart for each condition: measured responses of its records, and its model.

use crate::{
    campaign::{Campaign, ConditionOutcome, RecordOutcome},
    report::plot::{Axis, Panel, Plot, Style, aligned},
};
use identification::{
    compare::LIMITS,
    frequency::{BAND_HZ, phase_deg},
};

/// Maximum number of records in a chart; more would hide each other.
const MOST_SHOWN: usize = 5;

/// Colours for records; the first is that of the model.
const RECORD_COLOURS: [usize; MOST_SHOWN] = [1, 2, 3, 4, 5];

/// Number of points of a model's curve.
const POINTS: u32 = 180;

/// For all conditions with a result.
pub fn conditions(campaign: &Campaign) -> Vec<Plot> {
    let charts = campaign.conditions.iter().filter_map(|outcome| {
        let records: Vec<&RecordOutcome> =
            campaign.records.iter().filter(|record| record.condition == outcome.condition).collect();
        condition(outcome, &records)
    });
    aligned(charts.collect())
}

fn condition(outcome: &ConditionOutcome, records: &[&RecordOutcome]) -> Option<Plot> {
    let set = outcome.result.as_ref()?.estimate.set("")?;
    let shown: Vec<_> = records.iter().filter_map(|record| record.result.as_ref()).take(MOST_SHOWN).collect();
    let measured: Vec<Vec<[f64; 3]>> = shown
        .iter()
        .map(|result| {
            let sure = result.response.iter().filter(|point| {
                point.magnitude_std_error < LIMITS.magnitude && point.phase_std_error_deg < LIMITS.phase_deg
            });
            sure.map(|point| [point.frequency_hz, point.magnitude, point.phase_deg]).collect()
        })
        .collect();
    let model: Vec<[f64; 3]> = (0..=POINTS)
        .map(|index| {
            let frequency = BAND_HZ[0] + (BAND_HZ[1] - BAND_HZ[0]) * f64::from(index) / f64::from(POINTS);
            let response = set.response(frequency);
            [frequency, response.norm(), phase_deg(response)]
        })
        .collect();
    let pick = |points: &[[f64; 3]], column: usize| points.iter().map(|point| [point[0], point[column]]).collect();
    let greatest = model.iter().map(|point| point[1]).fold(1.5, f64::max);
    let lowest = model.iter().map(|point| point[2]).fold(-50.0, f64::min);
    let mut magnitude = Panel::new(Axis::around("magnitude", [0.0, greatest]));
    let mut phase = Panel::new(Axis::around("phase, deg", [lowest, 0.0]));
    for (points, colour) in measured.iter().zip(RECORD_COLOURS) {
        magnitude = magnitude.marks(Style::colour(colour), "", pick(points, 1));
        phase = phase.marks(Style::colour(colour), "", pick(points, 2));
    }
    magnitude = magnitude.line(Style::colour(0), "", pick(&model, 1));
    phase = phase.line(Style::colour(0), "", pick(&model, 2));
    let axis = Axis::linear("frequency, Hz", BAND_HZ[0], BAND_HZ[1]).ticks(&[0.5, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0]);
    let left_out = records.len() - shown.len();
    let note =
        if left_out == 0 { String::new() } else { format!("{} of {} records shown", shown.len(), records.len()) };
    Some(Plot::new(outcome.condition.to_string(), axis).note(note).panel(magnitude).panel(phase))
}
