//! Whether a level changes from one sample to the next, as a sensor slips, or creeps to another one, as a motion does.
//!
//! Of a step of height h a ramp of W samples leaves h² W / 12; in noise of σ² that has a standard deviation of 2 σ h √(W / 12). A change is sudden where
//! every ramp that is long enough to be told from a step leaves a quarter of that more than the step does. Changes and residual are taken
//! orthogonal to the columns of the model that stands beside them, in which a step of height h from sample n on takes
//!
//! ```text
//! (r's)² / (s's - Σ (q's)²)
//! ```
//!
//! of the sum of squares, r the residual and q the columns.
//!
//! The position itself jumps where its sensor slips: beside a line through the samples about it a step of about its height is found. A limit that begins to
//! act, or ends, changes what a linear model leaves at once, but no motion jumps. But where samples are few, one that follows a step of its command
//! does, each time.

use std::ops::Range;

use crate::linear_least_squares::dot;

/// Shortest ramp [samples], and the longest as a part of the record.
const SHORTEST: usize = 32;
const LONGEST_PART: usize = 20;

/// Ramps are tried at so many places on either side of the step, over half of their length.
const PLACES: i32 = 4;

/// h² W / 12 over σ² from which on a ramp is told from a step: three standard deviations.
const TELLING: f64 = 36.0;

/// Of h² W / 12, what a ramp leaves at least where the change is a step.
const LEAST_SHARE: f64 = 0.25;

/// The step is sought within this part of the record.
const NEAR_PART: usize = 40;

/// Least part of a step that the columns leave [squared samples].
const OWN: f64 = 0.2;

/// Samples on either side of a slip over which the position moves in a line.
const AROUND: usize = 6;

/// The same of a step of the command, which has no noise.
const AROUND_COMMAND: usize = 2;

/// The slip is sought within so many samples of where a linear model has it.
const NEAR_SAMPLES: usize = 3;

/// A step of the position differs from the height of a slip by this part of it at most, and by what 95 of 100 places have from noise and motion.
const MOST_DIFFERENT: f64 = 0.5;
const USUAL: usize = 95;

/// Whether a position jumps by about a height within a few samples of a place, as far as noise and motion let that be told. Where its command stepped by half
/// of that shortly before, such a jump is one that the record has once. Both are in units of the position.
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
    // A step shows in the lines of 2 N samples beside it as well.
    let before = ..own.start.saturating_sub(2 * AROUND);
    let elsewhere = greatest(&steps[before]).max(greatest(within(&steps, &(own.end + 2 * AROUND..steps.len()))));
    !is_commanded || elsewhere < MOST_DIFFERENT * greatest(within(&steps, &own))
}

/// As much of a range of values as there is.
fn within<'a>(values: &'a [f64], range: &Range<usize>) -> &'a [f64] {
    &values[range.start.min(values.len())..range.end.min(values.len())]
}

/// Steps of a wave from one sample to the next beside the line through N samples on either side; the first one lies N samples behind the start.
fn steps<const N: usize>(wave: &[f64]) -> Vec<f64> {
    let factors = step_factors(N);
    wave.windows(2 * N).map(|values| dot(values, &factors)).collect()
}

/// Factors of 2 N samples whose sum is the height of a step in their middle beside a straight line, by least squares.
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

/// Whether the level of a residual, and of the position that leaves it, changes at once about a sample, and not behind a step of the command (in units of the
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

/// What a ramp takes of the sum of squares.
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

/// The step near a sample that takes most.
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
                // The same within three samples: a slip, unless steps of the command come shortly before it and before others like it.
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
