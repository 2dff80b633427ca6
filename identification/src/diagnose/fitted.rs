//! A hypothesis fitted to records: its model, what it leaves, and how much the records speak for it.
//!
//! ```text
//! BIC = Σ_records (N ln σ² + q ln N) + m ln Σ N
//! ```
//!
//! Each hypothesis brings its own noise: an autoregression of order q with innovations of variance σ², so that colour is paid for
//! as colour and no gap is taken for information that coloured noise does not hold (G. Schwarz, Ann. Stat. 6, 1978).

use nalgebra::DMatrix;

use super::{
    hypothesis::Term,
    output_error::{BaseColumns, Explanation, Lately, white},
    space::{Name, Space},
    trace::Trace,
    whittle::whittle_power,
};
use crate::{
    estimate::noise::Noise,
    least_squares::{self, Expansion, Problem, minimise_within},
    linear_least_squares::dot,
    signal::record::rms,
};
use actuator_fmu::{effects::Effects, parameters::Model};

/// A residual below this share of the position is rounding, not noise.
const ROUNDING_SHARE: f64 = 1e-9;

/// Share of the noise's variance that is taken to be white: at 100 Hz of bandwidth a band of noise ends 30 dB lower at most.
const WHITE_SHARE: f64 = 1e-3;

/// A hypothesis at one θ.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// How vectors become models.
    pub space: Space,
    /// θ
    pub x: Vec<f64>,
    /// The model, terms of the measurement included.
    pub model: Model,
    /// Measured less simulated position of each record, from the first sample that counts on [deg].
    pub residuals: Vec<Vec<f64>>,
    /// Factors of the terms in each record.
    pub factors: Vec<Vec<f64>>,
    /// Noise of each record.
    pub noise: Vec<Noise>,
    /// Bayesian information criterion.
    pub bic: f64,
    /// Whether any number lies on a bound of its range.
    pub at_bound: Vec<bool>,
}

/// How carefully a search is ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Care {
    /// As far as shows what a hypothesis may come to.
    Promise,
    /// On from there to a tenth of a standard error.
    Kept,
    /// Both.
    Rough,
    /// To rounding.
    Fine,
}

/// A change of BIC that says nothing.
const SETTLED: f64 = 0.1;

impl Care {
    /// Shares of the cost at which the rounds of a search end, and iterations after which they do; between them the noise is measured
    /// anew. A search that creeps is one among rivals that do not.
    fn rounds(self) -> &'static [(f64, usize)] {
        match self {
            Self::Promise => &[(1e-4, 12)],
            Self::Kept => &[(least_squares::LOOSE_TOLERANCE, 12)],
            Self::Rough => &[(1e-4, 12), (least_squares::LOOSE_TOLERANCE, 12)],
            Self::Fine => &[(1e-4, 30), (least_squares::LOOSE_TOLERANCE, 30), (least_squares::TIGHT_TOLERANCE, 30)],
        }
    }
}

