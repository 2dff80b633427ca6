//! Size and colour of the residual of a record.
//!
//! The residual e is described by an autoregression, e[n] = a1 e[n-1] + ... + aq e[n-q] + w[n], w white with variance σ², from its
//! autocovariance by Levinson's recursion; q minimises the Bayesian information criterion. The filter 1 - a1 z⁻¹ - ... whitens a record,
//! for which least squares give maximum-likelihood estimates with correct standard errors. Turbulence and filtered sensors are coloured;
//! treated as white they make every standard error too small and every hypothesis too certain.

use crate::linear_least_squares::dot;

/// Noise of one record.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// a1 to aq.
    pub coefficients: Vec<f64>,
    /// σ
    pub innovation_rms: f64,
}

/// Maximum order: half a period of 4 Hz at 200 samples/s, the wing's flutter, is 25 samples.
const GREATEST_ORDER: usize = 30;

/// Maximum order as a fraction of the samples, so that a short record does not explain its own noise.
const GREATEST_SHARE: usize = 20;

/// A residual below this fraction of the position consists of rounding errors, not of sensor noise.
pub const ROUNDING_SHARE: f64 = 1e-10;

impl Noise {
    /// White noise of this size.
    pub fn white(rms: f64) -> Self {
        Self { coefficients: Vec::new(), innovation_rms: rms }
    }

    /// Whether it has no colour.
    pub fn is_white(&self) -> bool {
        self.coefficients.is_empty()
    }

    /// From a residual; white if not above `floor`, i.e. consisting of rounding errors.
    pub fn of(residual: &[f64], floor: f64) -> Self {
        Self::with_white_share(residual, floor, 0.0)
    }

    /// As above with white noise of this fraction of the variance added before the filter is computed: this bounds the noise from below at
    /// all frequencies, so that the filter does not amplify small model errors where there is hardly any noise.
    #[allow(clippy::cast_precision_loss)] // counts of samples
    pub fn with_white_share(residual: &[f64], floor: f64, white_share: f64) -> Self {
        let count = residual.len();
        let most = GREATEST_ORDER.min(count / GREATEST_SHARE);
        let mut covariance: Vec<f64> = (0..=most).map(|lag| dot(residual, &residual[lag..]) / count as f64).collect();
        if covariance[0].sqrt() <= floor {
            return Self::white(floor);
        }
        covariance[0] *= 1.0 + white_share;
        let criterion = |variance: f64, order: usize| count as f64 * variance.ln() + order as f64 * (count as f64).ln();
        let mut variance = covariance[0];
        let mut coefficients: Vec<f64> = Vec::new();
        let mut best = (criterion(variance, 0), Self::white(variance.sqrt()));
        for order in 1..=most {
            let explained: f64 = coefficients.iter().enumerate().map(|(lag, a)| a * covariance[order - 1 - lag]).sum();
            let reflection = (covariance[order] - explained) / variance;
            let mirrored: Vec<f64> = coefficients.iter().rev().copied().collect();
            coefficients.iter_mut().zip(&mirrored).for_each(|(a, b)| *a -= reflection * b);
            coefficients.push(reflection);
            variance *= 1.0 - reflection * reflection;
            if variance <= 0.0 || !variance.is_finite() {
                break;
            }
            let here = criterion(variance, order);
            if here < best.0 {
                best = (here, Self { coefficients: coefficients.clone(), innovation_rms: variance.sqrt() });
            }
        }
        best.1
    }

