//! The outcome of a likelihood search as a [`Fit`]: values, standard errors, unidentifiable parameters, provenance.

use nalgebra::DMatrix;

use super::{
    covariance,
    layout::{LN_K, LN_OMEGA, LN_ZETA, Lag, Layout, NO_LAG_S},
    noise::{Noise, ROUNDING_SHARE},
    output_error::{OutputError, RecordResidual},
    pole::{self, LagEstimate},
    result::{Estimate, Evidence, Fit, Pole, RecordFit, StartResult},
    search::{self, LocalMinimum},
    settings::{DelayChoice, Method, OrderChoice, Settings},
};
use crate::{
    digits,
    frequency::DelayedModel,
    least_squares::{Ending, Minimum},
    signal::{
        format::PositionUnit,
        record::{Record, rms},
    },
};
use actuator_fmu::{
    effects::Effects,
    error::{Error, Result},
    parameters::{Base, Model, Order, Provenance},
};

/// Half width of a 95 % interval in standard errors.
const NORMAL_95: f64 = 1.959_964;

/// The stated model with its uncertainty.
pub struct StatedModel {
    /// Layout of θ.
    pub layout: Layout,
    /// θ
    pub x: Vec<f64>,
    covariance: Option<DMatrix<f64>>,
    /// Upper limit of the lag [s]; `None` if the pole is identified or not part of the model.
    pub limit_s: Option<f64>,
    at_bound: Vec<bool>,
    ending: Ending,
}

impl StatedModel {
    /// Without a pole.
    pub fn second(problem: &OutputError<'_>, minimum: &Minimum) -> Self {
        Self {
            layout: Layout { lag: Lag::None, ..problem.layout },
            x: minimum.x.clone(),
            covariance: covariance::inverse(&minimum.at.curvature),
            limit_s: None,
            at_bound: minimum.at_bound.clone(),
            ending: minimum.ending,
        }
    }

    /// With the estimated lag.
    pub fn third(problem: &OutputError<'_>, minimum: &Minimum, lag: &LagEstimate) -> Self {
        let (x, ending) = match lag.limit_s {
            Some(_) => pole::at_lag(problem, minimum, lag.lag_s),
            None => (minimum.x.clone(), minimum.ending),
        };
        // The stated lag comes from the search with the lag free.
        let ending = if minimum.ending.is_minimum() { ending } else { minimum.ending };
        Self {
            layout: problem.layout,
            covariance: pole::covariance(problem, &x, lag.spread_s),
            x,
            limit_s: lag.limit_s,
            at_bound: minimum.at_bound.clone(),
            ending,
        }
    }

    /// Residual rms over all records.
    pub fn residual_rms(&self, problem: &OutputError<'_>) -> f64 {
        let residuals = problem.with_layout(self.layout).residuals(&self.x);
        rms(&residuals.into_iter().flat_map(|left| left.residual).collect::<Vec<f64>>())
    }

    /// Estimates in the order k, p, omega, zeta, delay, each with its index in θ.
    fn estimates(&self, model: &DelayedModel, unit: PositionUnit) -> Vec<(Estimate, usize)> {
        // A factor of e^1000 is not an error: the records do not determine the parameter.
        const UNDETERMINED: f64 = 1e3;
        let error = |place: usize| {
            let covariance = self.covariance.as_ref()?;
            Some(covariance[(place, place)].sqrt()).filter(|error| *error < UNDETERMINED)
        };
        // The error of a logarithm is a relative error.
        let logarithmic = |name, unit, value: f64, place: usize| {
            let relative = error(place);
            let estimate = Estimate {
                name,
                unit,
                value,
                std_error: relative.map(|relative| relative * value.abs()),
                interval_95: relative.map(|relative| {
                    let ends = [-1.0, 1.0].map(|side: f64| value * (side * NORMAL_95 * relative).exp());
                    [ends[0].min(ends[1]), ends[0].max(ends[1])]
                }),
                at_bound: self.at_bound[place],
            };
            (estimate, place)
        };
        let base = &model.base;
        let mut estimates = vec![logarithmic("k", unit.of_gain(), base.k(), LN_K)];
        if self.layout.lag == Lag::Free && self.limit_s.is_none() {
            let lag = 1.0 / base.p();
            let estimate = Estimate {
                name: "p",
                unit: "1/s",
                value: base.p(),
                std_error: error(3).map(|error| error / (lag * lag)),
                interval_95: error(3).map(|error| [1.0, -1.0].map(|side| 1.0 / (lag + side * NORMAL_95 * error))),
                at_bound: self.at_bound[3],
            };
            estimates.push((estimate, 3));
        }
        estimates.push(logarithmic("omega", "rad/s", base.omega(), LN_OMEGA));
        estimates.push(logarithmic("zeta", "1", base.zeta(), LN_ZETA));
        if let Some(place) = self.layout.delay_place() {
            let estimate = Estimate {
                name: "delay",
                unit: "s",
                value: model.delay_s,
                std_error: error(place),
                interval_95: error(place)
                    .map(|error| [-1.0, 1.0].map(|side| (model.delay_s + side * NORMAL_95 * error).max(0.0))),
                at_bound: self.at_bound[place],
            };
            estimates.push((estimate, place));
        }
        estimates
    }

