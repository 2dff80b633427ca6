//! Local polynomials: the frequency response from a whole record, without window and without leakage.
//!
//! Between the line spectra of a record, U of the command and Y of the position, there is the response and what the ends
//! of the record do (its transient), and both are smooth over frequency:
//!
//! ```text
//! Y(k) = G(k) U(k) + T(k) + noise
//! G(k + r) = g0 + g1 r + g2 r²,   T(k + r) = t0 + t1 r + t2 r²,   |r| <= n
//! ```
//!
//! Least squares over the 2n + 1 lines around k give g0, with the variance that their own residual states (R. Pintelon and
//! J. Schoukens, System Identification, chapter 7). What is left out is the third derivative of G and T over n lines. To make
//! it small this is done twice: a first pass fits a reference model ([`super::reference_model`]), and in the second the polynomials
//! have to follow only how G and T differ from it, in Y / G_model.
//!
//! Several records are each taken alone, at the same frequencies, and averaged with the weights 1/variance.

use nalgebra::{Complex, DMatrix, DVector};

use super::{
    measured::{EXCITED_SHARE, FrequencyResponse, LineEstimate, Method},
    reference_model::{self, ReferenceModel},
    spectrum::{Lines, lines},
};
use crate::signal::record::Record;
use actuator_fmu::error::Result;

/// Order of both polynomials.
const ORDER: usize = 2;

/// Coefficients of both polynomials.
const UNKNOWNS: usize = 2 * (ORDER + 1);

/// Least half width n of a neighbourhood [lines]: 17 lines for 6 unknowns.
const LEAST_HALF_WIDTH: usize = 8;

/// Half width of a neighbourhood in long records [Hz]: an actuator's response bends over 10 Hz, and near the ends of a sweep
/// response and transient are separated by the curvature of the command's phase, which needs width.
const HALF_WIDTH_HZ: f64 = 0.25;

/// Lines with power that a neighbourhood has at least: multisines leave lines out, and at the ends of the band one side is
/// empty. Two for each coefficient of G, and two more.
const LEAST_EXCITED: usize = 8;

/// Power of a line, as a share of the greatest, below which it is left out by the excitation.
const EMPTY_SHARE: f64 = 1e-6;

/// How often wider than usual a neighbourhood may become for it.
const GREATEST_GROWTH: usize = 4;

/// Points of the first pass.
const FIRST_PASS: usize = 100;

/// Points are given up to this multiple of the highest excited frequency.
const BEYOND_BAND: f64 = 1.1;

/// The response that these records show together.
///
/// # Errors
/// None for records that could be read; here for the sake of the caller.
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of lines
pub fn estimate(records: &[Record]) -> Result<FrequencyResponse> {
    let spectra: Vec<Lines> = records.iter().map(lines).collect();
    let mut locals: Vec<Local> = spectra.into_iter().map(Local::new).collect();
    let highest = locals.iter().map(Local::highest_excited_hz).fold(0.0, f64::max) * BEYOND_BAND;
    let step = locals.iter().map(|local| local.lines.step_hz).fold(f64::INFINITY, f64::min);
    let grid: Vec<f64> = (1..=(highest / step) as usize).map(|line| line as f64 * step).collect();
    let mut notes = Vec::new();
    let mut each = Vec::with_capacity(records.len());
    for (record, local) in records.iter().zip(&mut locals) {
        let spacing = local.lines.interval_s.map(|interval| (interval, record.interpolation()));
        let first: Vec<LineEstimate> =
            grid.iter().step_by(grid.len().div_ceil(FIRST_PASS).max(1)).map(|f| local.at(*f)).collect();
        let reference = reference_model::fit(&first, spacing);
        if let Some(reference) = &reference {
            local.divide_by(reference);
        }
        let raw = grid.iter().map(|frequency| match &reference {
            Some(reference) => local.at(*frequency).times(reference.actuator(*frequency)),
            None => local.at(*frequency).times(reference_model::correction(None, spacing, *frequency)),
        });
        each.push(raw.collect::<Vec<LineEstimate>>());
        let source = record.source().display();
        match (spacing, reference) {
            (None, _) => notes.push(format!(
                "{source}: uneven samples; position taken as a spline through them, good to about 0.002 at 12 Hz and 200 samples/s"
            )),
            (Some(_), None) => notes.push(format!("{source}: {}", reference_model::UNCORRECTED_IMAGES)),
            _ => {}
        }
    }
    let points = (0..grid.len()).map(|index| {
        let here: Vec<LineEstimate> = each.iter().map(|raw| raw[index]).collect();
        average(&here).into_point()
    });
    Ok(FrequencyResponse { method: Method::Polynomial, points: points.collect(), averages: None, notes })
}

/// Weighted with 1/variance, over the excited ones where there are any.
fn average(raw: &[LineEstimate]) -> LineEstimate {
    let excited = raw.iter().any(|point| point.excited);
    let taken = || raw.iter().filter(move |point| point.excited == excited);
    let weight = |point: &LineEstimate| 1.0 / point.variance.max(f64::MIN_POSITIVE);
    // Relative to the greatest, so that records without noise do not overflow.
    let greatest = taken().map(weight).fold(0.0, f64::max);
    let sum: f64 = taken().map(|point| weight(point) / greatest).sum();
    let mean = |value: &dyn Fn(&LineEstimate) -> f64| {
        taken().map(|point| value(point) * weight(point) / greatest).sum::<f64>() / sum
    };
    LineEstimate {
        frequency_hz: raw[0].frequency_hz,
        response: Complex::new(mean(&|point| point.response.re), mean(&|point| point.response.im)),
        variance: 1.0 / (greatest * sum),
        coherence: mean(&|point| point.coherence),
        excited,
    }
}

