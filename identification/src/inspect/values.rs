//! What single values of a record show: spikes, steps of level, drift, flat stretches, quantisation, numbers beyond arithmetic.

use super::finding::Finding;

/// Greatest magnitude of a value [its unit]: limits of the effects that do not act begin at 1e9, and squares must not overflow.
pub const GREATEST: f64 = 1e8;

/// A command that moves by less than this share of its magnitude is constant to the digits of a number.
const DIGITS: f64 = 1e-12;

/// Standard deviation of a normal distribution over its median absolute deviation.
const MAD_TO_SIGMA: f64 = 1.4826;

/// A sample that is off the line through its neighbours by more than this many robust standard deviations is a spike; normal noise
/// does that once in 1e15 samples.
const SPIKE_SIGMAS: f64 = 8.0;

/// Noise may grow with the motion: each part of so many samples has its own scatter, where that is above the record's.
const BLOCK: usize = 128;

/// Samples behind a corner of the command, or the start, in which a response bends.
const MEMORY: usize = 10;

/// More spikes than this share of the samples are noise with heavy tails, or the motion itself.
const MOST_SPIKES: f64 = 0.01;

/// Numbers that cannot be computed with.
#[must_use]
pub fn overflow(name: &'static str, values: &[f64], time: &[f64]) -> Option<Finding> {
    let place = values.iter().position(|value| value.abs() >= GREATEST)?;
    let sentence =
        format!("{name} reaches {:e}, where magnitudes below {GREATEST:e} can be computed with", values[place]);
    let remedy = "check the units and the file, or give the values in a larger unit";
    Some(Finding::refusal("overflow", sentence, remedy).at(place, time))
}

/// Columns that do not move.
#[must_use]
pub fn standstill(command: &[f64], position: &[f64]) -> Option<Finding> {
    let range = |values: &[f64]| {
        let (low, high) = extremes(values);
        (high - low, low.abs().max(high.abs()))
    };
    let (moved, magnitude) = range(command);
    if moved <= DIGITS * magnitude {
        let sentence = format!("the command moves by {moved:e}, which is the rounding of its values");
        return Some(Finding::refusal("command_rests", sentence, "choose a record with excitation"));
    }
    let (moved, magnitude) = range(position);
    (moved <= DIGITS * magnitude).then(|| {
        Finding::refusal(
            "position_rests",
            format!("the position never moves: it stays at {} whatever the command does", position[0]),
            "check the sensor and the column, and that the actuator was on",
        )
    })
}

/// Least and greatest value.
#[must_use]
pub fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// Samples off the line through their neighbours, y[n] - (y[n-1] + y[n+1]) / 2, in the residual of the flexible linear model; those close
/// behind a corner of the command, or the start, are the motion's own.
#[must_use]
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn spikes(residual: &[f64], command: &[f64]) -> Vec<usize> {
    let off: Vec<f64> = residual.windows(3).map(|part| part[1] - 0.5 * (part[0] + part[2])).collect();
    let sigma = robust_sigma(&off);
    let blocks: Vec<f64> = off.chunks(BLOCK).map(|block| sigma.max(robust_sigma(block))).collect();
    let corners: Vec<f64> = command.windows(3).map(|part| part[1] - 0.5 * (part[0] + part[2])).collect();
    let corner = SPIKE_SIGMAS * robust_sigma(&corners);
    let follows_corner =
        |index: usize| corners[index.saturating_sub(MEMORY)..=index].iter().any(|value| value.abs() > corner);
    let found: Vec<usize> = (MEMORY..off.len())
        .filter(|index| !follows_corner(*index))
        .filter(|index| {
            let here = off[*index].abs();
            // Its neighbours are off by half as much; the greatest of the three is the spike.
            let beside = |at: Option<usize>| at.and_then(|at| off.get(at)).map_or(0.0, |value| value.abs());
            let limit = SPIKE_SIGMAS * blocks[*index / BLOCK];
            here > limit && here >= beside(index.checked_sub(1)) && here > beside(Some(index + 1))
        })
        .map(|index| index + 1)
        .collect();
    if sigma > 0.0 && (found.len() as f64) < MOST_SPIKES * residual.len() as f64 { found } else { Vec::new() }
}