    /// Note if only the slower pole of an overdamped pair, s = ω (ζ - √(ζ² - 1)), is identified.
    ///
    /// ```text
    /// ∂ln s/∂ln ω = 1,  ∂ln s/∂ln ζ = -ζ / √(ζ² - 1)
    /// ```
    fn single_pole(&self, base: &Base) -> Option<String> {
        /// Maximum relative standard error of an identified pole.
        const SHOWN: f64 = 0.1;
        let covariance = self.covariance.as_ref().filter(|_| base.zeta() > 1.0)?;
        let root = (base.zeta().powi(2) - 1.0).sqrt();
        let slope = -base.zeta() / root;
        let at = |row: usize, column: usize| covariance[(row, column)];
        let variance =
            at(LN_OMEGA, LN_OMEGA) + slope * slope * at(LN_ZETA, LN_ZETA) + 2.0 * slope * at(LN_OMEGA, LN_ZETA);
        let relative = Some(variance.sqrt()).filter(|relative| *relative < SHOWN)?;
        let pole = base.omega() * (base.zeta() - root);
        Some(format!(
            "the records identify only one pole of omega and zeta, {} +- {} 1/s, as of a first-order actuator; any pair with that pole and a \
             faster one fits as well",
            digits::significant(pole, 4),
            digits::significant(relative * pole, 2)
        ))
    }

    fn correlations(&self, estimates: &[(Estimate, usize)]) -> Vec<Vec<f64>> {
        let Some(covariance) = &self.covariance else { return Vec::new() };
        // p falls when its lag increases.
        let sign = |estimate: &Estimate| if estimate.name == "p" { -1.0 } else { 1.0 };
        let row = |(one, a): &(Estimate, usize)| -> Vec<f64> {
            let with =
                |(other, b): &(Estimate, usize)| sign(one) * sign(other) * covariance::correlation(covariance, *a, *b);
            estimates.iter().map(with).collect()
        };
        estimates.iter().map(row).collect()
    }

    /// For ln k, ln ω, ln ζ, the lag and the delay, not all of which are in every layout.
    fn joint_covariance(&self) -> Option<[[f64; 5]; 5]> {
        let covariance = self.covariance.as_ref()?;
        let lag = (self.layout.lag == Lag::Free).then_some(3);
        let places = [Some(LN_K), Some(LN_OMEGA), Some(LN_ZETA), lag, self.layout.delay_place()];
        let at = |row: Option<usize>, column: Option<usize>| {
            row.zip(column).map_or(0.0, |(row, column)| covariance[(row, column)])
        };
        Some(places.map(|row| places.map(|column| at(row, column))))
    }

