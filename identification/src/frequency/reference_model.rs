//! A reference model: a parametric model close to a measured response, for two corrections that samples alone do not allow.
//!
//! **Between samples.** A computer's command is held between samples, so that the samples of the position have the response G = Σ H(f +
//! n/h) R(f + n/h): H times the reconstruction R (half a step of lag, 2.5 ms at 200 samples/s), and its images at multiples of the sampling
//! rate 1/h. Dividing by R alone leaves the images, up to 2e-3 at 12 Hz and 200 samples/s. They depend on H above the sampled band, so a
//! model provides them: eq. (1) with a delay is fitted to G, including the images, and
//!
//! ```text
//! H = G · H_model / G_model
//! ```
//!
//! The ratio differs from 1/R by the images only; a model with an error of a tenth leaves a tenth of 2e-3.
//!
//! **Between lines.** Local polynomials have to follow G over a neighbourhood of lines; they approximate G / G_model better.

use nalgebra::{Complex, DMatrix, DVector};

use super::{delayed_model::DelayedModel, measured::LineEstimate, sampled::Sampled};
use crate::{
    least_squares::{Expansion, LOOSE_TOLERANCE, Problem, minimise},
    signal::{Interpolation, record::Record},
    simulate::simulate,
};
use actuator_fmu::{
    effects::Effects,
    parameters::{Base, Model, Order},
};

/// Number of points for the fit; more would add nothing to a smooth curve with five parameters.
const POINTS: usize = 60;

/// Minimum number of points: two for each of the five parameters, real and imaginary parts each.
const FEWEST_POINTS: usize = 10;

/// Bounds of the search, far beyond any actuator of a surface: |k|, ζ, lag 1/p and delay [s], minimum ω [rad/s], and maximum ω without a
/// sampling rate that defines it.
const GAINS: [f64; 2] = [1e-5, 1e5];
const ZETAS: [f64; 2] = [0.01, 100.0];
const LAGS_S: [f64; 2] = [0.0, 1.0];
const SLOWEST: f64 = 1.0;
const FASTEST: f64 = 1e5;

/// Starts: ω as a multiple of the highest frequency, and the delay in turns at it. An actuator about as fast as the band or faster; a delay
/// of zero or half a turn.
const STARTS: [(f64, f64); 5] = [(0.5, 0.0), (1.5, 0.0), (4.0, 0.0), (1.5, 0.5), (4.0, 0.5)];
/// ζ of all starts.
const START_ZETA: f64 = 0.6;
/// Lag 1/p and minimum delay of all starts, as fractions of 1/ω: small, but not on the bound, where a search may stay.
const START_LAGS: [f64; 2] = [0.1, 0.01];

/// Additional variance of a measured response, relative to its power: 1e-4 of the response.
const SHARE_OF_RESPONSE: f64 = 1e-8;

/// A response with a relative standard error below this determines size and sign of the gain.
const KNOWN_SHARE: f64 = 0.1;

/// A model with a larger relative misfit than this does not provide the images.
const GREATEST_MISFIT: f64 = 0.2;

/// What the lines of a record contain besides the actuator: samples at this interval [s] of a command that is held or linear; `None` if the
/// lines are those of the signals themselves.
pub(super) type Grid = Option<(f64, Interpolation)>;

/// A parametric model close to a measured response.
pub(super) struct ReferenceModel {
    model: DelayedModel,
    sampled: Option<Sampled>,
}

impl ReferenceModel {
    /// Response of the actuator itself.
    pub(super) fn actuator(&self, frequency_hz: f64) -> Complex<f64> {
        self.model.response(frequency_hz)
    }

    /// Response as seen in the lines.
    pub(super) fn lines(&self, frequency_hz: f64) -> Complex<f64> {
        self.sampled.as_ref().map_or_else(|| self.actuator(frequency_hz), |sampled| sampled.response(frequency_hz))
    }

    /// Its position at the samples of a record, from rest; `None` if it diverges.
    pub(super) fn position(&self, record: &Record) -> Option<Vec<f64>> {
        let DelayedModel { base, order, delay_s } = self.model;
        if let Some(sampled) = &self.sampled {
            return Some(sampled.position(record.command(), base.k() * record.command()[0]));
        }
        let mut model = Model::new(base, order);
        let mut values = model.effects.values().to_vec();
        values[Effects::index("delay", "time").ok()?] = delay_s;
        model.effects = Effects::with_values(&values).ok()?;
        Some(simulate(&model, &record.to_command(), record.interpolation()).ok()?.position)
    }

    fn new(model: DelayedModel, grid: Grid) -> Self {
        let sampled = grid.map(|(interval, interpolation)| {
            Sampled::new(model.base, model.order, model.delay_s, interpolation, interval)
        });
        Self { model, sampled }
    }
}

/// Factor from the response between lines to that of the actuator.
pub(super) fn correction(reference: Option<&ReferenceModel>, grid: Grid, frequency_hz: f64) -> Complex<f64> {
    match (reference, grid) {
        (Some(reference), _) => reference.actuator(frequency_hz) / reference.lines(frequency_hz),
        (None, Some((interval, interpolation))) => {
            Complex::from(1.0) / reconstruction(frequency_hz, interval, interpolation)
        }
        (None, None) => Complex::from(1.0),
    }
}

/// Note if no reference model fits a sampled response.
pub(super) const UNCORRECTED_IMAGES: &str = "no second- or third-order model with delay fits this response: images of the sampled command \
are not removed, up to about 0.002 at 12 Hz and 200 samples/s";

