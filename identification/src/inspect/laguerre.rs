//! A flexible linear model of a response: a constant, the command and its Laguerre filters.
//!
//! ```text
//! y[n] = a + d c[n] + Σ_i g_i l_i[n],   L_1 = √(1 - α²) / (1 - α z⁻¹),   L_i+1 = L_i (z⁻¹ - α) / (1 - α z⁻¹)
//! ```
//!
//! (B. Wahlberg, IEEE Trans. AC-36, 1991). With α = exp(-1/τ) and τ from one sample to a hundred it approximates any stable linear system
//! with a memory not much longer than ORDER τ, regardless of its order. It contains no ramp, which would explain most of a random walk.
//! What it does not explain is noise, nonlinear, or not a response.

use rustfft::num_complex::Complex;

use super::sudden::is_sudden;
use crate::{
    linear_least_squares::{dot, solve, subtract},
    signal::play::{behind_play, range},
};

/// Number of Laguerre filters.
pub const ORDER: usize = 11;

/// Time constants of the candidates [samples].
const TIME_CONSTANTS: [f64; 5] = [1.0, 3.0, 10.0, 30.0, 100.0];

/// Minimum fraction of a ramp not explained by the response, for a drift to be distinguishable from it.
const OWN_SHARE: f64 = 0.2;

/// As above for a step. Filters with a long memory approximate one, above all in a record with a step of its own, but not its suddenness.
const OWN_SHARE_OF_STEP: f64 = 0.02;

/// Half gaps of plays that represent friction and play, as fractions of the response's range: a reversal changes the level over them.
const HALF_GAPS: [f64; 3] = [0.0025, 0.01, 0.05];

/// As above, dense enough to represent the play itself.
const MANY_HALF_GAPS: [f64; 7] = [0.0025, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16];

/// Minimum reduction of the residual by a step with such plays in the model, relative to that without them.
const LEAST_BESIDE_PLAYS: f64 = 0.5;

/// The best of the models.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearModel {
    /// Fraction of the position's variance explained, in the sample [1].
    pub share: f64,
    /// Position minus model.
    pub residual: Vec<f64>,
    /// Response to a constant command [1].
    pub gain: f64,
    /// α of the filters, and the coefficients of constant, command and filters.
    alpha: f64,
    factors: Vec<f64>,
}

impl LinearModel {
    /// Position minus the response, for the model with an additional ramp: the drift remains in the residual and does not affect the
    /// response. `None` if the response to the command is itself similar to a ramp, so that they are not distinguishable.
    #[must_use]
    #[allow(clippy::cast_precision_loss)] // counts of samples
    pub fn residual_with_drift(&self, command: &[f64], position: &[f64]) -> Option<Vec<f64>> {
        let ramp = (0..position.len()).map(|n| n as f64 / position.len() as f64 - 0.5).collect();
        Some(self.beside(ramp, OWN_SHARE, command, position)?.0)
    }

    /// As above with a step of level at the best of some samples: the residual, the sample and the height of the step.
    ///
    /// With orthonormal columns q, the residual r and the step s from sample n on, the reduction of the sum of squares is
    ///
    /// ```text
    /// (r's)² / (s's - Σ (q's)²),    where all of r's, s's and q's are sums from n on
    /// ```
    #[must_use]
    #[allow(clippy::cast_precision_loss)] // counts of samples
    pub fn residual_with_step(
        &self,
        command: &[f64],
        position: &[f64],
        places: std::ops::Range<usize>,
    ) -> Option<(Vec<f64>, usize, f64)> {
        let basis = orthonormal(columns(command, self.alpha));
        let count = position.len();
        let mut sums = vec![0.0; basis.len()];
        let mut residual = 0.0;
        let mut best = None;
        let mut greatest = 0.0;
        for place in (0..count).rev() {
            residual += self.residual[place];
            sums.iter_mut().zip(&basis).for_each(|(sum, column)| *sum += column[place]);
            let own = (count - place) as f64 - dot(&sums, &sums);
            let fall = residual * residual / own;
            if places.contains(&place) && own > OWN_SHARE && fall > greatest {
                (best, greatest) = (Some(place), fall);
            }
        }
        let place = best?;
        let step = (0..count).map(|n| if n < place { -0.5 } else { 0.5 }).collect();
        let (residual, height) = self.beside(step, OWN_SHARE_OF_STEP, command, position)?;
        Some((residual, place, height))
    }