    fn model(
        &self,
        delayed: &DelayedModel,
        estimates: &[Estimate],
        pole: Pole,
        records: &[Record],
        settings: &Settings,
    ) -> Result<Model> {
        let base = &delayed.base;
        // The stated lag may be zero, which is eq. (6), unless eq. (1) was requested.
        let no_lag = 1.0 / base.p() <= NO_LAG_S && settings.order != OrderChoice::Third;
        let second = self.layout.lag == Lag::None || no_lag;
        // A file must contain a value of p. Without a pole it is not used; if unknown, it is that of the stated lag.
        let p = match (second, pole) {
            (true, Pole::Above(bound)) => bound,
            (true, _) => Base::PARAMETERS[1].nominal,
            _ => base.p(),
        };
        let mut model = Model::new(
            Base::new(base.k(), p, base.omega(), base.zeta())?,
            if second { Order::Second } else { Order::Third },
        );
        for (index, parameter) in Base::PARAMETERS.iter().enumerate() {
            let of = estimates.iter().find(|estimate| estimate.name == parameter.name);
            model.std_errors[index] = of.and_then(|estimate| estimate.std_error);
        }
        if delayed.delay_s > 0.0 {
            let index = Effects::index("delay", "time")?;
            let mut values = model.effects.values().to_vec();
            values[index] = delayed.delay_s;
            model.effects = Effects::with_values(&values)?;
            let of = estimates.iter().find(|estimate| estimate.name == "delay");
            model.effect_std_errors[index] = of.and_then(|estimate| estimate.std_error);
        }
        let known = match pole {
            Pole::Above(bound) => format!("; p is not identifiable, above {} 1/s (95 %)", significant(bound)),
            _ => String::new(),
        };
        let delay = match (settings.delay, delayed.delay_s) {
            (DelayChoice::Free, delay) => format!("; delay estimated, {delay} s"),
            (DelayChoice::Declared(delay), _) if delay > 0.0 => format!("; delay declared, {delay} s"),
            _ => String::new(),
        };
        model.provenance = Provenance {
            records: records.iter().map(|record| record.source().display().to_string()).collect(),
            hashes: records.iter().map(|record| record.sha256().to_owned()).collect(),
            method: Some(format!("maximum likelihood, output error{known}{delay}")),
            date: None,
        };
        Ok(model)
    }
}

/// The outcome of a search.
pub struct Outcome<'a> {
    /// The stated model.
    pub stated: StatedModel,
    /// The minimised cost.
    pub problem: OutputError<'a>,
    /// End of each start.
    pub found: Vec<LocalMinimum>,
    /// Models compared.
    pub evidence: Vec<Evidence>,
    /// Notes.
    pub notes: Vec<String>,
}

impl Outcome<'_> {
    /// As a [`Fit`].
    pub fn into_fit(self, records: &[Record], settings: &Settings) -> Result<Fit> {
        let Self { stated, problem, found, evidence, notes } = self;
        let problem = problem.with_layout(stated.layout);
        let Some(delayed) = stated.layout.model(&stated.x) else {
            return Err(Error::new("fit", "parameters outside their range", "a model"));
        };
        let estimates = stated.estimates(&delayed, records[0].unit());
        let correlations = stated.correlations(&estimates);
        let estimates: Vec<Estimate> = estimates.into_iter().map(|(estimate, _)| estimate).collect();
        let pole = match (stated.layout.lag, stated.limit_s) {
            (_, Some(limit)) => Pole::Above(1.0 / limit),
            (Lag::Free, None) => Pole::Found,
            _ => Pole::Untold,
        };
        let mut not_identifiable = Vec::new();
        if let Pole::Above(bound) = pole {
            not_identifiable.push(format!("p: above {} 1/s (95 %), a lower limit only", significant(bound)));
        }
        not_identifiable.extend(estimates.iter().filter_map(unknown));
        let is_untold = |estimate: &Estimate| {
            ["omega", "zeta"].contains(&estimate.name) && (estimate.at_bound || unknown(estimate).is_some())
        };
        let mut notes = notes;
        notes.extend(estimates.iter().any(is_untold).then(|| stated.single_pole(&delayed.base)).flatten());
        let at_bound = estimates.iter().filter(|estimate| estimate.at_bound).map(|estimate| estimate.name.to_owned());
        let residuals = problem.residuals(&stated.x);
        let noise = Residual::of(records, &residuals);
        let samples: usize = records.iter().map(Record::len).sum();
        Ok(Fit {
            model: stated.model(&delayed, &estimates, pole, records, settings)?,
            method: Method::Likelihood,
            correlations,
            covariance: stated.joint_covariance(),
            pole,
            delay_s: delayed.delay_s,
            ending: stated.ending.sentence().to_owned(),
            converged: stated.ending.is_minimum(),
            at_bound: at_bound.collect(),
            not_identifiable,
            starts: starts(&found, samples),
            unit: records[0].unit().name(),
            residual_rms: noise.rms,
            innovation_rms: noise.innovation_rms,
            noise_order: Some(noise.order),
            effective_samples: noise.effective_samples,
            records: records.iter().zip(&residuals).map(|(record, left)| RecordFit::new(record, left)).collect(),
            evidence,
            notes,
            estimates,
        })
    }
}

