//! The level of a position over a record: steps and drifts, from the medians of blocks of the residual.

use std::ops::Range;

/// Number of blocks over which a level is averaged: a step of level is seen between parts of a record, not between samples.
const BLOCKS: usize = 40;

/// Minimum ratio of a step or drift to the scatter of the block medians.
const STEP_SIGMAS: f64 = 6.0;

/// A sudden change of level in the residual: first sample of the block that starts with it, and height. Medians of blocks before and after each
/// candidate are compared with the scatter of the blocks about them.
#[must_use]
pub fn step(residual: &[f64]) -> Option<(usize, f64)> {
    let (length, levels) = levels(residual)?;
    let (place, height, scatter) = (3..levels.len() - 3)
        .map(|place| {
            let (before, after) = levels.split_at(place);
            let (low, high) = (median_of(&mut before.to_vec()), median_of(&mut after.to_vec()));
            let rest: Vec<f64> =
                before.iter().map(|value| value - low).chain(after.iter().map(|value| value - high)).collect();
            let square = rest.iter().map(|value| value * value).sum::<f64>();
            (place, high - low, (square / rest.len() as f64).sqrt())
        })
        .min_by(|a, b| a.2.total_cmp(&b.2))?;
    let drift = linear_slope(&levels).abs() * levels.len() as f64;
    // A drift is not a step: it leaves a slope in both parts.
    let is_step = height.abs() > STEP_SIGMAS * scatter && height.abs() > 0.5 * drift;
    let place = place * length;
    (is_step && is_sudden(residual, place.saturating_sub(length)..place + length, height)).then_some((place, height))
}

/// Samples before and after a candidate whose medians are compared, for a sudden slip: few if the residual moves, more if it is noise.
const SPANS: [usize; 3] = [6, 24, 96];

/// Minimum ratio of the change over a slip to every other one of the record, and to the height of the step.
const SUDDEN_RATIO: f64 = 1.6;
const SUDDEN_SHARE: f64 = 0.6;

/// Whether the level changes from one sample to the next at one of some candidates, as when a sensor slips: nothing else in the residual
/// changes as fast. A motion not explained by a linear model changes its level over periods.
fn is_sudden(residual: &[f64], places: Range<usize>, height: f64) -> bool {
    for span in SPANS.into_iter().filter(|span| residual.len() >= 8 * span) {
        let change = |n: usize| {
            (median_of(&mut residual[n..n + span].to_vec()) - median_of(&mut residual[n - span..n].to_vec())).abs()
        };
        let changes: Vec<f64> = (span..residual.len() - span).map(change).collect();
        let near = |index: usize| (places.start..places.end + 2 * span).contains(&(index + 2 * span));
        let greatest = |is_near: bool| {
            let some = changes.iter().enumerate().filter(|(index, _)| near(*index) == is_near);
            some.map(|(_, change)| *change).fold(0.0, f64::max)
        };
        let own = greatest(true);
        // Noise increases a change: one that is nevertheless too small is gradual.
        if own < SUDDEN_SHARE * height.abs() {
            return false;
        }
        if own > SUDDEN_RATIO * greatest(false) {
            return true;
        }
    }
    false
}

/// A linear change of level through the whole record, from the first sample to the last. The blocks scatter little about the line, unlike
/// those of a step, of an unexplained motion, or of a slow one.
#[must_use]
pub fn drift(residual: &[f64]) -> Option<f64> {
    let (_, levels) = levels(residual)?;
    let slope = linear_slope(&levels);
    let (mean, middle) = (levels.iter().sum::<f64>() / levels.len() as f64, (levels.len() as f64 - 1.0) / 2.0);
    let about_line = levels.iter().enumerate().map(|(index, level)| level - mean - slope * (index as f64 - middle));
    let scatter = (about_line.map(|value| value * value).sum::<f64>() / levels.len() as f64).sqrt();
    let drift = slope * levels.len() as f64;
    (drift.abs() > STEP_SIGMAS * scatter).then_some(drift)
}

/// Samples in a block, and the median of each block; `None` if they are too short.
fn levels(residual: &[f64]) -> Option<(usize, Vec<f64>)> {
    let length = residual.len() / BLOCKS;
    if length < 5 {
        return None;
    }
    let mut levels: Vec<f64> = residual.chunks_exact(length).map(|block| median_of(&mut block.to_vec())).collect();
    levels.truncate(BLOCKS);
    Some((length, levels))
}

fn linear_slope(values: &[f64]) -> f64 {
    let middle = (values.len() as f64 - 1.0) / 2.0;
    let (mut product, mut square) = (0.0, 0.0);
    for (index, value) in values.iter().enumerate() {
        let place = index as f64 - middle;
        product += place * value;
        square += place * place;
    }
    product / square
}

fn median_of(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(count: u32) -> Vec<f64> {
        (0..count).map(|n| (0.37 * f64::from(n * n % 1009)).sin()).collect()
    }

    #[test]
    fn steps_and_drifts_of_level_are_told_apart() {
        let stepped: Vec<f64> =
            wave(4000).iter().enumerate().map(|(n, v)| v + if n < 1500 { 0.0 } else { 2.0 }).collect();
        let (place, height) = step(&stepped).unwrap();
        assert!(place.abs_diff(1500) <= 100 && (height - 2.0).abs() < 0.4, "{place} {height}");
        let gradual: Vec<f64> = (0..4000).map(|n| 2.0 / (1.0 + (-0.02 * (f64::from(n) - 1500.0)).exp())).collect();
        assert_eq!(step(&gradual), None);
        let drift: Vec<f64> = wave(4000).iter().enumerate().map(|(n, v)| v + 0.001 * n as f64).collect();
        assert_eq!(step(&drift), None);
        assert_eq!(step(&wave(4000)), None);
        let found = super::drift(&drift).unwrap();
        assert!((found - 4.0).abs() < 0.3, "{found}");
        assert_eq!(super::drift(&stepped), None);
        assert_eq!(super::drift(&wave(4000)), None);
    }
}
