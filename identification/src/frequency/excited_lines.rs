//! Lines of a record that are excited by its command.
//!
//! A line is excited if the command's mean power around it is within 20 dB of the maximum (multisines leave lines out in between), and if
//! it lies between the first and the last line of such a run that has this power itself: a mean over neighbours extends beyond the edge of
//! a band, the command does not. `local_regression` determines whether its power distinguishes a response from a transient.

use nalgebra::Complex;

/// Below this fraction of the maximum command power (-20 dB) a frequency is not excited: a sweep that ends in mid-motion reaches it half a
/// hertz beyond its band.
pub(super) const EXCITED_SHARE: f64 = 1e-2;

/// Power of a line, relative to the maximum, below which it is left out by the excitation.
const EMPTY_SHARE: f64 = 1e-6;

/// The command's power over lines.
pub(super) struct ExcitedLines {
    /// Mean power around each line.
    level: Vec<f64>,
    /// Minimum mean power of an excited line.
    least: f64,
    /// First and last line of each run of excited ones.
    runs: Vec<[usize; 2]>,
    /// Number of lines with power before each line.
    filled: Vec<u32>,
}

impl ExcitedLines {
    /// For the lines of a command; means are over this many on either side.
    #[allow(clippy::cast_precision_loss)] // counts of lines
    pub(super) fn new(command: &[Complex<f64>], around: usize) -> Self {
        let count = command.len();
        let mut sums = Vec::with_capacity(count + 1);
        sums.push(0.0);
        let mut sum = 0.0;
        for line in command {
            sum += line.norm_sqr();
            sums.push(sum);
        }
        let mean = |line: usize| {
            let (first, end) = (line.saturating_sub(around), (line + around + 1).min(count));
            (sums[end] - sums[first]) / (end - first) as f64
        };
        let level: Vec<f64> = (0..count).map(mean).collect();
        let greatest = level.iter().copied().fold(0.0, f64::max);
        let mut filled = Vec::with_capacity(count + 1);
        filled.push(0);
        let mut before = 0;
        for line in command {
            before += u32::from(line.norm_sqr() > EMPTY_SHARE * greatest);
            filled.push(before);
        }
        let least = EXCITED_SHARE * greatest;
        let mut runs = Vec::new();
        let mut line = 0;
        while line < count {
            let end = (line..count).find(|line| level[*line] <= least).unwrap_or(count);
            let mut strong = (line..end).filter(|line| command[*line].norm_sqr() > least);
            if let Some(first) = strong.next() {
                runs.push([first, strong.next_back().unwrap_or(first)]);
            }
            line = end + 1;
        }
        Self { level, least, runs, filled }
    }

    /// Mean power around a line.
    pub(super) fn level(&self, line: usize) -> f64 {
        self.level[line]
    }

    /// Minimum mean power of an excited line.
    pub(super) fn least(&self) -> f64 {
        self.least
    }

    /// Whether a line is excited.
    pub(super) fn contains(&self, line: usize) -> bool {
        let run = self.runs.partition_point(|[_, last]| *last < line);
        self.runs.get(run).is_some_and(|[first, _]| *first <= line)
    }

    /// Lowest and highest excited line.
    pub(super) fn ends(&self) -> Option<[usize; 2]> {
        Some([self.runs.first()?[0], self.runs.last()?[1]])
    }

    /// Lines with power among `width` from `first` on.
    pub(super) fn filled(&self, first: usize, width: usize) -> usize {
        (self.filled[first + width] - self.filled[first]) as usize
    }

    /// Truncates to the lines before `count`.
    pub(super) fn truncate(&mut self, count: usize) {
        self.level.truncate(count);
        self.level.shrink_to_fit();
        self.filled.truncate(count + 1);
        self.filled.shrink_to_fit();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_ends_where_its_lines_end_and_holes_between_lines_do_not_count() {
        // Every third line from 30 to 90.
        let power = |line: usize| if (30..=90).contains(&line) && line.is_multiple_of(3) { 1.0 } else { 0.0 };
        let command: Vec<Complex<f64>> = (0..200).map(|line| Complex::from(power(line))).collect();
        let excited = ExcitedLines::new(&command, 4);
        assert_eq!(excited.ends(), Some([30, 90]));
        assert!(excited.contains(30) && excited.contains(31) && excited.contains(90));
        assert!(!excited.contains(29) && !excited.contains(91));
        assert_eq!(excited.filled(30, 61), 21);
    }
}