/// Residual of all records together.
struct Residual {
    rms: f64,
    innovation_rms: f64,
    order: usize,
    effective_samples: f64,
}

impl Residual {
    #[allow(clippy::cast_precision_loss)] // counts of samples
    fn of(records: &[Record], residuals: &[RecordResidual]) -> Self {
        let mut all = Self { rms: 0.0, innovation_rms: 0.0, order: 0, effective_samples: 0.0 };
        let mut count = 0.0;
        for (record, RecordResidual { residual, .. }) in records.iter().zip(residuals) {
            let noise = Noise::of(residual, ROUNDING_SHARE * rms(record.position()));
            let samples = residual.len() as f64;
            all.rms += residual.iter().map(|value| value * value).sum::<f64>();
            all.innovation_rms += samples * noise.innovation_rms.powi(2);
            all.order = all.order.max(noise.coefficients.len());
            all.effective_samples += samples * noise.effective_share();
            count += samples;
        }
        Self { rms: (all.rms / count).sqrt(), innovation_rms: (all.innovation_rms / count).sqrt(), ..all }
    }
}

fn unknown(estimate: &Estimate) -> Option<String> {
    // An error of half the value leaves no significant digit.
    const SHARE: f64 = 0.5;
    match estimate.std_error {
        Some(error) if estimate.name == "delay" => {
            (error * NORMAL_95 > estimate.value).then(|| "delay: cannot be distinguished from zero".to_owned())
        }
        Some(error) if error < SHARE * estimate.value.abs() => None,
        Some(error) => Some(format!(
            "{}: standard error {} of a value of {}",
            estimate.name,
            significant(error),
            significant(estimate.value)
        )),
        None => Some(format!("{}: the records do not determine it", estimate.name)),
    }
}

/// Two significant digits, for words.
pub fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    #[allow(clippy::cast_possible_truncation)] // a decimal exponent
    let digits = 1 - value.abs().log10().floor() as i32;
    let scale = 10_f64.powi(digits);
    let rounded = (value * scale).round() / scale;
    if digits > 0 { format!("{rounded:.*}", usize::try_from(digits).unwrap_or(0)) } else { rounded.to_string() }
}

/// Each start compared with the best one, all searched with the same noise.
#[allow(clippy::cast_precision_loss)] // counts of samples
fn starts(found: &[LocalMinimum], samples: usize) -> Vec<StartResult> {
    let best = search::best(found);
    // With the noise variance free, one standard error costs half a unit of ½ N ln(cost): a fraction 1/N of the cost.
    let as_likely = |cost: f64, least: f64| cost - least <= least / samples as f64;
    let at_best = |here: &Minimum| {
        best.is_some_and(|best| search::agree(&here.x, &best.x) || as_likely(here.at.cost, best.at.cost))
    };
    let result = |found: &LocalMinimum| StartResult {
        start: found.start.base.values(),
        end: found.end.base.values(),
        cost: found.minimum.at.cost,
        iterations: found.minimum.iterations,
        ending: found.minimum.ending.sentence().to_owned(),
        converged: found.minimum.ending.is_minimum(),
        at_best: at_best(&found.minimum),
    };
    found.iter().map(result).collect()
}