    /// Whether a step of level at a sample is sudden, in the residual and in the position, and not due to a motion that changes its level
    /// with its direction, as with friction and play: with the response behind plays in the model it still gives half of the reduction that
    /// it gives without them.
    #[must_use]
    pub fn is_step_of_sensor(&self, command: &[f64], position: &[f64], place: usize) -> bool {
        let (positions, commands) = (range(position), range(command));
        let size = (positions.1 - positions.0) / (commands.1 - commands.0);
        let commanded: Vec<f64> = command.iter().map(|value| size * value).collect();
        let plays = self.behind_plays(position, &HALF_GAPS);
        let step: Vec<f64> = (0..position.len()).map(|n| f64::from(u8::from(n >= place))).collect();
        let columns = columns(command, self.alpha);
        let left = |others: &[&[Vec<f64>]]| {
            let all: Vec<Vec<f64>> = columns.iter().chain(others.iter().copied().flatten()).cloned().collect();
            let mut left = position.to_vec();
            subtract(&mut left, &all, &solve(&all, position));
            dot(&left, &left)
        };
        let step = [step];
        left(&[&plays]) - left(&[&plays, &step]) > LEAST_BESIDE_PLAYS * (left(&[]) - left(&[&step]))
            && is_sudden([&self.residual, position, &commanded], &orthonormal(columns), place)
    }

    /// Position minus the model with its response behind plays of many widths: effects of play and friction on a motion are not noise.
    #[must_use]
    pub fn residual_beside_plays(&self, command: &[f64], position: &[f64]) -> Vec<f64> {
        let mut all = columns(command, self.alpha);
        all.extend(self.behind_plays(position, &MANY_HALF_GAPS));
        let mut left = position.to_vec();
        subtract(&mut left, &all, &solve(&all, position));
        left
    }

    /// The response behind plays whose half gaps are these fractions of its range.
    fn behind_plays(&self, position: &[f64], half_gaps: &[f64]) -> Vec<Vec<f64>> {
        let response: Vec<f64> = position.iter().zip(&self.residual).map(|(position, left)| position - left).collect();
        let (low, high) = range(&response);
        half_gaps.iter().map(|part| behind_play(&response, part * (high - low))).collect()
    }

    /// Position minus the response to another signal, from a joint model with the response to the command.
    #[must_use]
    pub fn residual_beside(&self, other: &[f64], command: &[f64], position: &[f64]) -> Vec<f64> {
        let mut all = columns(command, self.alpha);
        let own = all.len();
        all.extend(columns(other, self.alpha).into_iter().skip(1)); // one constant
        let factors = solve(&all, position);
        let mut residual = position.to_vec();
        subtract(&mut residual, &all[own..], &factors[own..]);
        residual
    }

    /// Position minus the response, for the model with an additional column, and the coefficient of that column; `None` if the column is
    /// explained by the model.
    fn beside(&self, column: Vec<f64>, least_share: f64, command: &[f64], position: &[f64]) -> Option<(Vec<f64>, f64)> {
        let mut columns = columns(command, self.alpha);
        let mut unlike = column.clone();
        subtract(&mut unlike, &columns, &solve(&columns, &column));
        if dot(&unlike, &unlike) < least_share * dot(&column, &column) {
            return None;
        }
        columns.push(column);
        let factors = solve(&columns, position);
        let mut residual = position.to_vec();
        subtract(&mut residual, &columns[..columns.len() - 1], &factors[..columns.len() - 1]);
        Some((residual, factors[columns.len() - 1]))
    }

