//! On what a difference depends: its mean and size over an axis of the motion, and gain and lag of the measurement against a simulation over
//! the amplitude.
//!
//! Over amplitude: between two reversals of the simulation s the measurement m is regressed on it, m = a s + b ds/dt + c, with c free in each
//! swing and a, b shared by all swings of nearly the same amplitude (half of the way). a is the gain of the measurement over the simulation and
//! -b its lag, whatever the frequencies are: m(t) = a s(t + b/a) to first order.

/// Part of an axis, with what lies there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Class {
    /// Mean of the axis there.
    pub at: f64,
    /// Mean of the difference.
    pub mean: f64,
    /// Its root mean square.
    pub rms: f64,
}

/// Parts into which an axis is divided, each with as many samples as the others.
const CLASSES: usize = 20;

/// Fewer samples than these tell no mean.
const LEAST_SAMPLES: usize = 20;

/// The classes of points (place on the axis, difference).
#[must_use]
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn classes(points: &[[f64; 2]]) -> Vec<Class> {
    let mut sorted: Vec<[f64; 2]> = points.iter().copied().filter(|[x, y]| x.is_finite() && y.is_finite()).collect();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let size = sorted.len().div_ceil(CLASSES).max(LEAST_SAMPLES);
    let class = |part: &[[f64; 2]]| {
        let count = part.len() as f64;
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| part.iter().map(of).sum::<f64>() / count;
        Class {
            at: mean(&|point| point[0]),
            mean: mean(&|point| point[1]),
            rms: mean(&|point| point[1] * point[1]).sqrt(),
        }
    };
    sorted.chunks(size).filter(|part| part.len() >= LEAST_SAMPLES).map(class).collect()
}

/// Measured and simulated position of a record at its times, from where it is evaluated.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// Times \[s\].
    pub time: &'a [f64],
    /// Measured positions.
    pub measured: &'a [f64],
    /// Simulated positions.
    pub simulated: &'a [f64],
}

/// The measurement against a simulation in swings of nearly one amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swings {
    /// Mean amplitude, half of the way from one reversal to the next.
    pub amplitude: f64,
    /// Gain of measurement over simulation \[1\], and its standard error were the noise white.
    pub gain: [f64; 2],
    /// Lag of the measurement behind the simulation \[s\], and its standard error were the noise white.
    pub lag_s: [f64; 2],
}

/// Classes of amplitude.
const AMPLITUDES: usize = 8;

/// A gain that is known worse than this is none.
const GREATEST_GAIN_ERROR: f64 = 0.25;

/// A swing of fewer samples has no shape.
const LEAST_SWING: usize = 4;

/// Gain and lag in classes of amplitude, by rising amplitude; none where records have too few swings for two classes.
#[must_use]
pub fn over_amplitude(pairs: &[Pair<'_>]) -> Vec<Swings> {
    let mut swings: Vec<Swing> = pairs.iter().flat_map(swings_of).collect();
    swings.sort_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
    let samples: usize = swings.iter().map(|swing| swing.rows.len()).sum();
    let size = samples.div_ceil(AMPLITUDES).max(LEAST_SAMPLES);
    let mut found = Vec::new();
    let mut class: Vec<Swing> = Vec::new();
    for swing in swings {
        class.push(swing);
        if class.iter().map(|swing| swing.rows.len()).sum::<usize>() >= size {
            found.extend(regressed(&std::mem::take(&mut class)));
        }
    }
    found.extend(regressed(&class).filter(|_| 2 * class.iter().map(|swing| swing.rows.len()).sum::<usize>() > size));
    // Ripples as small as the noise tell no gain.
    found.retain(|class: &Swings| class.gain[1] < GREATEST_GAIN_ERROR);
    if found.len() < 2 { Vec::new() } else { found }
}

/// One swing: rows of measured and simulated position and simulated rate, each less its mean.
struct Swing {
    amplitude: f64,
    rows: Vec<[f64; 3]>,
}

/// From each reversal of a simulation to the next.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn swings_of(pair: &Pair<'_>) -> Vec<Swing> {
    let rate = rates(pair.time, pair.simulated);
    let mut found = Vec::new();
    let (mut first, mut direction) = (0, 0.0);
    for index in 1..pair.simulated.len() {
        let step = pair.simulated[index] - pair.simulated[index - 1];
        let reverses = step != 0.0 && direction != 0.0 && step.signum() != direction;
        if reverses || index + 1 == pair.simulated.len() {
            let range = first..index;
            let columns = [pair.measured, pair.simulated, &rate].map(|values| &values[range.clone()]);
            let means = columns.map(|values| values.iter().sum::<f64>() / values.len().max(1) as f64);
            let row = |place: usize| std::array::from_fn(|column| columns[column][place] - means[column]);
            if range.len() >= LEAST_SWING {
                let amplitude = 0.5 * (pair.simulated[index - 1] - pair.simulated[first]).abs();
                found.push(Swing { amplitude, rows: (0..range.len()).map(row).collect() });
            }
            first = index - 1;
        }
        if step != 0.0 {
            direction = step.signum();
        }
    }
    found
}

