//! A hypothesis fitted to records: model, residuals, noise, information criterion.
//!
//! ```text
//! BIC = Σ_records (N ln σ² + q ln N) + m ln Σ N
//! ```
//!
//! The noise is estimated with each hypothesis: an autoregression of order q with innovations of variance σ², whose order is
//! penalised like any parameter (G. Schwarz, Ann. Stat. 6, 1978).

use nalgebra::DMatrix;

use super::{
    hypothesis::MeasurementTerm,
    jacobian::SimulationCache,
    output_error::{BaseSensitivities, OutputError, white},
    space::{ParameterIndex, Space},
    trace::{Trace, interval_s},
    whittle::{whittle_gain, whittle_power},
};
use crate::{
    estimate::noise::Noise,
    least_squares::{self, Ending, Expansion, Problem, minimise_within},
    linear_least_squares::dot,
    signal::record::{rms, without_mean},
};
use actuator_fmu::{effects::Effects, parameters::Model};

/// Rms of the noise over that of the position, at least: a smaller residual is rounding, not noise.
const ROUNDING_SHARE: f64 = 1e-9;

/// Share of the variance of the noise that is taken to be white: at 100 Hz of bandwidth its density falls by 30 dB at most.
const WHITE_SHARE: f64 = 1e-3;

/// A hypothesis at one θ.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Maps parameter vectors to models.
    pub space: Space,
    /// θ
    pub x: Vec<f64>,
    /// The model, measurement terms included.
    pub model: Model,
    /// Measured minus simulated position of each record, after the settling time [deg].
    pub residuals: Vec<Vec<f64>>,
    /// Factors of the measurement terms in each record.
    pub factors: Vec<Vec<f64>>,
    /// Noise of each record.
    pub noise: Vec<Noise>,
    /// Bayesian information criterion.
    pub bic: f64,
    /// Whether each parameter is at a bound of its range.
    pub at_bound: Vec<bool>,
    /// Whether a search converged here, to a tenth of a standard error.
    pub converged: bool,
}

/// Accuracy of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchEffort {
    /// To a loose tolerance, which shows how much a hypothesis may gain.
    Preliminary,
    /// From there to a tenth of a standard error.
    Continued,
    /// Both.
    Coarse,
    /// To a few thousandths of a standard error.
    Full,
}

/// A search has converged when a round changes the BIC by less.
const BIC_TOLERANCE: f64 = 0.1;

impl SearchEffort {
    /// Tolerance and greatest number of iterations of each round; the noise is estimated anew between rounds.
    fn rounds(self) -> &'static [(f64, usize)] {
        match self {
            Self::Preliminary => &[(1e-4, 12)],
            Self::Continued => &[(least_squares::LOOSE_TOLERANCE, 12)],
            Self::Coarse => &[(1e-4, 12), (least_squares::LOOSE_TOLERANCE, 12)],
            Self::Full => &[(1e-4, 30), (least_squares::LOOSE_TOLERANCE, 30), (least_squares::TIGHT_TOLERANCE, 30)],
        }
    }
}

