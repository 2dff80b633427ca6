//! The change of a simulated position by a delay of its command, from the motion itself.

use super::trace::Simulated;

/// How a position changes with a delay of its command, where nothing depends on the time since the start.
#[derive(Debug, Clone, Copy)]
pub enum DelayResponse {
    /// By the rate of the drive, whose motion a later command moves as a whole.
    Rate,
    /// By a sum of the positions around each sample [1/s].
    Differences([f64; POINTS]),
}

/// Samples around each one from which derivatives are differences.
const POINTS: usize = 5;

/// First to fourth derivative from the positions around a sample, times powers of the interval.
const DIFFERENCES: [[f64; POINTS]; 4] = [
    [1.0 / 12.0, -8.0 / 12.0, 0.0, 8.0 / 12.0, -1.0 / 12.0],
    [-1.0 / 12.0, 16.0 / 12.0, -30.0 / 12.0, 16.0 / 12.0, -1.0 / 12.0],
    [-0.5, 1.0, 0.0, -1.0, 0.5],
    [1.0, -4.0, 6.0, -4.0, 1.0],
];

impl DelayResponse {
    /// For a delay by which a held command is averaged over each step of length h, and which exceeds whole steps by the share s of one:
    ///
    /// ```text
    /// c' = (s z⁻¹ + 1 - s) c,    ∂c'/∂T = (z⁻¹ - 1) c / h = N / (1 + s N) c' / h,    N = z⁻¹ - 1
    /// ```
    ///
    /// With c' the position changes by the same factor, here to the fourth order of the frequency.
    pub fn averaged(s: f64, interval_s: f64) -> Self {
        let orders = [-1.0, 0.5 - s, -1.0 / 6.0 + s - s * s, 1.0 / 24.0 - 7.0 / 12.0 * s + 1.5 * s * s - s * s * s];
        let weight = |place: usize| DIFFERENCES.iter().zip(orders).map(|(row, order)| order * row[place]).sum::<f64>();
        Self::Differences(std::array::from_fn(|place| weight(place) / interval_s))
    }

    /// ∂y/∂T at each sample [deg/s]; on a straight line where positions are missing on one side.
    pub fn of(self, simulated: &Simulated) -> Vec<f64> {
        match self {
            Self::Rate => simulated.rate.iter().flatten().map(|rate| -rate).collect(),
            Self::Differences(weights) => {
                let around = simulated.position.windows(POINTS);
                let sum = |around: &[f64]| weights.iter().zip(around).map(|(weight, position)| weight * position).sum();
                with_ends(&around.map(sum).collect::<Vec<f64>>(), simulated.position.len())
            }
        }
    }
}

/// The same number of values more at both ends, on the lines through the first two and the last two.
#[allow(clippy::cast_precision_loss)] // a few samples
fn with_ends(inner: &[f64], count: usize) -> Vec<f64> {
    let missing = (count - inner.len()) / 2;
    let [Some([first, second]), Some([before, last])] = [inner.first_chunk(), inner.last_chunk()] else {
        return vec![0.0; count];
    };
    let beyond = |end: f64, next: f64, samples: usize| end + samples as f64 * (end - next);
    let ahead = (1..=missing).rev().map(|samples| beyond(*first, *second, samples));
    let behind = (1..=missing).map(|samples| beyond(*last, *before, samples));
    ahead.chain(inner.iter().copied()).chain(behind).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of frequency Ω as the averaged command: its factor N / (1 + s N) at z = e^(iΩh).
    #[test]
    fn the_differences_have_the_response_of_the_averaged_command() {
        const INTERVAL_S: f64 = 0.01;
        for (s, samples_per_period) in [(0.0, 24.0), (0.3, 24.0), (0.5, 24.0), (0.9, 24.0), (0.5, 60.0)] {
            let phase = std::f64::consts::TAU / samples_per_period;
            let sine = |n: f64| (phase * n).sin();
            let position: Vec<f64> = (0..50).map(|n| sine(f64::from(n))).collect();
            let found = DelayResponse::averaged(s, INTERVAL_S).of(&Simulated { position, rate: None });
            // N / (1 + s N), as real and imaginary part.
            let (re, im) = (phase.cos() - 1.0, -phase.sin());
            let size = (1.0 + s * re).powi(2) + (s * im).powi(2);
            let (re, im) = ((re * (1.0 + s * re) + s * im * im) / size, im / size);
            for (n, found) in found.iter().enumerate().take(48).skip(2) {
                let n = f64::from(u32::try_from(n).unwrap());
                let expected = (re * sine(n) + im * (phase * n).cos()) / INTERVAL_S;
                assert!((found - expected).abs() < 1e-3 * phase / INTERVAL_S, "{s}, {n}: {found} {expected}");
            }
        }
    }

    #[test]
    fn a_line_has_its_slope_up_to_both_ends() {
        let position: Vec<f64> = (0..9).map(|n| 0.2 * f64::from(n)).collect();
        let found = DelayResponse::averaged(0.4, 0.1).of(&Simulated { position, rate: None });
        assert!(found.len() == 9 && found.iter().all(|slope| (slope + 2.0).abs() < 1e-12), "{found:?}");
        let short = Simulated { position: vec![1.0; 3], rate: None };
        assert_eq!(DelayResponse::averaged(0.4, 0.1).of(&short), [0.0; 3]);
    }
}
