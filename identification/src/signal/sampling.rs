//! Whether a clock is even.

/// Sampling of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sampling {
    /// Even, with this interval \[s\].
    Even(f64),
    /// Uneven, with this mean interval \[s\].
    Uneven(f64),
}

impl Sampling {
    /// Interval, or mean interval \[s\].
    #[must_use]
    pub fn interval_s(self) -> f64 {
        match self {
            Self::Even(interval) | Self::Uneven(interval) => interval,
        }
    }
}

/// Maximum deviation from an even clock as a fraction of an interval: times are often written with few digits. At 12 Hz and 200 samples/s
/// it is 0.04 deg, without bias.
pub(super) const EVEN_SHARE: f64 = 2e-3;

/// Whether two or more increasing times have one interval, and which.
#[must_use]
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn sampling(time: &[f64]) -> Sampling {
    let interval = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
    let even = |(index, at): (usize, &f64)| (at - time[0] - index as f64 * interval).abs() < EVEN_SHARE * interval;
    if time.iter().enumerate().all(even) { Sampling::Even(interval) } else { Sampling::Uneven(interval) }
}
