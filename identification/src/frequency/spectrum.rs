//! The line spectrum of a record: command and position at multiples of one over its duration.
//!
//! Even sampling: the discrete Fourier transform of the samples. Uneven sampling: the Fourier integral over the record. The command between
//! samples is held or linear, so that its integral is exact; the position is interpolated by a cubic spline. Both are piecewise
//! polynomials, and repeated integration by parts leaves a sum over the jumps J of their derivatives of order p at the samples:
//!
//! ```text
//! F(ω) = Σ_p (jω)^-(p+1) Σ_i J_pi exp(-jω t_i)
//! ```

use nalgebra::Complex;

use super::exponential_sums;
use crate::{
    fourier,
    signal::{Interpolation, record::Record, sampling::Sampling},
};

/// Command and position at f = step, 2 step, 3 step, ...
#[derive(Debug, Clone)]
pub struct Lines {
    /// Spacing of the lines [Hz].
    pub step_hz: f64,
    /// Command.
    pub command: Vec<Complex<f64>>,
    /// Position.
    pub position: Vec<Complex<f64>>,
    /// The interval [s] of the samples of command and position; `None` if the lines are those of the signals themselves.
    pub interval_s: Option<f64>,
}

impl Lines {
    /// Truncates to the lines before `count`.
    pub fn truncate(&mut self, count: usize) {
        for lines in [&mut self.command, &mut self.position] {
            lines.truncate(count);
            lines.shrink_to_fit();
        }
    }
}

/// Highest frequency taken from uneven samples, relative to their mean rate: above it a spline is meaningless.
const SPLINE_SHARE: f64 = 0.25;

/// The lines of a record, with this position.
pub fn lines(record: &Record, position: &[f64]) -> Lines {
    match record.sampling() {
        Sampling::Even(interval) => of_samples(record.command(), position, interval),
        Sampling::Uneven(interval) => of_signals(record, position, interval),
    }
}

#[allow(clippy::cast_precision_loss)] // counts of samples
fn of_samples(command: &[f64], position: &[f64], interval: f64) -> Lines {
    let count = command.len();
    let samples = command.iter().zip(position);
    let mut both: Vec<Complex<f64>> = samples.map(|(command, position)| Complex::new(*command, *position)).collect();
    fourier::forward(count).process(&mut both);
    // Two real signals in one transform: the even part is the command's, the odd part j times the position's.
    let split = |line: usize| {
        let (here, mirrored) = (both[line], both[count - line].conj());
        ((here + mirrored) * 0.5, (here - mirrored) * Complex::new(0.0, -0.5))
    };
    let (command, position) = (1..count.div_ceil(2)).map(split).unzip();
    Lines { step_hz: 1.0 / (count as f64 * interval), command, position, interval_s: Some(interval) }
}

/// A piecewise polynomial over a record by the jumps of its derivatives.
struct Jumps {
    /// Jumps of one derivative, the highest nonzero one of the pieces, at every sample, and its order.
    inner: (i32, Vec<f64>),
    /// Sum of the jumps of the lower derivatives over a whole number of periods: they jump only at the ends of the record.
    ends: Vec<(i32, f64)>,
}

impl Jumps {
    /// The Fourier integral, from the sum over the inner jumps.
    fn integral(&self, sum: Complex<f64>, jomega: Complex<f64>) -> Complex<f64> {
        let ends = self.ends.iter().map(|(order, sum)| Complex::from(*sum) / jomega.powi(order + 1));
        sum / jomega.powi(self.inner.0 + 1) + ends.sum::<Complex<f64>>()
    }
}

#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of samples
fn of_signals(record: &Record, position: &[f64], interval: f64) -> Lines {
    let duration = record.duration_s();
    let count = (SPLINE_SHARE / interval * duration).floor() as usize;
    let command = match record.interpolation() {
        Interpolation::Held => Jumps { inner: (0, held_jumps(record.command())), ends: Vec::new() },
        Interpolation::Linear => linear_jumps(record.time(), record.command()),
    };
    let position = spline_jumps(record.time(), position);
    let places: Vec<f64> = record.time().iter().map(|time| (time - record.time()[0]) / duration).collect();
    let pairs: Vec<Complex<f64>> =
        command.inner.1.iter().zip(&position.inner.1).map(|(a, b)| Complex::new(*a, *b)).collect();
    let sums = exponential_sums::of_pairs(&places, &pairs, count);
    let integrals = sums.into_iter().enumerate().map(|(line, [of_command, of_position])| {
        let jomega = Complex::new(0.0, std::f64::consts::TAU * (line + 1) as f64 / duration);
        (command.integral(of_command, jomega), position.integral(of_position, jomega))
    });
    let (command_lines, position_lines) = integrals.unzip();
    Lines { step_hz: 1.0 / duration, command: command_lines, position: position_lines, interval_s: None }
}

