//! Single samples that are not noise: spikes of a measurement, detected in the residual of a model.
//!
//! A sample is compared with the median m of its neighbours, three on either side, and s is the scale of all such differences from their
//! median absolute deviation, which spikes do not affect. A spike is
//!
//! ```text
//! |e[n] - m[n]| > 6 s,   s = 1.4826 median |e - m|
//! ```
//!
//! that is isolated or a pair and does not change the level around it: Hampel's rule of rejection (F. R. Hampel et al., Robust Statistics,
//! 1986; R. K. Pearson, IEEE Trans. Control Syst. Tech. 10, 2002). Normal noise exceeds six standard deviations in one sample of five
//! hundred million, so that records without spikes lose none. Jumps are kept, and so are samples at an exceptional bend of the motion,
//! where the model may be wrong, samples on a curve through the adjacent measured positions, and corners of these, as where a play is taken
//! up: there the samples before or after extrapolate to it. More spikes than one sample in two hundred are not accepted: then the model is
//! wrong.

use std::ops::Range;

use crate::{diagnose::quantiser::step_of, linear_least_squares::dot};

/// Differences beyond this multiple of their scale are not noise.
const THRESHOLD: f64 = 6.0;

/// Standard deviation of a normal distribution over its median absolute deviation.
const NORMAL: f64 = 1.482_6;

/// Number of neighbours on either side.
const NEIGHBOURS: usize = 3;

/// Maximum number of samples in a spike.
const LONGEST: usize = 2;

/// Maximum fraction of spikes among the samples.
const MOST: f64 = 0.005;

/// A change of level across a spike by this fraction of its height makes it a jump.
const JUMP_SHARE: f64 = 0.5;

/// A spike bends the residual by twice its height, two equal ones by once; the crest of an oscillation by half of its difference from the
/// neighbours, or less.
const LEAST_BEND: f64 = 0.75;
const LEAST_BEND_ALONE: f64 = 1.4;

/// Minimum distance of the measured positions from the curve through the adjacent ones, relative to the height of a spike: otherwise it is
/// the model's motion that bends.
const MEASURED_SHARE: f64 = 0.5;

/// Coefficients of the two samples before and the two after, in order of time, for interpolating the first of one or of two samples between
/// them by a cubic.
const BETWEEN: [[f64; 4]; LONGEST] = [[-1.0 / 6.0, 2.0 / 3.0, 2.0 / 3.0, -1.0 / 6.0], [-0.3, 1.0, 0.5, -0.2]];

/// A sample is not a spike if extrapolation from one side predicts it within this fraction of the height of a spike, and others within
/// another one.
const LEADS_TO: f64 = 1.0 / 3.0;
const LEADS_TO_OTHERS: f64 = 0.25;

/// Coefficients of five samples, the nearest first, for extrapolating the next one by a least-squares parabola.
const NEXT: [f64; 5] = [1.8, 0.0, -0.8, -0.6, 0.6];

/// Rounding moves a sample relative to its neighbours by one step; with noise rarely by two, i.e. by less than this number.
const ROUNDED_STEPS: f64 = 2.5;

/// Differences below this fraction of the motion are rounding errors.
const ROUNDING: f64 = 1e-9;

/// Scales are estimated from about this many samples.
const SCALE_SAMPLES: usize = 100_000;