/// Standard deviation from the median absolute deviation: spikes do not move it.
#[must_use]
pub fn robust_sigma(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.to_vec();
    let median = median_of(&mut sorted);
    let mut deviations: Vec<f64> = values.iter().map(|value| (value - median).abs()).collect();
    MAD_TO_SIGMA * median_of(&mut deviations)
}

fn median_of(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Blocks over which a level is averaged: a step of level shows between halves of a record, not between samples.
const BLOCKS: usize = 40;

/// A step stands out of the scatter of the blocks' medians by this factor.
const STEP_SIGMAS: f64 = 6.0;

/// A sudden change of level in the residual: sample and height. Medians of blocks before and after each place are compared with how
/// blocks scatter about them.
#[must_use]
pub fn level_step(residual: &[f64]) -> Option<(usize, f64)> {
    let length = residual.len() / BLOCKS;
    if length < 5 {
        return None;
    }
    let mut levels: Vec<f64> = residual.chunks_exact(length).map(|block| median_of(&mut block.to_vec())).collect();
    levels.truncate(BLOCKS);
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
    // A drift is no step: it leaves the halves sloped.
    (height.abs() > STEP_SIGMAS * scatter && height.abs() > 0.5 * drift).then_some((place * length, height))
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

/// Share of a record that flat stretches must fill, and of the range that counts as its end.
const FLAT_SHARE: f64 = 0.03;
const END_SHARE: f64 = 1e-3;

/// The position stays at one end of its range while the command goes on: end value, first sample, samples.
#[must_use]
pub fn saturation(command: &[f64], position: &[f64]) -> Vec<(f64, usize, usize)> {
    let (low, high) = extremes(position);
    let near = END_SHARE * (high - low);
    let mut found = Vec::new();
    for end in [low, high] {
        let at_end: Vec<usize> = (1..position.len())
            .filter(|n| (position[*n] - end).abs() <= near && command[*n] != command[*n - 1])
            .collect();
        if at_end.len() as f64 > FLAT_SHARE * position.len() as f64 {
            found.push((end, at_end[0], at_end.len()));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(count: u32) -> Vec<f64> {
        (0..count).map(|n| (0.37 * f64::from(n * n % 1009)).sin()).collect()
    }

    #[test]
    fn spikes_are_found_where_they_are() {
        let mut residual = wave(4000);
        residual[700] += 30.0;
        residual[2500] -= 30.0;
        assert_eq!(spikes(&residual, &wave(4000)), [700, 2500]);
        assert!(spikes(&wave(4000), &wave(4000)).is_empty());
        let mut corner = wave(4000);
        corner[695..].iter_mut().for_each(|value| *value += 100.0);
        assert_eq!(spikes(&residual, &corner), [2500]);
    }

    #[test]
    fn a_step_of_level_is_found_and_a_drift_is_none() {
        let step: Vec<f64> = wave(4000).iter().enumerate().map(|(n, v)| v + if n < 1500 { 0.0 } else { 2.0 }).collect();
        let (place, height) = level_step(&step).unwrap();
        assert!(place.abs_diff(1500) <= 100 && (height - 2.0).abs() < 0.4, "{place} {height}");
        let drift: Vec<f64> = wave(4000).iter().enumerate().map(|(n, v)| v + 0.001 * n as f64).collect();
        assert_eq!(level_step(&drift), None);
        assert_eq!(level_step(&wave(4000)), None);
    }

    #[test]
    fn a_position_held_at_a_stop_is_saturated() {
        let command: Vec<f64> = (0..2000).map(|n| (0.01 * f64::from(n)).sin()).collect();
        let position: Vec<f64> = command.iter().map(|value| value.clamp(-0.6, 2.0)).collect();
        let found = saturation(&command, &position);
        assert!(found.len() == 1 && (found[0].0 + 0.6).abs() < 1e-12, "{found:?}");
        assert!(saturation(&command, &command).is_empty());
    }
}
