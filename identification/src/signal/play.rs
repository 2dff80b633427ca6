//! Output of a play.

/// Output of a play for a signal, which starts in the middle of its gap.
pub fn behind_play(signal: &[f64], half_gap: f64) -> Vec<f64> {
    let mut behind = signal.first().copied().unwrap_or_default();
    let follow = |value: &f64| {
        behind = behind.clamp(value - half_gap, value + half_gap);
        behind
    };
    signal.iter().map(follow).collect()
}

/// Minimum and maximum.
pub fn range(signal: &[f64]) -> (f64, f64) {
    signal.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (value.min(low), value.max(high)))
}