impl Fitted {
    /// Searches from where the space starts; none where no motion is possible.
    pub fn search(space: Space, traces: &[Trace<'_>], care: Care) -> Option<Self> {
        Self::search_near(space, traces, care, None)
    }

    /// The same with sensitivities to the base from near by, for searches that need not end exactly.
    pub fn search_near(
        space: Space,
        traces: &[Trace<'_>],
        care: Care,
        base_columns: Option<&BaseColumns>,
    ) -> Option<Self> {
        let lately = Lately::default();
        let mut fitted = Self::at_once(space.clone(), space.start(), traces, &lately)?;
        if fitted.x.is_empty() {
            return Some(fitted);
        }
        for (share, most_iterations) in care.rounds() {
            let explanation =
                Explanation { space: &space, traces, noise: &fitted.noise, base_columns, lately: &lately };
            let minimum = minimise_within(&explanation, &fitted.x, *share, *most_iterations);
            let Some(next) = Self::at_once(space.clone(), minimum.x.clone(), traces, &lately) else { break };
            let gain = fitted.bic - next.bic;
            if gain > 0.0 {
                fitted = Self { at_bound: minimum.at_bound, ..next };
            }
            // Noise that has not changed leads nowhere else.
            if gain < SETTLED {
                break;
            }
        }
        Some(fitted)
    }

    /// Without a search, where the space starts.
    pub fn at_start(space: Space, traces: &[Trace<'_>]) -> Option<Self> {
        let x = space.start();
        Self::at(space, x, traces)
    }

    /// Without a search.
    pub fn at(space: Space, x: Vec<f64>, traces: &[Trace<'_>]) -> Option<Self> {
        Self::at_once(space, x, traces, &Lately::default())
    }

    fn at_once(space: Space, x: Vec<f64>, traces: &[Trace<'_>], lately: &Lately) -> Option<Self> {
        let flat: Vec<Noise> = traces.iter().map(|_| Noise::white(1.0)).collect();
        let explanation = Explanation { space: &space, traces, noise: &flat, base_columns: None, lately };
        let remainders = explanation.remainders(&x)?;
        let noise: Vec<Noise> =
            traces.iter().zip(&remainders).map(|(trace, left)| noise(trace, &left.residual)).collect();
        let bic = criterion(&noise, traces) + parameters_cost(space.parameters(), traces);
        let mut model = space.model(&x)?;
        let (residuals, factors): (Vec<Vec<f64>>, Vec<Vec<f64>>) =
            remainders.into_iter().map(|left| (left.residual, left.factors)).unzip();
        model.effects = with_terms(&space, &x, model.effects, &factors, traces)?;
        let at_bound = vec![false; x.len()];
        Some(Self { space, x, model, residuals, factors, noise, bic, at_bound })
    }

    /// BIC of residuals that were not simulated but foreseen.
    pub fn judged(space: &Space, residuals: &[Vec<f64>], traces: &[Trace<'_>]) -> f64 {
        let noise: Vec<Noise> = traces.iter().zip(residuals).map(|(trace, residual)| noise(trace, residual)).collect();
        criterion(&noise, traces) + parameters_cost(space.parameters(), traces)
    }

    /// Gain in likelihood over another with the noise taken from the spectrum around each frequency (P. Whittle, 1953):
    ///
    /// ```text
    /// Σ_records Σ_f (|R_other|² - |R|²) / S(f),    S the mean |R|² of the lines around f
    /// ```
    ///
    /// An autoregression cannot follow the edge of a band of noise; this can, and a line or a band that only looks like an effect
    /// because the noise is dense there gains nothing.
    pub fn local_gain(&self, other: &Self) -> f64 {
        self.in_local_noise(&other.residuals) - self.in_local_noise(&self.residuals)
    }

    /// Σ of the squared difference to what another leaves, in units of the noise: the gain in likelihood that is to be expected if
    /// this one is true. The noise is the autoregression or the spectrum around each frequency, whichever drowns more.
    pub fn distance(&self, other: &Self) -> f64 {
        let each = self.residuals.iter().zip(&other.residuals);
        let differences: Vec<Vec<f64>> = each.map(|(here, there)| difference(here, there)).collect();
        let each = differences.iter().zip(&self.noise).map(|(difference, noise)| {
            let difference = white(noise, difference.clone());
            dot(&difference, &difference)
        });
        each.sum::<f64>().min(self.in_local_noise(&differences))
    }

    /// Power of some columns, one for each record, over the density of this residual around each frequency.
    fn in_local_noise(&self, columns: &[Vec<f64>]) -> f64 {
        self.residuals.iter().zip(columns).map(|(residual, column)| whittle_power(column, residual)).sum()
    }

    /// Covariance of θ; none where the records do not determine it.
    pub fn covariance(&self, traces: &[Trace<'_>]) -> Option<DMatrix<f64>> {
        self.expand(traces).curvature.try_inverse()
    }

    fn expand(&self, traces: &[Trace<'_>]) -> Expansion {
        let lately = Lately::default();
        let explanation =
            Explanation { space: &self.space, traces, noise: &self.noise, base_columns: None, lately: &lately };
        explanation.expand(&self.x)
    }

    /// On other records, with the θ that these and the fitted ones make likely together, A the curvatures and g the gradient there:
    ///
    /// ```text
    /// θ - (A_fitted + A_other)⁻¹ g_other
    /// ```
    ///
    /// Where the other records say more of a number than the fitted ones, its error there is no gap.
    pub fn reconciled_with(&self, others: &[Trace<'_>], fitted: &[Trace<'_>]) -> Option<Self> {
        let there = self.on(others)?;
        let new = there.expand(others);
        let step = (self.expand(fitted).curvature + new.curvature).cholesky()?.solve(&new.gradient);
        let moved = self.x.iter().zip(step.iter()).zip(self.space.bounds());
        let x = moved.map(|((x, step), [least, greatest])| (x - step).clamp(least, greatest)).collect();
        Self::at(self.space.clone(), x, others)
    }

    /// Standard error of a parameter [its unit].
    pub fn std_error(&self, covariance: Option<&DMatrix<f64>>, name: Name) -> Option<f64> {
        let (place, slope) = self.space.slope(&self.x, name)?;
        let variance = covariance?[(place, place)];
        (variance.is_finite() && variance > 0.0).then(|| slope * variance.sqrt())
    }

    /// Root mean square of what is left over all records [deg].
    pub fn rms(&self) -> f64 {
        let all: Vec<f64> = self.residuals.iter().flatten().copied().collect();
        rms(&all)
    }

    /// The same hypothesis and θ on other records, with the noise found there.
    pub fn on(&self, traces: &[Trace<'_>]) -> Option<Self> {
        Self::at(self.space.clone(), self.x.clone(), traces)
    }

    /// Twice the logarithm of the likelihood ratio against another on the same records, without any price for parameters.
    pub fn chi_square_below(&self, other: &Self, traces: &[Trace<'_>]) -> f64 {
        criterion(&other.noise, traces) - criterion(&self.noise, traces)
    }
}

fn difference(one: &[f64], other: &[f64]) -> Vec<f64> {
    one.iter().zip(other).map(|(one, other)| one - other).collect()
}

/// Noise of a residual, its innovations measured rather than foreseen.
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
fn criterion(noise: &[Noise], traces: &[Trace<'_>]) -> f64 {
    let each = noise.iter().zip(traces).map(|(noise, trace)| {
        let count = trace.counted() as f64;
        2.0 * count * noise.innovation_rms.ln() + noise.coefficients.len() as f64 * count.ln()
    });
    each.sum()
}

/// m ln Σ N
#[allow(clippy::cast_precision_loss)] // counts of samples
fn parameters_cost(parameters: usize, traces: &[Trace<'_>]) -> f64 {
    parameters as f64 * (traces.iter().map(Trace::counted).sum::<usize>() as f64).ln()
}

/// Effects with the terms' values of all records together.
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
    let weight: f64 = traces.iter().map(|trace| trace.counted() as f64).sum();
    let mean = |of: &dyn Fn(&[f64]) -> f64| {
        factors.iter().zip(traces).map(|(factors, trace)| trace.counted() as f64 * of(factors)).sum::<f64>() / weight
    };
    for (index, term) in space.terms().enumerate() {
        let place = 2 * index;
        match term {
            Term::Bias => {
                set("sensor_bias", "offset", mean(&|factors| factors[place]));
                set("sensor_bias", "drift", mean(&|factors| factors[place + 1]));
            }
            Term::Chatter => {
                let amplitude = mean(&|factors| factors[place].powi(2) + factors[place + 1].powi(2)).sqrt();
                set("chatter", "amplitude", amplitude);
                set("chatter", "frequency", space.chatter_hz(x));
                set("chatter", "phase", factors[0][place + 1].atan2(factors[0][place]));
            }
        }
    }
    Effects::with_values(&values).ok()
}
