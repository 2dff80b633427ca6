//! What a sensor did by itself, taken out before a model is judged: spikes, which are left out, and a slip, whose height is subtracted.

use super::{laguerre, level, sampling, window};
use crate::{signal::record::Record, spikes};

/// The record without what its sensor did by itself, and what that was in words.
#[must_use]
pub fn without_sensor_faults(record: Record) -> (Record, Vec<String>) {
    let clock = sampling::clock(record.time());
    let window = window::window(&record, &clock);
    // On other times samples of the window are none of the record.
    let same = window.position.len() == record.len() && window.position == record.position();
    if !same {
        return (record, Vec::new());
    }
    let linear = laguerre::fit(&window.command, &window.position);
    let explained: Vec<f64> =
        window.position.iter().zip(&linear.residual).map(|(position, left)| position - left).collect();
    let spikes = spikes::spikes(&linear.residual, &explained);
    let slip = level::step(&linear.residual).map(|(about, _)| located(&linear.residual, about));
    let mut words = Vec::new();
    if !spikes.is_empty() {
        words.push(format!("{} spikes are left out", spikes.len()));
    }
    if let Some((sample, height)) = slip {
        let height = crate::digits::significant(height, 3);
        words.push(format!(
            "the level changes by {height} at {:.4} s: a slip of the sensor, taken out",
            record.time()[sample]
        ));
    }
    let words = words.into_iter().map(|word| format!("{}: {word}", record.source().display())).collect();
    (record.without(&spikes, slip), words)
}

/// The sample about which the residual changes its level most sharply, and by how much.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn located(residual: &[f64], about: usize) -> (usize, f64) {
    const BLOCKS_AROUND: usize = 20;
    let reach = residual.len() / BLOCKS_AROUND;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let change = |at: usize| mean(&residual[at..]) - mean(&residual[..at]);
    let left = |at: usize| {
        let (low, high) = (mean(&residual[..at]), mean(&residual[at..]));
        let before: f64 = residual[..at].iter().map(|value| (value - low).powi(2)).sum();
        before + residual[at..].iter().map(|value| (value - high).powi(2)).sum::<f64>()
    };
    let places = about.saturating_sub(reach).max(1)..(about + reach).min(residual.len() - 1);
    let sample = places.min_by(|a, b| left(*a).total_cmp(&left(*b))).unwrap_or(about);
    (sample, change(sample))
}
