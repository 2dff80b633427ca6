//! The command: its band, its period, its parts at rest.

use std::ops::Range;

use serde::Serialize;

use crate::frequency::power_density;

/// Where a command has its power.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Band {
    /// \[Hz\]
    pub lowest_hz: f64,
    /// \[Hz\]
    pub highest_hz: f64,
}

/// Share of the power that is left out at each end of the band.
const OUTSIDE: f64 = 0.005;

/// The band that holds 99 % of the power of a command about its mean.
#[must_use]
pub fn band(command: &[f64], interval_s: f64) -> Band {
    let mean = command.iter().sum::<f64>() / command.len() as f64;
    let about: Vec<f64> = command.iter().map(|value| value - mean).collect();
    let density = power_density(&[about], interval_s);
    let total: f64 = density.iter().map(|[_, density]| density).sum();
    let mut sum = 0.0;
    let mut band = Band { lowest_hz: 0.0, highest_hz: 0.5 / interval_s };
    let mut inside = false;
    for [frequency, density] in density {
        sum += density;
        if !inside && sum >= OUTSIDE * total {
            band.lowest_hz = frequency;
            inside = true;
        }
        if sum >= (1.0 - OUTSIDE) * total {
            band.highest_hz = frequency;
            break;
        }
    }
    band
}

/// Differences below this share of the command's range are none.
const SAME: f64 = 1e-9;

/// Fewest samples in a period.
const SHORTEST_PERIOD: usize = 10;

/// Samples in the period of a command that repeats itself at least three times; none where it does not.
#[must_use]
pub fn period(command: &[f64]) -> Option<usize> {
    let (low, high) = super::values::extremes(command);
    let near = SAME * (high - low);
    let count = command.len();
    let repeats = |period: usize| (period..count).all(|n| (command[n] - command[n - period]).abs() <= near);
    // A period brings the greatest value back.
    let peak = command.iter().position(|value| high - value <= near)?;
    let back = (peak + SHORTEST_PERIOD..command.len()).filter(|n| high - command[*n] <= near).map(|n| n - peak);
    back.take_while(|period| *period <= count / 3).find(|period| repeats(*period))
}

/// Shortest part at rest that is told of [samples].
const SHORTEST: usize = 20;

/// Parts in which the command rests.
#[must_use]
pub fn rests(command: &[f64]) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let mut from = 0;
    for n in 1..=command.len() {
        if n == command.len() || command[n] != command[n - 1] {
            if n - from >= SHORTEST {
                parts.push(from..n);
            }
            from = n;
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn band_period_and_rests_of_a_made_command() {
        let mut command: Vec<f64> =
            (0..4000).map(|n| (std::f64::consts::TAU * 5.0 * 0.005 * f64::from(n)).sin()).collect();
        let found = band(&command, 0.005);
        assert!((found.lowest_hz - 5.0).abs() < 0.3 && (found.highest_hz - 5.0).abs() < 0.3, "{found:?}");
        let hold: Vec<f64> = (0..4000).map(|n| f64::from((n % 400) / 40)).collect();
        assert_eq!(period(&hold), Some(400));
        command[100..200].fill(0.25);
        let found = rests(&command);
        assert!(found.len() == 1 && found[0] == (100..200), "{found:?}");
        assert_eq!(period(&command), None);
    }
}