impl Fitted {
    /// Searches from the start of the space; none where the motion diverges.
    pub fn search(space: Space, traces: &[Trace<'_>], effort: SearchEffort) -> Option<Self> {
        Self::search_with_sensitivities(space, traces, effort, None)
    }

    /// The same with sensitivities to the base from a similar model, for searches that need not be exact.
    pub fn search_with_sensitivities(
        space: Space,
        traces: &[Trace<'_>],
        effort: SearchEffort,
        base_sensitivities: Option<&BaseSensitivities>,
    ) -> Option<Self> {
        // A free base may reach poles that the samples do not show, whose simulation takes thousands of steps in each.
        let space = if space.hypothesis.wide { space.within_sampling(interval_s(traces)) } else { space };
        let cache = SimulationCache::default();
        let mut fitted = Self::evaluate(space.clone(), space.start(), traces, &cache)?;
        if fitted.x.is_empty() {
            return Some(fitted);
        }
        traces.first().into_iter().for_each(Trace::begin_search);
        let ends_early = effort != SearchEffort::Full;
        for (share, most_iterations) in effort.rounds() {
            let about_levels = fitted.noise_about_free_levels(traces);
            let noise = about_levels.as_deref().unwrap_or(&fitted.noise);
            let problem =
                OutputError { base_sensitivities, ends_early, ..OutputError::new(&space, traces, noise, &cache) };
            let minimum = minimise_within(&problem, &fitted.x, *share, *most_iterations);
            let Some(next) = Self::evaluate(space.clone(), minimum.x.clone(), traces, &cache) else { break };
            let gain = fitted.bic - next.bic;
            let is_fine = *share <= least_squares::LOOSE_TOLERANCE;
            let converged = (is_fine || gain.abs() < BIC_TOLERANCE) && minimum.ending != Ending::Stopped;
            if gain > 0.0 {
                fitted = Self { at_bound: minimum.at_bound, ..next };
            }
            fitted.converged = converged;
            // With the same noise a further round would end at the same place, unless this one ended early.
            if gain < BIC_TOLERANCE && (is_fine || !ends_early) {
                break;
            }
        }
        Some(fitted)
    }

    /// The noise about the means of the residuals, with which a search goes on where a steady load is free: a level that is left would be taken for slow
    /// noise, which hides it.
    fn noise_about_free_levels(&self, traces: &[Trace<'_>]) -> Option<Vec<Noise>> {
        let each = || traces.iter().zip(&self.residuals);
        let about_mean = || each().map(|(trace, residual)| noise(trace, &without_mean(residual))).collect();
        self.space.frees_steady_load().then(about_mean)
    }

    /// Without a search, at the start of the space.
    pub fn at_start(space: Space, traces: &[Trace<'_>]) -> Option<Self> {
        let x = space.start();
        Self::at(space, x, traces)
    }

    /// Without a search.
    pub fn at(space: Space, x: Vec<f64>, traces: &[Trace<'_>]) -> Option<Self> {
        Self::evaluate(space, x, traces, &SimulationCache::default())
    }

    fn evaluate(space: Space, x: Vec<f64>, traces: &[Trace<'_>], cache: &SimulationCache) -> Option<Self> {
        let flat: Vec<Noise> = traces.iter().map(|_| Noise::white(1.0)).collect();
        let problem = OutputError::new(&space, traces, &flat, cache);
        let record_residuals = problem.record_residuals(&x)?;
        let noise: Vec<Noise> =
            traces.iter().zip(&record_residuals).map(|(trace, left)| noise(trace, &left.residual)).collect();
        let bic = information_criterion(&noise, traces) + parameter_penalty(space.parameters(), traces);
        let mut model = space.model(&x)?;
        let (residuals, factors): (Vec<Vec<f64>>, Vec<Vec<f64>>) =
            record_residuals.into_iter().map(|left| (left.residual, left.factors)).unzip();
        model.effects = with_terms(&space, &x, model.effects, &factors, traces)?;
        let at_bound = vec![false; x.len()];
        let converged = x.is_empty();
        Some(Self { space, x, model, residuals, factors, noise, bic, at_bound, converged })
    }

    /// BIC of predicted instead of simulated residuals.
    pub fn predicted_bic(space: &Space, residuals: &[Vec<f64>], traces: &[Trace<'_>]) -> f64 {
        let noise: Vec<Noise> = traces.iter().zip(residuals).map(|(trace, residual)| noise(trace, residual)).collect();
        information_criterion(&noise, traces) + parameter_penalty(space.parameters(), traces)
    }

    /// Gain in likelihood over another hypothesis, with the noise taken from the spectrum around each frequency (P. Whittle, 1953):
    ///
    /// ```text
    /// Σ_records Σ_f (|R_other|² - |R|²) / S(f),    S the mean |R|² of the lines around f
    /// ```
    ///
    /// An autoregression cannot follow the edge of a band of noise; this estimate can, so that a line or band of
    /// dense noise is not taken for an effect.
    pub fn whittle_gain(&self, other: &Self) -> f64 {
        self.residuals.iter().zip(&other.residuals).map(|(residual, other)| whittle_gain(other, residual)).sum()
    }

    /// Σ of the squared difference between the residuals of two hypotheses, in units of the noise: the expected gain in likelihood if this one is
    /// true. The smaller of two values: with the noise as an autoregression, and with the noise from the spectrum around each frequency.
    pub fn expected_gain(&self, other: &Self) -> f64 {
        let each = self.residuals.iter().zip(&other.residuals);
        let differences: Vec<Vec<f64>> = each.map(|(here, there)| difference(here, there)).collect();
        let each = differences.iter().zip(&self.noise).map(|(difference, noise)| {
            let difference = white(noise, difference.clone());
            dot(&difference, &difference)
        });
        let over_density = self.residuals.iter().zip(&differences);
        let over_density = over_density.map(|(residual, difference)| whittle_power(difference, residual));
        each.sum::<f64>().min(over_density.sum())
    }

    /// Covariance of θ; none where the records do not determine it.
    ///
    /// A parameter on which nothing depends, such as a side of a limit that is never reached, has an infinite variance.
    pub fn covariance(&self, traces: &[Trace<'_>]) -> Option<DMatrix<f64>> {
        let mut curvature = self.expand(traces).curvature;
        let idle: Vec<usize> = (0..curvature.nrows()).filter(|place| curvature[(*place, *place)] == 0.0).collect();
        for place in &idle {
            curvature[(*place, *place)] = 1.0;
        }
        let mut covariance = curvature.try_inverse()?;
        for place in idle {
            covariance[(place, place)] = f64::INFINITY;
        }
        Some(covariance)
    }

    fn expand(&self, traces: &[Trace<'_>]) -> Expansion {
        let cache = SimulationCache::default();
        let problem = OutputError::new(&self.space, traces, &self.noise, &cache);
        problem.expand(&self.x)
    }

    /// On other records, with θ updated by them (one Gauss-Newton step), A the curvatures and g the gradient there:
    ///
    /// ```text
    /// θ - (A_fitted + A_other)⁻¹ g_other
    /// ```
    ///
    /// Where the other records determine a parameter better than the fit records, its error is no misfit.
    pub fn updated_with(&self, others: &[Trace<'_>], fitted: &[Trace<'_>]) -> Option<Self> {
        let there = self.on(others)?;
        let new = there.expand(others);
        let step = (self.expand(fitted).curvature + new.curvature).cholesky()?.solve(&new.gradient);
        let moved = self.x.iter().zip(step.iter()).zip(self.space.bounds());
        let x = moved.map(|((x, step), [least, greatest])| (x - step).clamp(least, greatest)).collect();
        Self::at(self.space.clone(), x, others)
    }

    /// Standard error of a parameter [its unit].
    pub fn std_error(&self, covariance: Option<&DMatrix<f64>>, name: ParameterIndex) -> Option<f64> {
        let (place, slope) = self.space.slope(&self.x, name)?;
        let variance = covariance?[(place, place)];
        (variance.is_finite() && variance > 0.0).then(|| slope * variance.sqrt())
    }

    /// Root mean square of the residuals of all records together [deg].
    pub fn rms(&self) -> f64 {
        let all: Vec<f64> = self.residuals.iter().flatten().copied().collect();
        rms(&all)
    }

    /// The same hypothesis and θ on other records, with the noise estimated there.
    pub fn on(&self, traces: &[Trace<'_>]) -> Option<Self> {
        Self::at(self.space.clone(), self.x.clone(), traces)
    }

    /// Twice the log-likelihood ratio over another hypothesis on the same records, without penalty for parameters.
    pub fn log_likelihood_gain(&self, other: &Self, traces: &[Trace<'_>]) -> f64 {
        information_criterion(&other.noise, traces) - information_criterion(&self.noise, traces)
    }
}

fn difference(one: &[f64], other: &[f64]) -> Vec<f64> {
    one.iter().zip(other).map(|(one, other)| one - other).collect()
}

/// Noise of a residual; the variance of its innovations is that of the whitened residual.
fn noise(trace: &Trace<'_>, residual: &[f64]) -> Noise {
    let floor = ROUNDING_SHARE * rms(trace.record.position()).max(f64::MIN_POSITIVE);
    let mut noise = Noise::with_white_share(residual, floor, WHITE_SHARE);
    let unit = white(&Noise { innovation_rms: 1.0, ..noise.clone() }, residual.to_vec());
    let count = (residual.len() - noise.coefficients.len().min(residual.len())).max(1);
    #[allow(clippy::cast_precision_loss)] // a count of samples
    let measured = (dot(&unit, &unit) / count as f64).sqrt();
    noise.innovation_rms = measured.max(floor);
    noise
}

#[allow(clippy::cast_precision_loss)] // counts of samples
fn information_criterion(noise: &[Noise], traces: &[Trace<'_>]) -> f64 {
    let each = noise.iter().zip(traces).map(|(noise, trace)| {
        let count = trace.evaluated_samples() as f64;
        2.0 * count * noise.innovation_rms.ln() + noise.coefficients.len() as f64 * count.ln()
    });
    each.sum()
}

/// m ln Σ N
#[allow(clippy::cast_precision_loss)] // counts of samples
fn parameter_penalty(parameters: usize, traces: &[Trace<'_>]) -> f64 {
    parameters as f64 * (traces.iter().map(Trace::evaluated_samples).sum::<usize>() as f64).ln()
}

/// Effects with the mean values of the measurement terms over the records.
#[allow(clippy::cast_precision_loss)] // counts of records
fn with_terms(
    space: &Space,
    x: &[f64],
    effects: Effects,
    factors: &[Vec<f64>],
    traces: &[Trace<'_>],
) -> Option<Effects> {
    let mut values = effects.values().to_vec();
    let mut set = |effect: &str, parameter: &str, value: f64| {
        if let Ok(index) = Effects::index(effect, parameter) {
            values[index] = value;
        }
    };
    let weight: f64 = traces.iter().map(|trace| trace.evaluated_samples() as f64).sum();
    let mean = |of: &dyn Fn(&[f64]) -> f64| {
        factors.iter().zip(traces).map(|(factors, trace)| trace.evaluated_samples() as f64 * of(factors)).sum::<f64>()
            / weight
    };
    for (index, term) in space.terms().enumerate() {
        let place = 2 * index;
        match term {
            // No effect: a level belongs to a record, not to the model.
            MeasurementTerm::Level => {}
            MeasurementTerm::Bias => {
                set("sensor_bias", "offset", mean(&|factors| factors[place]));
                set("sensor_bias", "drift", mean(&|factors| factors[place + 1]));
            }
            MeasurementTerm::Chatter => {
                let amplitude = mean(&|factors| factors[place].powi(2) + factors[place + 1].powi(2)).sqrt();
                set("chatter", "amplitude", amplitude);
                set("chatter", "frequency", space.chatter_hz(x));
                set("chatter", "phase", factors[0][place + 1].atan2(factors[0][place]));
            }
        }
    }
    Effects::with_values(&values).ok()
}