/// R at a frequency [Hz]: the effect of the command's reconstruction between samples on its spectrum.
fn reconstruction(frequency_hz: f64, interval_s: f64, interpolation: Interpolation) -> Complex<f64> {
    let angle = std::f64::consts::PI * frequency_hz * interval_s;
    let sinc = if angle == 0.0 { 1.0 } else { angle.sin() / angle };
    match interpolation {
        Interpolation::Held => Complex::from_polar(sinc, -angle),
        Interpolation::Linear => Complex::from(sinc * sinc),
    }
}

/// The model of x = (ln |k|, ln ω, ln ζ, 1/p, T).
fn model_at(sign: f64, x: &[f64]) -> Option<DelayedModel> {
    // Below this lag the pole is beyond all relevant frequencies, and eq. (1) reduces to eq. (6).
    const NO_LAG_S: f64 = 1e-9;
    let order = if x[3] > NO_LAG_S { Order::Third } else { Order::Second };
    let base = Base::new(sign * x[0].exp(), 1.0 / x[3].max(NO_LAG_S), x[1].exp(), x[2].exp()).ok()?;
    Some(DelayedModel { base, order, delay_s: x[4] })
}

struct LineFit<'a> {
    points: Vec<&'a LineEstimate>,
    weights: Vec<f64>,
    grid: Grid,
    sign: f64,
}

impl LineFit<'_> {
    /// (G_measured - G_model) over its standard error, real parts and imaginary parts.
    fn residual(&self, x: &[f64]) -> DVector<f64> {
        let Some(model) = model_at(self.sign, x) else {
            return DVector::from_element(2 * self.points.len(), f64::NAN);
        };
        let model = ReferenceModel::new(model, self.grid);
        let differences = self.points.iter().zip(&self.weights).flat_map(|(point, weight)| {
            let difference = (point.response - model.lines(point.frequency_hz)) * Complex::from(*weight);
            [difference.re, difference.im]
        });
        DVector::from_iterator(2 * self.points.len(), differences)
    }
}

impl Problem for LineFit<'_> {
    fn cost(&self, x: &[f64]) -> f64 {
        0.5 * self.residual(x).norm_squared()
    }

    fn expand(&self, x: &[f64]) -> Expansion {
        // Central differences with steps of 1e-6 for logarithms and 0.1 µs for lags, both far from rounding and from curvature.
        const STEPS: [f64; 5] = [1e-6, 1e-6, 1e-6, 1e-7, 1e-7];
        let r = self.residual(x);
        let columns: Vec<DVector<f64>> = STEPS
            .iter()
            .enumerate()
            .map(|(index, step)| {
                let (mut above, mut below) = (x.to_vec(), x.to_vec());
                above[index] += step;
                // Lags may be on their bound, zero.
                below[index] = if index >= 3 { (below[index] - step).max(0.0) } else { below[index] - step };
                (self.residual(&above) - self.residual(&below)) / (above[index] - below[index])
            })
            .collect();
        let j = DMatrix::from_columns(&columns);
        Expansion { cost: 0.5 * r.norm_squared(), gradient: j.transpose() * &r, curvature: j.transpose() * &j }
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        // Up to half the sampling rate: a resonance above it is an alias of one below.
        let fastest = self.grid.map_or(FASTEST, |(interval, _)| std::f64::consts::PI / interval);
        vec![GAINS.map(f64::ln), [SLOWEST.ln(), fastest.ln()], ZETAS.map(f64::ln), LAGS_S, LAGS_S]
    }
}

/// Fits the reference model; `None` if no model fits.
pub(super) fn fit(raw: &[LineEstimate], grid: Grid) -> Option<ReferenceModel> {
    let excited: Vec<&LineEstimate> = raw.iter().filter(|point| point.excited && point.response.norm() > 0.0).collect();
    let points: Vec<&LineEstimate> = excited.iter().step_by(excited.len().div_ceil(POINTS).max(1)).copied().collect();
    if points.len() < FEWEST_POINTS {
        return None;
    }
    // At low frequency the response is k; at the edge of the band it may be noise.
    let noise = |point: &LineEstimate| point.variance / point.response.norm_sqr();
    let known = points.iter().find(|point| noise(point) < KNOWN_SHARE * KNOWN_SHARE);
    let first = known.or(points.iter().min_by(|a, b| noise(a).total_cmp(&noise(b))))?.response;
    let sign = if first.re < 0.0 { -1.0 } else { 1.0 };
    let highest = points[points.len() - 1].frequency_hz;
    let weights =
        points.iter().map(|point| 1.0 / (point.variance + SHARE_OF_RESPONSE * point.response.norm_sqr()).sqrt());
    let problem = LineFit { weights: weights.collect(), points, grid, sign };
    let starts = STARTS.map(|(ratio, turns)| {
        let omega = ratio * std::f64::consts::TAU * highest;
        let [lag, delay] = START_LAGS.map(|share| share / omega);
        vec![first.norm().ln(), omega.ln(), START_ZETA.ln(), lag, delay + turns / highest]
    });
    let best = starts
        .iter()
        .map(|start| minimise(&problem, start, LOOSE_TOLERANCE))
        .filter(|minimum| minimum.at.cost.is_finite())
        .min_by(|a, b| a.at.cost.total_cmp(&b.at.cost))?;
    let model = ReferenceModel::new(model_at(sign, &best.x)?, grid);
    // Deviations within the noise are no misfit; less accurate points have less weight.
    let (mut misfit, mut all) = (0.0, 0.0);
    for point in &problem.points {
        let power = point.response.norm_sqr();
        let miss = (point.response - model.lines(point.frequency_hz)).norm_sqr() / power;
        let noise = point.variance / power;
        let weight = 1.0 / (GREATEST_MISFIT * GREATEST_MISFIT + noise);
        misfit += weight * (miss - noise);
        all += weight;
    }
    let misfit = (misfit / all).max(0.0);
    (misfit.sqrt() < GREATEST_MISFIT).then_some(model)
}