    /// The response to another command, which was at rest at its first value.
    #[must_use]
    pub fn response_to(&self, command: &[f64]) -> Vec<f64> {
        let mut less = vec![0.0; command.len()];
        subtract(&mut less, &columns(command, self.alpha)[..self.factors.len()], &self.factors);
        less.iter().map(|value| -value).collect()
    }

    /// Magnitude of the response at a frequency given as angle per sample [rad] [1].
    #[must_use]
    pub fn magnitude(&self, angle: f64) -> f64 {
        let delay = Complex::from_polar(1.0, -angle);
        let low_pass = (Complex::new(1.0, 0.0) - delay * self.alpha).inv();
        let mut filter = low_pass * (1.0 - self.alpha * self.alpha).sqrt();
        let mut response = Complex::new(self.factors[1], 0.0);
        for factor in &self.factors[2..] {
            response += filter * *factor;
            filter *= (delay - self.alpha) * low_pass;
        }
        response.norm()
    }
}

/// Fits the model for all time constants and keeps the best one.
#[must_use]
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn fit(command: &[f64], position: &[f64]) -> LinearModel {
    let count = position.len();
    let mean = position.iter().sum::<f64>() / count as f64;
    let total: f64 = position.iter().map(|value| (value - mean).powi(2)).sum();
    let mut best = LinearModel {
        share: 0.0,
        residual: position.iter().map(|value| value - mean).collect(),
        gain: 0.0,
        alpha: 0.0,
        factors: vec![mean, 0.0],
    };
    if total == 0.0 {
        return best;
    }
    for samples in TIME_CONSTANTS {
        let columns = columns(command, (-1.0 / samples).exp());
        let factors = solve(&columns, position);
        let mut residual = position.to_vec();
        subtract(&mut residual, &columns, &factors);
        let share = 1.0 - dot(&residual, &residual) / total;
        if share > best.share {
            // A constant passes each filter with √(1 - α²) / (1 - α); the all-pass from one to the next has gain 1.
            let alpha = (-1.0 / samples).exp();
            let constant = (1.0 - alpha * alpha).sqrt() / (1.0 - alpha);
            let gain = factors[1] + factors[2..].iter().sum::<f64>() * constant;
            best = LinearModel { share, residual, gain, alpha, factors };
        }
    }
    best
}

/// A constant, the command and its filters.
pub(crate) fn columns(command: &[f64], alpha: f64) -> Vec<Vec<f64>> {
    let count = command.len();
    let scale = (1.0 - alpha * alpha).sqrt();
    let mut filters = vec![vec![0.0; count]; ORDER];
    // The command is assumed to have been at rest at its first value, which passes all filters but the first unchanged.
    let mut state = command[0] * scale / (1.0 - alpha);
    let start = alpha * state + scale * command[0];
    let (mut before, mut output) = ([start; ORDER], [start; ORDER]);
    // Sample by sample: filters of neighbouring samples do not wait for each other, samples of one filter would.
    for (n, value) in command.iter().enumerate() {
        state = alpha * state + scale * value;
        let mut input = state;
        for (place, filter) in filters.iter_mut().enumerate() {
            filter[n] = input;
            output[place] = alpha * output[place] + before[place] - alpha * input;
            (before[place], input) = (input, output[place]);
        }
    }
    [vec![1.0; count], command.to_vec()].into_iter().chain(filters).collect()
}