/// Rates by central differences, at the ends by the only one.
#[must_use]
pub fn rates(time: &[f64], position: &[f64]) -> Vec<f64> {
    let last = position.len().saturating_sub(1);
    (0..position.len())
        .map(|index| {
            let (before, after) = (index.saturating_sub(1), (index + 1).min(last));
            let duration = time[after] - time[before];
            if duration > 0.0 { (position[after] - position[before]) / duration } else { 0.0 }
        })
        .collect()
}

/// Least squares over the swings of one class.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn regressed(swings: &[Swing]) -> Option<Swings> {
    let rows = || swings.iter().flat_map(|swing| &swing.rows);
    let sum = |one: usize, other: usize| rows().map(|row| row[one] * row[other]).sum::<f64>();
    let (ss, sr, rr, ms, mr, mm) = (sum(1, 1), sum(1, 2), sum(2, 2), sum(0, 1), sum(0, 2), sum(0, 0));
    let determinant = ss * rr - sr * sr;
    // Collinear, or no motion at all.
    if !determinant.is_finite() || determinant <= 1e-9 * ss * rr {
        return None;
    }
    let (gain, slope) = ((ms * rr - mr * sr) / determinant, (mr * ss - ms * sr) / determinant);
    let freedom = rows().count() as f64 - swings.len() as f64 - 2.0;
    let variance = ((mm - gain * ms - slope * mr) / freedom.max(1.0)).max(0.0);
    let amplitude =
        swings.iter().map(|swing| swing.amplitude * swing.rows.len() as f64).sum::<f64>() / rows().count() as f64;
    let errors = [(variance * rr / determinant).sqrt(), (variance * ss / determinant).sqrt()];
    Some(Swings { amplitude, gain: [gain, errors[0]], lag_s: [-slope, errors[1]] })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sines of growing amplitude.
    fn motion() -> (Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..8000).map(|index| f64::from(index) * 2.5e-3).collect();
        let position = time.iter().map(|t| (0.2 + 0.1 * t) * (9.0 * t).sin()).collect();
        (time, position)
    }

    #[test]
    fn a_gain_and_a_lag_are_found_at_every_amplitude() {
        let (time, simulated) = motion();
        let rate = rates(&time, &simulated);
        let measured: Vec<f64> = simulated.iter().zip(&rate).map(|(s, r)| 0.9 * s - 0.004 * r + 5.0).collect();
        let found = over_amplitude(&[Pair { time: &time, measured: &measured, simulated: &simulated }]);
        assert!(found.len() >= 6, "{found:?}");
        for swings in found {
            assert!((swings.gain[0] - 0.9).abs() < 1e-9 && (swings.lag_s[0] - 0.004).abs() < 1e-9, "{swings:?}");
        }
    }

    #[test]
    fn play_takes_more_of_small_swings_than_of_large_ones() {
        let (time, simulated) = motion();
        let mut held = 0.0;
        let play = |s: &f64| {
            held = f64::clamp(held, s - 0.1, s + 0.1);
            held
        };
        let measured: Vec<f64> = simulated.iter().map(play).collect();
        let found = over_amplitude(&[Pair { time: &time, measured: &measured, simulated: &simulated }]);
        let (first, last) = (found[0], found[found.len() - 1]);
        assert!(first.amplitude < last.amplitude && first.gain[0] < last.gain[0] && last.gain[0] < 1.0, "{found:?}");
        assert!(first.lag_s[0] > last.lag_s[0] && last.lag_s[0] > 0.0, "{found:?}");
    }

    #[test]
    fn classes_hold_as_many_points_each_and_follow_what_depends() {
        let points: Vec<[f64; 2]> = (0..1000).rev().map(|n| f64::from(n) * 1e-3).map(|x| [x, x * x]).collect();
        let found = classes(&points);
        assert_eq!(found.len(), CLASSES);
        assert!(found.iter().all(|class| (class.mean - class.at * class.at).abs() < 1e-3), "{found:?}");
        assert!(classes(&points[..5]).is_empty() && over_amplitude(&[]).is_empty());
    }
}
