//! Whether a level changes from one sample to the next, as when a sensor slips, or gradually, as by motion.
//!
//! Compared with a step of height h, a ramp of W samples leaves an additional h² W / 12; in noise of variance σ² its standard deviation is
//! 2 σ h √(W / 12). A change is sudden if every ramp that is long enough to be distinguishable from a step leaves at least a quarter of
//! that more than the step. Changes and residual are orthogonalised to the columns of the accompanying model; a step of height h from
//! sample n on then reduces the sum of squares by
//!
//! ```text
//! (r's)² / (s's - Σ (q's)²)
//! ```
//!
//! with r the residual and q the columns.
//!
//! The position itself jumps when its sensor slips: relative to a line through the samples around it a step of about this height is found.
//! A limit that becomes active or inactive changes the residual of a linear model immediately, but no motion jumps. With few samples,
//! however, a motion after a step of its command does, each time.

use std::ops::Range;

use crate::linear_least_squares::dot;

/// Minimum ramp length [samples], and divisor of the record length for the maximum.
const SHORTEST: usize = 32;
const LONGEST_PART: usize = 20;

/// Ramps are tried at this many places on either side of the step, over half of their length.
const PLACES: i32 = 4;

/// h² W / 12 over σ² from which a ramp is distinguishable from a step: three standard deviations.
const TELLING: f64 = 36.0;

/// Minimum excess of a ramp relative to h² W / 12, if the change is a step.
const LEAST_SHARE: f64 = 0.25;

/// The step is searched within the record length divided by this.
const NEAR_PART: usize = 40;

/// Minimum part of a step that is orthogonal to the columns [squared samples].
const OWN: f64 = 0.2;

/// Samples on either side of a slip over which the position is fitted by a line.
const AROUND: usize = 6;

/// As above for a step of the command, which has no noise.
const AROUND_COMMAND: usize = 2;

/// The slip is searched within this many samples of its place from a linear model.
const NEAR_SAMPLES: usize = 3;

/// Maximum relative difference between a step of the position and the height of a slip, in addition to the differences at 95 of 100 places
/// due to noise and motion.
const MOST_DIFFERENT: f64 = 0.5;
const USUAL: usize = 95;

/// Whether a position jumps by about this height within a few samples of a place, within the limits of noise and motion. If its command
/// stepped by half of that shortly before, the jump must occur only once in the record. Both are in units of the position.
fn jumps(position: &[f64], command: &[f64], place: usize, height: f64) -> bool {
    let steps = steps::<AROUND>(position);
    let mut sizes: Vec<f64> = steps.iter().map(|step| step.abs()).collect();
    if sizes.is_empty() {
        return false;
    }
    let usual = USUAL * (sizes.len() - 1) / 100;
    let usual = *sizes.select_nth_unstable_by(usual, f64::total_cmp).1;
    let most = MOST_DIFFERENT * height.abs();
    let near = |around: usize, earlier: usize| {
        let end = (place + NEAR_SAMPLES + 1).saturating_sub(around);
        place.saturating_sub(around + NEAR_SAMPLES + earlier)..end
    };
    let (own, commanded) = (near(AROUND, 0), near(AROUND_COMMAND, AROUND));
    if !within(&steps, &own).iter().any(|step| (step - height).abs() <= most + usual) {
        return false;
    }
    let greatest = |steps: &[f64]| steps.iter().fold(0.0_f64, |greatest, step| greatest.max(step.abs()));
    let is_commanded = greatest(within(&self::steps::<AROUND_COMMAND>(command), &commanded)) > most;
    // A step also affects the lines of 2 N samples beside it.
    let before = ..own.start.saturating_sub(2 * AROUND);
    let elsewhere = greatest(&steps[before]).max(greatest(within(&steps, &(own.end + 2 * AROUND..steps.len()))));
    !is_commanded || elsewhere < MOST_DIFFERENT * greatest(within(&steps, &own))
}

/// A range of values, clipped to the available ones.
fn within<'a>(values: &'a [f64], range: &Range<usize>) -> &'a [f64] {
    &values[range.start.min(values.len())..range.end.min(values.len())]
}

/// Steps of a signal from one sample to the next relative to the line through N samples on either side; the first one is N samples after the
/// start.
fn steps<const N: usize>(wave: &[f64]) -> Vec<f64> {
    let factors = step_factors(N);
    wave.windows(2 * N).map(|values| dot(values, &factors)).collect()
}

/// Coefficients of 2 N samples whose weighted sum is the height of a step in their middle in addition to a straight line, by least squares.
///
/// ```text
/// r = s - t Σ (s t) / Σ t²,   w = r / Σ (r s),    s = -½ before the step and ½ after it, t the samples from it
/// ```
#[allow(clippy::cast_precision_loss)] // a few samples
fn step_factors(samples: usize) -> Vec<f64> {
    let times: Vec<f64> = (0..2 * samples).map(|n| n as f64 - samples as f64 + 0.5).collect();
    let step = |t: f64| 0.5_f64.copysign(t);
    let slope = times.iter().map(|t| step(*t) * t).sum::<f64>() / dot(&times, &times);
    let beside = |t: f64| step(t) - slope * t;
    let own: f64 = times.iter().map(|t| beside(*t) * step(*t)).sum();
    times.iter().map(|t| beside(*t) / own).collect()
}

