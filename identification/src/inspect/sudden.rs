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

/// Whether the level of a residual changes at once about a sample; `basis` are the orthonormal columns of its model.
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn is_sudden(residual: &[f64], basis: &[Vec<f64>], place: usize) -> bool {
    let count = residual.len();
    let Some(step) = best_step(residual, basis, place) else { return false };
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
    fn steps_are_sudden_and_what_takes_a_hundred_samples_is_not() {
        for size in [0.0, 0.3, 1.0] {
            let changed = |change: &dyn Fn(f64) -> f64| {
                let mut noise = uniform_noise(9);
                let values: Vec<f64> = (0..6000).map(|n| change(f64::from(n) - 3500.0) + size * noise()).collect();
                let mean = values.iter().sum::<f64>() / 6000.0;
                let residual: Vec<f64> = values.iter().map(|value| value - mean).collect();
                is_sudden(&residual, &[vec![6000.0_f64.sqrt().recip(); 6000]], 3480)
            };
            assert!(changed(&|n| f64::from(u8::from(n >= 0.0))), "{size}");
            assert!(changed(&|n| (n / 3.0).clamp(0.0, 1.0)), "{size}");
            assert!(!changed(&|n| (n / 150.0).clamp(0.0, 1.0)), "{size}");
            assert!(!changed(&|n| 1.0 - (-n.max(0.0) / 100.0).exp()), "{size}");
        }
    }
}