    /// A filtered column. A column that ends early (zero from there on) is extended by the filter.
    pub fn whiten(&self, column: Vec<f64>, count: usize) -> Vec<f64> {
        let order = self.coefficients.len();
        if order == 0 {
            return column;
        }
        let length = (column.len() + order).min(count);
        let mut before = column;
        before.resize(length, 0.0);
        let mut white = before.clone();
        let subtract = |values: &mut [f64], lag: usize, a: f64| {
            values.iter_mut().skip(lag).zip(&before).for_each(|(value, before)| *value -= a * before);
        };
        // Four lags in a pass, which takes longer to load and store than to compute; in the order of the lags.
        let (fours, rest) = self.coefficients.as_chunks::<4>();
        for (first, [a, b, c, d]) in (1..).step_by(4).zip(fours) {
            let last = (first + 3).min(length);
            let (beginning, others) = white.split_at_mut(last);
            (first..).zip([a, b, c]).for_each(|(lag, a)| subtract(beginning, lag, *a));
            for (value, before) in others.iter_mut().zip(before.windows(4)) {
                *value = *value - a * before[3] - b * before[2] - c * before[1] - d * before[0];
            }
        }
        (order - rest.len() + 1..).zip(rest).for_each(|(lag, a)| subtract(&mut white, lag, *a));
        white
    }

    /// Whitened; the first `excluded` samples and those for which the filter lacks previous samples are set to zero.
    pub fn whiten_after(&self, column: Vec<f64>, count: usize, excluded: usize) -> Vec<f64> {
        let mut white = self.whiten(column, count);
        let end = (excluded + self.coefficients.len()).min(white.len());
        white[..end].fill(0.0);
        white
    }

    /// A column filtered by the inverse filter backwards in time: E(J'e e'J) = σ² |this|² for noise e.
    pub fn colour_backwards(&self, column: &[f64]) -> Vec<f64> {
        let mut coloured = column.to_vec();
        for index in (0..coloured.len()).rev() {
            let later = &coloured[index + 1..];
            let sum: f64 = self.coefficients.iter().zip(later).map(|(a, value)| a * value).sum();
            coloured[index] += sum;
        }
        coloured
    }

    /// Effective fraction of the samples: 1 / Σ ρ(m)² over all lags, ρ the autocorrelation (M. S. Bartlett, 1946).
    pub fn effective_share(&self) -> f64 {
        // The autocovariance of the autoregression, through its impulse response g: c(m) = Σ g[n] g[n + m].
        const LONGEST: usize = 2000;
        // Truncation of the impulse response relative to its start: the remainder adds 1e-12 to the sum.
        const FADED: f64 = 1e-6;
        let mut impulse = vec![1.0];
        for index in 1..LONGEST {
            let recent = impulse.iter().rev();
            let next: f64 = self.coefficients.iter().zip(recent).map(|(a, value)| a * value).sum();
            if index > GREATEST_ORDER && impulse[index - GREATEST_ORDER..].iter().all(|value| value.abs() < FADED) {
                break;
            }
            impulse.push(next);
        }
        let covariance = |lag: usize| dot(&impulse, &impulse[lag..]);
        let variance = covariance(0);
        let others: f64 = (1..impulse.len()).map(|lag| (covariance(lag) / variance).powi(2)).sum();
        1.0 / (1.0 + 2.0 * others)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_filtered_by_each_lag_and_extended_where_it_ends_early() {
        for (order, count) in [(1_u32, 40), (3, 40), (4, 23), (7, 20), (9, 21), (30, 25)] {
            let coefficients: Vec<f64> = (1..=order).map(|lag| 0.7 / f64::from(lag)).collect();
            let column: Vec<f64> = (0..20).map(|n| (0.4 * f64::from(n)).sin() + 0.1).collect();
            let noise = Noise { coefficients: coefficients.clone(), innovation_rms: 1.0 };
            let found = noise.whiten(column.clone(), count);
            assert_eq!(found.len(), (20 + order as usize).min(count));
            for (n, found) in found.iter().enumerate() {
                let at = |n: usize| column.get(n).copied().unwrap_or_default();
                let lags = (1..).zip(&coefficients).take(n);
                let expected = at(n) - lags.map(|(lag, a)| a * at(n - lag)).sum::<f64>();
                assert!((found - expected).abs() < 1e-12, "{order} {count} {n}: {found} {expected}");
            }
        }
    }
}