/// The samples that are spikes of `residual`, the residual of a model with this `motion` for the positions `measured`.
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn spikes(residual: &[f64], motion: &[f64], measured: &[f64]) -> Vec<usize> {
    let count = residual.len().min(motion.len());
    if count <= 2 * NEIGHBOURS {
        return Vec::new();
    }
    let inner = NEIGHBOURS..count - NEIGHBOURS;
    let stride = count.div_ceil(SCALE_SAMPLES);
    let scale = |value: &dyn Fn(usize) -> f64| {
        NORMAL * median(&mut inner.clone().step_by(stride).map(|n| value(n).abs()).collect::<Vec<f64>>())
    };
    let bend = |values: &[f64], n: usize| values[n - 1] - 2.0 * values[n] + values[n + 1];
    let size = scale(&|n| motion[n]);
    let difference = |n: usize| residual[n] - level(residual, n..n + 1);
    let first = &measured[..measured.len().min(SCALE_SAMPLES)];
    let step = step_of(first).max(step_of_grid(first));
    let least = (THRESHOLD * scale(&difference)).max(ROUNDING * size).max(ROUNDED_STEPS * step);
    // Bends first: medians take longer.
    let candidate = |n: &usize| {
        let bend = bend(residual, *n).abs();
        bend > LEAST_BEND * least && (least..bend / LEAST_BEND).contains(&difference(*n).abs())
    };
    let candidates: Vec<usize> = inner.clone().filter(candidate).collect();
    let exceptional = THRESHOLD * scale(&|n| bend(motion, n));
    let moves = |run: &Range<usize>, by: f64| {
        let around = run.start.saturating_sub(NEIGHBOURS).max(1)..(run.end + NEIGHBOURS).min(count - 1);
        around.into_iter().any(|n| bend(motion, n).abs() > exceptional.max(by))
    };
    let by_next = if candidates.is_empty() { 0.0 } else { next_differences(measured, stride) };
    let (mut spikes, mut corners) = (Vec::new(), 0);
    let mut place = 0;
    while place < candidates.len() {
        let first = candidates[place];
        let length = candidates[place..].iter().zip(first..).take_while(|(candidate, n)| *candidate == n).count();
        place += length;
        let run = first..first + length;
        let height = run.clone().map(|n| difference(n).abs()).fold(f64::INFINITY, f64::min);
        let before = median(&mut residual[first - NEIGHBOURS..first].to_vec());
        let after = median(&mut residual[run.end..(run.end + NEIGHBOURS).min(count)].to_vec());
        let bent = length > 1 || bend(residual, first).abs() > LEAST_BEND_ALONE * height;
        let stays = (after - before).abs() < JUMP_SHARE * height;
        if length <= LONGEST && bent && stays && !moves(&run, height) {
            let is_measured = measured.len() < count || off_curve(measured, &run) > MEASURED_SHARE * height;
            if !is_measured || (by_next < LEADS_TO_OTHERS * height && is_corner(measured, &run, height)) {
                corners += length;
            } else {
                spikes.extend(run);
            }
        }
    }
    if (spikes.len() + corners) as f64 > MOST * count as f64 { Vec::new() } else { spikes }
}

/// Minimum distance of the samples of a run, one or two, from the cubic through the two on either side.
fn off_curve(values: &[f64], run: &Range<usize>) -> f64 {
    let beside = [run.start - 2, run.start - 1, run.end, run.end + 1].map(|n| values[n]);
    let mut backwards = beside;
    backwards.reverse();
    let off = |value: f64, beside: &[f64]| (value - dot(beside, &BETWEEN[run.len() - 1])).abs();
    off(values[run.start], &beside).min(off(values[run.end - 1], &backwards))
}

/// Distance of a value from the extrapolation of those on one side, nearest first; `None` at an end.
fn difference_from_next<'a>(value: f64, nearest_first: impl Iterator<Item = &'a f64>) -> Option<f64> {
    let near: Vec<f64> = nearest_first.take(NEXT.len()).copied().collect();
    (near.len() == NEXT.len()).then(|| (value - dot(&near, &NEXT)).abs())
}

/// Scale of these differences, from samples with this stride.
fn next_differences(measured: &[f64], stride: usize) -> f64 {
    let of = |n: usize| difference_from_next(measured[n], measured[..n].iter().rev());
    let mut each: Vec<f64> = (0..measured.len()).step_by(stride).filter_map(of).collect();
    NORMAL * median(&mut each)
}