/// Whether the level of a residual, and of the position, changes suddenly at a sample, and not after a step of the command (in units of the
/// position); `basis` are the orthonormal columns of the model.
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn is_sudden([residual, position, command]: [&[f64]; 3], basis: &[Vec<f64>], place: usize) -> bool {
    let count = residual.len();
    let is_jump = |step: &Step| jumps(position, command, step.place, step.height);
    let Some(step) = best_step(residual, basis, place).filter(is_jump) else {
        return false;
    };
    let middle = step.place as f64 - 0.5;
    let around = step.place.saturating_sub(count / LONGEST_PART)..(step.place + count / LONGEST_PART).min(count);
    let flat: Vec<f64> = around.map(|n| residual[n] - if n < step.place { 0.0 } else { step.height }).collect();
    let mean = flat.iter().sum::<f64>() / flat.len() as f64;
    let noise = flat.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / flat.len() as f64;
    let lengths = std::iter::successors(Some(SHORTEST), |length| Some(2 * length));
    lengths.take_while(|length| *length <= count / LONGEST_PART).all(|length| {
        let length = length as f64;
        let left = step.height * step.height * length / 12.0;
        let ramp = |at: i32| taken(residual, basis, middle + 0.5 * f64::from(at) / f64::from(PLACES) * length, length);
        left < TELLING * noise || step.taken - (-PLACES..=PLACES).map(ramp).fold(0.0, f64::max) >= LEAST_SHARE * left
    })
}

/// Reduction of the sum of squares by a ramp.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn taken(residual: &[f64], basis: &[Vec<f64>], middle: f64, length: f64) -> f64 {
    let ramp: Vec<f64> = (0..residual.len()).map(|n| ((n as f64 - middle) / length + 0.5).clamp(0.0, 1.0)).collect();
    let own = dot(&ramp, &ramp) - basis.iter().map(|column| dot(column, &ramp).powi(2)).sum::<f64>();
    dot(residual, &ramp).powi(2) / own.max(OWN)
}

struct Step {
    place: usize,
    height: f64,
    taken: f64,
}

/// The step near a sample with the largest reduction.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn best_step(residual: &[f64], basis: &[Vec<f64>], near: usize) -> Option<Step> {
    let count = residual.len();
    let mut sums = vec![0.0; basis.len()];
    let mut sum = 0.0;
    let mut best: Option<Step> = None;
    for place in (0..count).rev() {
        sum += residual[place];
        sums.iter_mut().zip(basis).for_each(|(sum, column)| *sum += column[place]);
        let own = (count - place) as f64 - dot(&sums, &sums);
        if place.abs_diff(near) > count / NEAR_PART || own <= OWN {
            continue;
        }
        let step = Step { place, height: sum / own, taken: sum * sum / own };
        if best.as_ref().is_none_or(|best| step.taken > best.taken) {
            best = Some(step);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uniform_noise::uniform_noise;

    #[test]
    fn a_position_jumps_where_its_sensor_slips_and_not_where_a_limit_is_met() {
        let motion = |n: u32| 20.0 * (0.012 * f64::from(n)).sin();
        for noise_rms in [0.0, 0.02, 0.3] {
            let jumps = |of: &dyn Fn(u32) -> f64, height: f64, command: &dyn Fn(u32) -> f64| {
                let mut noise = uniform_noise(4);
                let position: Vec<f64> = (0..1000).map(|n| of(n) + noise_rms * 3.0_f64.sqrt() * noise()).collect();
                super::jumps(&position, &(0..1000).map(command).collect::<Vec<f64>>(), 540, height)
            };
            for height in [1.0, -1.0] {
                let slipped = |n: u32| motion(n) + height * f64::from(u8::from(n >= 541));
                assert!(jumps(&slipped, height, &motion), "{noise_rms} {height}");
                assert!(!jumps(&|n| motion(n).min(motion(540)), 4.0 * height, &motion), "{noise_rms} {height}");
                // A step of the command that the motion follows.
                let follows = |n: u32| -4.0 * height * (1.0 - (-0.1 * f64::from(n.saturating_sub(540))).exp());
                let commanded = |n: u32| -4.0 * height * f64::from(u8::from(n >= 538));
                assert!(!jumps(&follows, 4.0 * height, &commanded), "{noise_rms} {height}");
                // As above within three samples: a slip, unless steps of the command precede it and others like it.
                let at_once = |n: u32| 4.0 * height * f64::from(n.saturating_sub(538).min(3)) / 3.0;
                let again = |n: u32| at_once(n) - at_once(n.saturating_sub(200));
                for wave in [&at_once as &dyn Fn(u32) -> f64, &again] {
                    assert!(jumps(wave, 4.0 * height, &|_| 0.0), "{noise_rms} {height}");
                }
                assert!(jumps(&at_once, 4.0 * height, &commanded), "{noise_rms} {height}");
                assert!(!jumps(&again, 4.0 * height, &commanded), "{noise_rms} {height}");
            }
        }
    }

    #[test]
    fn steps_are_sudden_and_what_takes_a_hundred_samples_is_not() {
        for size in [0.0, 0.3, 1.0] {
            let changed = |change: &dyn Fn(f64) -> f64| {
                let mut noise = uniform_noise(9);
                let values: Vec<f64> = (0..6000).map(|n| change(f64::from(n) - 3500.0) + size * noise()).collect();
                let mean = values.iter().sum::<f64>() / 6000.0;
                let residual: Vec<f64> = values.iter().map(|value| value - mean).collect();
                is_sudden([&residual, &values, &[0.0; 6000]], &[vec![6000.0_f64.sqrt().recip(); 6000]], 3480)
            };
            assert!(changed(&|n| f64::from(u8::from(n >= 0.0))), "{size}");
            assert!(changed(&|n| (n / 3.0).clamp(0.0, 1.0)), "{size}");
            assert!(!changed(&|n| (n / 150.0).clamp(0.0, 1.0)), "{size}");
            assert!(!changed(&|n| 1.0 - (-n.max(0.0) / 100.0).exp()), "{size}");
        }
    }
}
