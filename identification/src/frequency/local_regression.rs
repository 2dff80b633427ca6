//! The response of one record around a frequency: least squares over the lines near it.

use super::{
    excited_lines::ExcitedLines,
    measured::LineEstimate,
    reference_model::ReferenceModel,
    spectrum::Lines,
    triangular_factor::{Solution, TriangularFactor, UNKNOWNS},
};
use crate::parallel;

/// Minimum half width n of a neighbourhood [lines]: 17 lines for 6 unknowns.
const LEAST_HALF_WIDTH: usize = 8;

/// Half width of a neighbourhood in long records [Hz]: an actuator's response varies over 10 Hz, and near the ends of a sweep response and
/// transient are separated by the curvature of the command's phase, which needs width.
const HALF_WIDTH_HZ: f64 = 0.25;

/// As above for a command of narrower band, as a fraction of its highest frequency: half a hertz of 6 Hz.
const HALF_WIDTH_SHARE: f64 = 1.0 / 24.0;

/// Number of iterations between the width and the highest frequency.
const ADAPTATIONS: usize = 4;

/// Minimum number of lines with power in a neighbourhood: multisines leave lines out, and at the ends of the band one side is empty. Two
/// for each coefficient of G, and two more.
const LEAST_EXCITED: usize = 8;

/// Maximum widening of a neighbourhood for that.
const GREATEST_GROWTH: usize = 4;

/// Number of blocks of lines, each folded once, in the half width of a long record's neighbourhood; neighbourhoods start and end with
/// blocks, so that they are off-centre by a thirty-second of their half width at most.
const BLOCKS_PER_HALF_WIDTH: usize = 16;

/// Variance of g0 over that of one line, times the lines of a neighbourhood with even power: (1 + 5/4) of a quadratic at its centre.
const CENTRE_OF_QUADRATIC: f64 = 2.25;

/// A response that exceeds its standard error by this factor is known, however poorly it is separated from the transient.
const KNOWN_RATIO: f64 = 5.0;

/// One record's lines and the excitation by its command.
pub(super) struct LocalRegression {
    lines: Lines,
    half_width: usize,
    excited: ExcitedLines,
    /// Lines in a block.
    block: usize,
    /// The folded blocks, if a block is more than a line.
    folded: Vec<TriangularFactor>,
    latest: Option<Neighbourhood>,
}

/// The folded lines of a neighbourhood.
struct Neighbourhood {
    first: usize,
    width: usize,
    /// Origin of s [line].
    centre: usize,
    solution: Option<Solution>,
}

impl LocalRegression {
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of lines
    pub(super) fn new(mut lines: Lines) -> Self {
        let of_width = |width_hz: f64| LEAST_HALF_WIDTH.max((width_hz / lines.step_hz).round() as usize);
        let mut half_width = of_width(HALF_WIDTH_HZ);
        let mut excited = ExcitedLines::new(&lines.command, half_width / 2);
        for _ in 0..ADAPTATIONS {
            let highest = excited.ends().map_or(0.0, |[_, last]| (last + 1) as f64 * lines.step_hz);
            let narrower = of_width(HALF_WIDTH_HZ.min(HALF_WIDTH_SHARE * highest));
            if narrower >= half_width {
                break;
            }
            half_width = narrower;
            excited = ExcitedLines::new(&lines.command, half_width / 2);
        }
        // Lines outside all neighbourhoods are dropped.
        let needed = excited.ends().map_or(0, |[_, last]| last + 1) + 2 * GREATEST_GROWTH * half_width + 1;
        lines.truncate(needed);
        excited.truncate(lines.command.len());
        let block = (half_width / BLOCKS_PER_HALF_WIDTH).max(1);
        let mut new = Self { lines, half_width, excited, block, folded: Vec::new(), latest: None };
        new.fold();
        new
    }

    /// Spacing of the lines [Hz].
    pub(super) fn step_hz(&self) -> f64 {
        self.lines.step_hz
    }

    /// Interval of even samples [s].
    pub(super) fn interval_s(&self) -> Option<f64> {
        self.lines.interval_s
    }

    /// Half width of a neighbourhood [Hz].
    #[allow(clippy::cast_precision_loss)] // counts of lines
    pub(super) fn half_width_hz(&self) -> f64 {
        self.half_width as f64 * self.lines.step_hz
    }

    /// Lowest and highest excited frequency [Hz].
    #[allow(clippy::cast_precision_loss)] // counts of lines
    pub(super) fn excited_hz(&self) -> Option<[f64; 2]> {
        self.excited.ends().map(|ends| ends.map(|line| (line + 1) as f64 * self.lines.step_hz))
    }

    /// Subtracts the response of a model from the position.
    #[allow(clippy::cast_precision_loss)] // counts of lines
    pub(super) fn divide_by(&mut self, reference: &ReferenceModel) {
        let step = self.lines.step_hz;
        let position = &self.lines.position;
        let divided = |line: usize| position[line] / reference.lines((line + 1) as f64 * step);
        self.lines.position = parallel::ranges(position.len(), |lines| lines.map(divided).collect());
        self.latest = None;
        self.fold();
    }

