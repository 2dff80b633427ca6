//! Spectra for pages, in decibels.

use identification::frequency::power_density;

/// Power density of signals, sampled every `interval_s` seconds, over frequency \[Hz\] in dB of the square of their unit per hertz.
#[must_use]
pub fn decibels(signals: &[Vec<f64>], interval_s: f64) -> Vec<[f64; 2]> {
    power_density(signals, interval_s).into_iter().map(|[frequency, density]| [frequency, decibel(density)]).collect()
}

/// A power in dB; the minimum number for zero power.
#[must_use]
pub fn decibel(power: f64) -> f64 {
    10.0 * power.max(f64::MIN_POSITIVE).log10()
}

/// Label of an axis of such densities, for signals in a unit.
#[must_use]
pub fn label(unit: &str) -> String {
    match unit {
        "1" => "dB of 1/Hz".to_owned(),
        unit => format!("dB of 1 {unit}²/Hz"),
    }
}
