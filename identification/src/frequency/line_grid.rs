//! The frequencies of a response.

/// Selection of the lines of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LineChoice {
    /// As many as a response needs: every line of records up to a hundred seconds; of longer ones every 0.01 Hz up to 20 Hz and every
    /// 1/2000 of the frequency above.
    #[default]
    Resolved,
    /// Every line, spaced by one over the duration.
    All,
}

/// Steps per half width of a neighbourhood: estimates so close share nearly all lines.
const STEPS_PER_HALF_WIDTH: f64 = 25.0;

/// Steps per frequency: the resonance of a mode with a damping ratio of 0.001 is four of them wide.
const STEPS_PER_FREQUENCY: f64 = 2000.0;

impl LineChoice {
    /// Multiples of `step_hz` between two of them, the ends included; `half_width_hz` is that of a neighbourhood.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of lines
    pub(super) fn grid(self, step_hz: f64, ends: [usize; 2], half_width_hz: f64) -> Vec<f64> {
        let mut grid = Vec::new();
        let mut line = ends[0].max(1);
        while line <= ends[1] {
            let frequency = line as f64 * step_hz;
            grid.push(frequency);
            let apart = (half_width_hz / STEPS_PER_HALF_WIDTH).max(frequency / STEPS_PER_FREQUENCY);
            line += match self {
                Self::All => 1,
                Self::Resolved => ((apart / step_hz) as usize).max(1),
            };
        }
        grid
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_records_keep_every_line_and_long_ones_a_hundredth_of_a_hertz() {
        let of = |choice: LineChoice, duration_s: f64, ends| choice.grid(1.0 / duration_s, ends, 0.25);
        assert_eq!(of(LineChoice::Resolved, 75.0, [37, 900]), of(LineChoice::All, 75.0, [37, 900]));
        let long = of(LineChoice::Resolved, 5000.0, [2500, 60_000]);
        assert_eq!(long.len(), 1151);
        assert!(long.windows(2).all(|pair| (pair[1] - pair[0] - 0.01).abs() < 1e-9));
        assert_eq!(of(LineChoice::All, 5000.0, [2500, 60_000]).len(), 57_501);
    }
}