    /// Folds the lines of each block.
    fn fold(&mut self) {
        if self.block == 1 {
            return;
        }
        let Lines { command, position, .. } = &self.lines;
        let blocks: Vec<_> = command.chunks(self.block).zip(position.chunks(self.block)).collect();
        let step = self.step();
        self.folded =
            parallel::map(&blocks, |(command, position)| TriangularFactor::of_lines(command, position, 0.0, step));
    }

    /// Step of s from line to line.
    #[allow(clippy::cast_precision_loss)] // counts of lines
    fn step(&self) -> f64 {
        1.0 / self.half_width as f64
    }

    /// First line and number of lines around one: equally wide on both sides, within the spectrum.
    fn around(&self, nearest: usize) -> (usize, usize) {
        let count = self.lines.command.len();
        let around = |half_width: usize| {
            let width = (2 * half_width + 1).min(count);
            (nearest.saturating_sub(half_width).min(count - width), width)
        };
        let mut half_width = self.half_width;
        loop {
            let (first, width) = around(half_width);
            if self.excited.filled(first, width) >= LEAST_EXCITED || half_width >= GREATEST_GROWTH * self.half_width {
                // To whole blocks.
                let begin = (first + self.block / 2) / self.block * self.block;
                let end = ((first + width + self.block / 2) / self.block * self.block).min(count);
                return (begin, end - begin);
            }
            half_width += self.half_width.div_ceil(4);
        }
    }

    #[allow(clippy::cast_precision_loss)] // counts of lines
    fn neighbourhood(&self, nearest: usize) -> Neighbourhood {
        let (first, width) = self.around(nearest);
        let Lines { command, position, .. } = &self.lines;
        let (centre, lines) = (first + width / 2, first..first + width);
        let s = |line: usize| (line as f64 - centre as f64) * self.step();
        let factor = if self.block == 1 {
            TriangularFactor::of_lines(&command[lines.clone()], &position[lines], s(first), self.step())
        } else {
            let blocks = first / self.block..(first + width).div_ceil(self.block);
            TriangularFactor::of_factors(blocks.map(|block| (&self.folded[block], s(block * self.block))))
        };
        Neighbourhood { first, width, centre, solution: factor.solve() }
    }

    /// The index of the line next to a frequency [Hz]; the first line is one step from zero.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of lines
    fn place(&self, frequency_hz: f64) -> (f64, usize) {
        let place = frequency_hz / self.lines.step_hz - 1.0;
        (place, (place.round().max(0.0) as usize).min(self.lines.command.len() - 1))
    }

    /// Whether the command has power at a frequency [Hz].
    #[allow(clippy::cast_precision_loss)] // counts of lines
    pub(super) fn has_power(&self, frequency_hz: f64) -> bool {
        let end = (self.lines.command.len() + 1) as f64 * self.lines.step_hz;
        self.excited.contains(self.place(frequency_hz).1) && frequency_hz < end
    }

    /// g0 at a frequency [Hz], which need not be a line. Fastest for increasing frequencies.
    ///
    /// The relevant power is that of the command orthogonal to the polynomials of the transient: if a record ends in mid-motion, the jump
    /// from its end to its start has power on all lines, and only noise would distinguish a response to it from a transient.
    #[allow(clippy::cast_precision_loss)] // counts of lines
    pub(super) fn at(&mut self, frequency_hz: f64) -> LineEstimate {
        let (place, nearest) = self.place(frequency_hz);
        let (first, width) = self.around(nearest);
        let here = match self.latest.take() {
            Some(latest) if (latest.first, latest.width) == (first, width) => latest,
            _ => self.neighbourhood(nearest),
        };
        let s = (place - here.centre as f64) * self.step();
        let has_power = self.has_power(frequency_hz);
        let estimate = here.solution.as_ref().filter(|_| has_power).map(|solution| {
            let (response, of_unit) = solution.at(s);
            let noise = solution.residual / width.saturating_sub(UNKNOWNS).max(1) as f64;
            let variance = noise * of_unit;
            let counts = CENTRE_OF_QUADRATIC / (of_unit * width as f64);
            // The square of an estimate is too large by its variance.
            let known = (response.norm_sqr() - variance).max(0.0);
            let explained = known * self.excited.level(nearest).min(counts);
            let coherence = if explained > 0.0 { explained / (explained + noise) } else { 0.0 };
            let excited = counts > self.excited.least() || response.norm_sqr() > KNOWN_RATIO * KNOWN_RATIO * variance;
            LineEstimate { frequency_hz, response, variance, coherence, excited }
        });
        self.latest = Some(here);
        estimate.unwrap_or(LineEstimate::unknown(frequency_hz))
    }
}