/// One record's lines and where its command has power.
struct Local {
    lines: Lines,
    half_width: usize,
    /// Mean power of the command around each line.
    power: Vec<f64>,
    greatest_power: f64,
    /// How many lines with power there are before each line.
    filled: Vec<usize>,
}

impl Local {
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn new(lines: Lines) -> Self {
        let half_width = LEAST_HALF_WIDTH.max((HALF_WIDTH_HZ / lines.step_hz).round() as usize);
        // Running sums; the excitation of odd multisines leaves every second line empty.
        let mut sums = vec![0.0];
        for line in &lines.command {
            sums.push(sums[sums.len() - 1] + line.norm_sqr());
        }
        let count = lines.command.len();
        let power: Vec<f64> = (0..count)
            .map(|line| {
                let (first, end) = (line.saturating_sub(half_width / 2), (line + half_width / 2 + 1).min(count));
                (sums[end] - sums[first]) / (end - first) as f64
            })
            .collect();
        let greatest_power = power.iter().copied().fold(0.0, f64::max);
        let mut filled = vec![0];
        for line in &lines.command {
            filled.push(filled[filled.len() - 1] + usize::from(line.norm_sqr() > EMPTY_SHARE * greatest_power));
        }
        Self { lines, half_width, power, greatest_power, filled }
    }

    /// Leaves in the position what differs from a model.
    #[allow(clippy::cast_precision_loss)]
    fn divide_by(&mut self, reference: &ReferenceModel) {
        for (line, position) in self.lines.position.iter_mut().enumerate() {
            *position /= reference.lines((line + 1) as f64 * self.lines.step_hz);
        }
    }

    fn is_excited(&self, line: usize) -> bool {
        self.power[line] > EXCITED_SHARE * self.greatest_power
    }

    #[allow(clippy::cast_precision_loss)]
    fn highest_excited_hz(&self) -> f64 {
        let last = (0..self.power.len()).rev().find(|line| self.is_excited(*line)).unwrap_or(0);
        (last + 1) as f64 * self.lines.step_hz
    }

    /// First line and number of lines around one: as wide on both sides, where the spectrum goes on.
    fn neighbourhood(&self, nearest: usize) -> (usize, usize) {
        let count = self.lines.command.len();
        let around = |half_width: usize| {
            let width = (2 * half_width + 1).min(count);
            (nearest.saturating_sub(half_width).min(count - width), width)
        };
        let mut half_width = self.half_width;
        loop {
            let (first, width) = around(half_width);
            if self.filled[first + width] - self.filled[first] >= LEAST_EXCITED
                || half_width >= GREATEST_GROWTH * self.half_width
            {
                return (first, width);
            }
            half_width += self.half_width.div_ceil(4);
        }
    }

    /// g0 at a frequency [Hz], which need not be a line.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn at(&self, frequency_hz: f64) -> LineEstimate {
        let count = self.lines.command.len();
        let place = frequency_hz / self.lines.step_hz - 1.0; // line 0 is the first multiple of the step
        let nearest = (place.round().max(0.0) as usize).min(count - 1);
        let (first, width) = self.neighbourhood(nearest);
        let scale = self.half_width as f64;
        let rows = |line: usize| (line as f64 - place) / scale;
        let regressors = DMatrix::from_fn(width, UNKNOWNS, |row, column| {
            let power = Complex::from(rows(first + row).powi((column % (ORDER + 1)) as i32));
            if column <= ORDER { self.lines.command[first + row] * power } else { power }
        });
        // Columns of one length: the transient's have nothing of the size of the command's.
        let lengths: Vec<f64> = regressors.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
        let scaled = DMatrix::from_fn(width, UNKNOWNS, |row, column| regressors[(row, column)] / lengths[column]);
        let answer = DVector::from_iterator(width, self.lines.position[first..first + width].iter().copied());
        let qr = scaled.qr();
        let (q, r) = (qr.q(), qr.r());
        let projected = q.adjoint() * &answer;
        let residual = &answer - &q * &projected;
        let noise = residual.norm_squared() / (width - UNKNOWNS).max(1) as f64;
        let unknown = |reason: &Complex<f64>| !(reason.re.is_finite() && reason.im.is_finite());
        let solution = r.solve_upper_triangular(&projected);
        // (R'R)⁻¹ at g0 is the squared length of the first row of R⁻¹.
        let inverse = r.try_inverse();
        let (response, variance) = match (solution, inverse) {
            (Some(solution), Some(inverse)) if !solution.iter().any(unknown) => {
                (solution[0] / lengths[0], noise * inverse.row(0).norm_squared() / (lengths[0] * lengths[0]))
            }
            _ => (Complex::default(), f64::MAX),
        };
        let command_power = self.power[nearest];
        let explained = response.norm_sqr() * command_power;
        let coherence = if explained > 0.0 { explained / (explained + noise) } else { 0.0 };
        LineEstimate { frequency_hz, response, variance, coherence, excited: self.is_excited(nearest) }
    }
}