/// Whether the samples before a run extrapolate to its first one, or those after it to its last.
fn is_corner(measured: &[f64], run: &Range<usize>, height: f64) -> bool {
    let is_near = |difference: Option<f64>| difference.is_some_and(|difference| difference < LEADS_TO * height);
    run.end <= measured.len()
        && (is_near(difference_from_next(measured[run.start], measured[..run.start].iter().rev()))
            || is_near(difference_from_next(measured[run.end - 1], measured[run.end..].iter())))
}

/// Step of values on a grid that are not multiples of its step: converted, or written with other digits. `None` if the gaps between them
/// differ, as for noise.
fn step_of_grid(values: &[f64]) -> f64 {
    const FEWEST_VALUES: usize = 10;
    const LEAST_GAP: f64 = 0.5;
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let mut gaps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > 0.0).collect();
    let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let middle = median(&mut gaps);
    if gaps.len() + 1 >= FEWEST_VALUES && least > LEAST_GAP * middle { middle } else { 0.0 }
}

/// The values with linear interpolation in place of spikes.
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn bridge(values: &mut [f64], spikes: &[usize]) {
    for run in spikes.chunk_by(|one, next| one + 1 == *next) {
        let (before, after) = (run[0].saturating_sub(1), (run[run.len() - 1] + 1).min(values.len() - 1));
        let slope = (values[after] - values[before]) / (after - before) as f64;
        for spike in run {
            values[*spike] = values[before] + slope * (spike - before) as f64;
        }
    }
}

/// Median of the neighbours of some samples.
fn level(values: &[f64], of: Range<usize>) -> f64 {
    let before = &values[of.start.saturating_sub(NEIGHBOURS)..of.start];
    let after = &values[of.end.min(values.len())..(of.end + NEIGHBOURS).min(values.len())];
    let mut neighbours = [0.0; 2 * NEIGHBOURS];
    let count = before.len() + after.len();
    neighbours.iter_mut().zip(before.iter().chain(after)).for_each(|(place, value)| *place = *value);
    median(&mut neighbours[..count])
}