/// Columns orthonormalised in order (Gram and Schmidt); collinear ones are left out.
fn orthonormal(columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        let before = dot(&column, &column);
        // Twice: the first pass leaves rounding errors of the size of the removed components.
        for _ in 0..2 {
            for other in &basis {
                let share = dot(other, &column);
                column.iter_mut().zip(other).for_each(|(value, other)| *value -= share * other);
            }
        }
        let left = dot(&column, &column);
        if left > 1e-12 * before {
            column.iter_mut().for_each(|value| *value /= left.sqrt());
            basis.push(column);
        }
    }
    basis
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uniform_noise::uniform_noise;

    #[test]
    fn a_linear_response_is_explained_and_its_gain_found() {
        let mut random = uniform_noise(1);
        let mut held = 0.0;
        let command: Vec<f64> = (0..4000)
            .map(|n| {
                held = if n % 40 == 0 { random() } else { held };
                held
            })
            .collect();
        let (mut one, mut two) = (command[0], command[0]);
        let position: Vec<f64> = command
            .iter()
            .map(|value| {
                one += 0.1 * (value - one);
                two += 0.1 * (one - two);
                -1.3 * two + 4.0
            })
            .collect();
        let model = fit(&command, &position);
        assert!(model.share > 0.9999 && (model.gain + 1.3).abs() < 0.01, "{} {}", model.share, model.gain);
        for angle in [0.0, 0.05, 0.2] {
            let (sin, cos) = f64::sin_cos(angle);
            let one = 0.1 / (1.0 - 0.9 * cos).hypot(0.9 * sin);
            assert!((model.magnitude(angle) / (1.3 * one * one) - 1.0).abs() < 0.02, "{angle}");
        }
    }

    #[test]
    fn a_level_that_changes_with_the_direction_of_motion_is_no_step_of_the_sensor() {
        // A sweep: one slow half period until the command reverses, followed by fast ones over which levels average out.
        let angle = |n: f64| 5e-6 * std::f64::consts::TAU * n * n;
        let turn = 224;
        let time = (0..2000).map(f64::from);
        let command: Vec<f64> = time.clone().map(|n| angle(n).sin()).collect();
        let mut noise = uniform_noise(5);
        let mut level = 0.0;
        let friction: Vec<f64> = time
            .map(|n| {
                level += 0.2 * (-0.03 * angle(n).cos().signum() - level);
                level + 0.004 * noise()
            })
            .collect();
        for slip in [0.0, 0.06] {
            let slipped = |n: usize| slip * f64::from(u8::from(n >= turn));
            let position: Vec<f64> =
                (0..2000_usize).map(|n| 0.9 * command[n.saturating_sub(4)] + friction[n] + slipped(n)).collect();
            assert_eq!(fit(&command, &position).is_step_of_sensor(&command, &position, turn), slip > 0.0, "{slip}");
        }
    }

    #[test]
    fn filters_are_those_of_the_definition() {
        let command: Vec<f64> = (0..60).map(|n| 2.0 + (0.4 * f64::from(n)).sin()).collect();
        let alpha = 0.7_f64;
        let found = columns(&command, alpha);
        assert_eq!(found.len(), ORDER + 2);
        let scale = (1.0 - alpha * alpha).sqrt();
        // (1 - α z⁻¹) L_1 c = √(1 - α²) c and (1 - α z⁻¹) L_i+1 c = (z⁻¹ - α) L_i c, after the rest at the first value.
        for n in 1..60 {
            let first = found[2][n] - alpha * found[2][n - 1];
            assert!((first - scale * command[n]).abs() < 1e-12, "{n}");
            for pair in found[2..].windows(2) {
                let left = pair[1][n] - alpha * pair[1][n - 1];
                assert!((left - (pair[0][n - 1] - alpha * pair[0][n])).abs() < 1e-12, "{n}");
            }
        }
        let rest = command[0] * scale / (1.0 - alpha);
        assert!(found[2..].iter().all(|filter| (filter[0] - rest).abs() < 1e-12));
    }

    #[test]
    fn noise_is_not_explained() {
        let (mut one, mut two) = (uniform_noise(2), uniform_noise(3));
        let command: Vec<f64> = (0..4000).map(|_| one()).collect();
        let position: Vec<f64> = (0..4000).map(|_| two()).collect();
        assert!(fit(&command, &position).share < 0.02);
    }
}