/// Up to the first value, from value to value, and down from the last but one: the last is held for zero time.
fn held_jumps(values: &[f64]) -> Vec<f64> {
    let last = values.len() - 1;
    (0..values.len())
        .map(|index| match index {
            0 => values[0],
            _ if index == last => -values[last - 1],
            _ => values[index] - values[index - 1],
        })
        .collect()
}

/// Changes of slope, from before the first piece to after the last.
fn changes(slopes: &[f64]) -> Vec<f64> {
    let before = std::iter::once(0.0).chain(slopes.iter().copied());
    let after = slopes.iter().copied().chain([0.0]);
    after.zip(before).map(|(after, before)| after - before).collect()
}

fn linear_jumps(time: &[f64], values: &[f64]) -> Jumps {
    let slopes: Vec<f64> = time.windows(2).zip(values.windows(2)).map(|(t, v)| (v[1] - v[0]) / (t[1] - t[0])).collect();
    Jumps { inner: (1, changes(&slopes)), ends: vec![(0, values[0] - values[values.len() - 1])] }
}

/// For the natural cubic spline through the values.
fn spline_jumps(time: &[f64], values: &[f64]) -> Jumps {
    let count = time.len();
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let slopes: Vec<f64> = values.windows(2).zip(&steps).map(|(pair, step)| (pair[1] - pair[0]) / step).collect();
    let bends = bends(&steps, &slopes);
    let last = count - 2;
    let first_slope = slopes[0] - steps[0] * bends[1] / 6.0;
    let last_slope = slopes[last] + steps[last] * bends[last] / 6.0;
    let thirds: Vec<f64> = bends.windows(2).zip(&steps).map(|(pair, step)| (pair[1] - pair[0]) / step).collect();
    // The second derivative has no jumps: that of a natural spline is zero at both ends.
    Jumps {
        inner: (3, changes(&thirds)),
        ends: vec![(0, values[0] - values[count - 1]), (1, first_slope - last_slope)],
    }
}

/// Second derivatives at the samples: the tridiagonal system of the natural spline, by elimination.
fn bends(steps: &[f64], slopes: &[f64]) -> Vec<f64> {
    let count = steps.len() + 1;
    let mut bends = vec![0.0; count];
    let (mut diagonal, mut right) = (vec![1.0; count], vec![0.0; count]);
    for index in 1..count - 1 {
        let factor = if index == 1 { 0.0 } else { steps[index - 1] / diagonal[index - 1] };
        diagonal[index] =
            2.0 * (steps[index - 1] + steps[index]) - factor * if index == 1 { 0.0 } else { steps[index - 1] };
        right[index] = 6.0 * (slopes[index] - slopes[index - 1]) - factor * right[index - 1];
    }
    for index in (1..count - 1).rev() {
        bends[index] = (right[index] - steps[index] * bends[index + 1]) / diagonal[index];
    }
    bends
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::{Command, format::PositionUnit};

    #[test]
    fn uneven_lines_are_the_integrals_of_known_signals() {
        // Position t (2 - t) on [0, 2], sampled unevenly; ∫ t (2 - t) e^{-jωt} dt = -4 / ω² at ω = πn.
        let mut time: Vec<f64> = (0_u8..=200).map(|index| 2.0 * (f64::from(index) / 200.0).powf(1.1)).collect();
        time[200] = 2.0;
        let position: Vec<f64> = time.iter().map(|t| t * (2.0 - t)).collect();
        let command: Vec<f64> = time.clone();
        let record =
            Record::new(Command { time, command }, position, PositionUnit::Degree, Interpolation::Linear, "test")
                .unwrap();
        let lines = lines(&record, record.position());
        for (index, omega) in (1_u8..=10).map(|n| (usize::from(n) - 1, std::f64::consts::PI * f64::from(n))) {
            // ∫ t e^{-jωt} dt = 2j / ω, exact for a linear command; the spline has zero second derivative at its ends, the parabola has
            // not.
            assert!((lines.command[index] - Complex::new(0.0, 2.0 / omega)).norm() < 1e-12);
            assert!((lines.position[index] + 4.0 / (omega * omega)).norm() < 1e-5, "{index} {}", lines.position[index]);
        }
    }
}