/// Mean of the two middle values for an even number.
fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    let even = values.len().is_multiple_of(2);
    let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let upper = *upper;
    if even { 0.5 * (upper + below.iter().copied().fold(f64::NEG_INFINITY, f64::max)) } else { upper }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deterministic noise of unit rms: uniform, between ±1.7.
    fn noise(count: u32) -> Vec<f64> {
        (0..count).map(|n| 3.4 * ((f64::from(n) * 0.754_877_666).fract() - 0.5)).collect()
    }

    fn motion(count: u32) -> Vec<f64> {
        (0..count).map(|n| 50.0 * (0.1 * f64::from(n)).sin()).collect()
    }

    #[test]
    fn spikes_are_found_alone_and_in_pairs_and_bridged() {
        let mut residual = noise(4000);
        assert!(spikes(&residual, &motion(4000), &[]).is_empty());
        for (place, size) in [(100, 30.0), (900, -30.0), (901, -31.0), (2000, 29.0), (2002, -30.0)] {
            residual[place] += size;
        }
        let found = spikes(&residual, &motion(4000), &[]);
        assert_eq!(found, [100, 900, 901, 2000, 2002]);
        bridge(&mut residual, &found);
        assert!(residual.iter().all(|value| value.abs() < 2.5));
    }

    #[test]
    fn rounding_is_no_spike() {
        // Noise of a tenth of the step about a value between two of its multiples.
        let exact = motion(4000);
        let noisy = exact.iter().zip(noise(4000)).map(|(value, noise)| value + 0.05 * noise);
        let measured: Vec<f64> = noisy.map(|value| (value / 0.5).round() * 0.5).collect();
        let residual: Vec<f64> = measured.iter().zip(&exact).map(|(measured, exact)| measured - exact).collect();
        assert!(spikes(&residual, &exact, &measured).is_empty());
        // As above in another unit, with five digits: not multiples of a step.
        let written = |value: &f64| (value * 17.453_292_5 * 1e3 + 3.1).round() / 1e3;
        let converted: Vec<f64> = measured.iter().map(written).collect();
        let mut residual: Vec<f64> =
            converted.iter().zip(&exact).map(|(measured, exact)| 0.2 * (measured - 17.453_292_5 * exact)).collect();
        residual[700] += 8.726_646_25;
        assert!(spikes(&residual, &exact, &converted).is_empty());
        assert_eq!(spikes(&residual, &exact, &[]), [700]);
        let mut still = vec![0.0; 4000];
        still[2000] = 0.5;
        assert_eq!(spikes(&still, &exact, &[]), [2000]);
        assert!(spikes(&still, &exact, &still).is_empty());
    }

    #[test]
    fn jumps_pulses_and_what_comes_with_a_step_of_the_motion_are_no_spikes() {
        let mut jump = noise(4000);
        jump[1500..].iter_mut().for_each(|value| *value += 40.0);
        jump[3000..3005].iter_mut().for_each(|value| *value += 40.0);
        assert!(spikes(&jump, &motion(4000), &[]).is_empty());
        let mut step = noise(4000);
        step[2000] += 30.0;
        let moved: Vec<f64> =
            motion(4000).iter().zip(0..).map(|(m, n)| m + if n >= 2000 { 90.0 } else { 0.0 }).collect();
        assert!(spikes(&step, &moved, &[]).is_empty());
        assert_eq!(spikes(&step, &motion(4000), &[]), [2000]);
    }

    /// An actuator behind a play is at rest and is then taken along suddenly, where a linear model has a bend of its own: the residual has
    /// a peak of one sample. A single outlier is a spike there as well, and next to a motion that bends.
    #[test]
    fn a_corner_of_the_measured_motion_is_no_spike() {
        const PLACE: usize = 2000;
        let smooth: Vec<f64> = (0..4000).map(|n| 0.1 * f64::from(n)).collect();
        for (noise_rms, height) in [(0.01, 30.0), (0.3, 30.0), (1.0, 60.0)] {
            let noise: Vec<f64> = noise(4000).iter().map(|value| noise_rms * value).collect();
            let mut residual = noise.clone();
            residual[PLACE] -= height;
            let corner = (0..4000).map(|n: u32| height * (f64::from(n) - 2000.0).max(0.0));
            let mut measured: Vec<f64> = corner.zip(&noise).map(|(corner, noise)| corner + noise).collect();
            assert!(spikes(&residual, &smooth, &measured).is_empty(), "{noise_rms}");
            measured[PLACE] -= height;
            assert_eq!(spikes(&residual, &smooth, &measured), [PLACE], "{noise_rms}");
            let mut measured: Vec<f64> = motion(4000).iter().zip(&noise).map(|(bent, noise)| bent + noise).collect();
            measured[PLACE] -= height;
            assert_eq!(spikes(&residual, &motion(4000), &measured), [PLACE], "{noise_rms}");
            // A spike of the model alone.
            measured[PLACE] += height;
            assert!(spikes(&residual, &motion(4000), &measured).is_empty(), "{noise_rms}");
        }
    }

    /// A model that reverses differently from the measured motion, which is smooth.
    #[test]
    fn a_smooth_turn_of_the_measured_motion_is_no_spike() {
        const PLACE: usize = 2000;
        let measured: Vec<f64> = (0..4000).map(|n| (0.4 * (f64::from(n) - 2000.0)).cos()).collect();
        let mut residual: Vec<f64> = noise(4000).iter().map(|value| 0.001 * value).collect();
        residual[PLACE] -= 0.1;
        let smooth = vec![0.0; 4000];
        assert!(spikes(&residual, &smooth, &measured).is_empty());
        assert_eq!(spikes(&residual, &smooth, &residual), [PLACE]);
    }

    #[test]
    fn what_is_frequent_is_no_spike() {
        let mut residual = noise(4000);
        residual.iter_mut().step_by(50).for_each(|value| *value += 30.0);
        assert!(spikes(&residual, &motion(4000), &[]).is_empty());
    }
}
