//! Maximum likelihood on the records themselves.
//!
//! 1. A coarse look over ω and ζ gives the starts ([`super::search`]); each is searched with white noise.
//! 2. The residual gives the noise its size and its colour ([`super::noise`]), and the search is repeated, whitened.
//! 3. Were the model right, both ends would agree within their standard errors. If they do not, the residual is no noise but
//!    something that the model lacks; then the plain residual decides (its least rms is what a user can check), and
//!    standard errors allow for its colour.
//! 4. The pole is studied ([`super::pole`]), the order chosen, standard errors and correlations stated.

use nalgebra::DMatrix;

use super::{
    Estimate, Evidence, Fit, Method, OrderChoice, Pole, RecordFit, Settings, StartResult,
    noise::Noise,
    output_error::{LN_K, LN_OMEGA, LN_ZETA, Lag, Layout, OutputError, dot},
    pole::{self, LagPrior, SMALL_LAG_S, Study},
    search::{self, Found},
    simulation::{Delayed, Drive},
};
use crate::{
    effects::Effects,
    error::{Error, Result},
    estimate::DelayChoice,
    least_squares::{Minimum, Problem, minimise},
    parameters::{Base, Model, Order, Provenance},
    signal::record::{Record, rms},
};

/// Half width of a 95 % interval in standard errors.
const NORMAL_95: f64 = 1.959_964;

/// A residual below this share of the position is no noise of any sensor, but rounding errors.
const ROUNDING_SHARE: f64 = 1e-10;

/// Evidence (twice the logarithm of the odds) that counts as strong.
pub const STRONG: f64 = 10.0;

/// Ends of two searches that differ by more of their standard errors are not two estimates of one thing.
const SAME_WITHIN: f64 = 3.0;

/// How often noise and parameters are brought into agreement.
const ROUNDS: usize = 2;

/// Fits records.
pub fn fit(records: &[Record], settings: &Settings) -> Result<Fit> {
    let drives: Vec<(&Record, Drive)> = records.iter().map(|record| (record, Drive::new(record))).collect();
    let coarse = search::starts(&drives);
    let Some(first) = coarse.first() else {
        return Err(Error::new("position", "no motion that follows the command", "a response to the command")
            .remedy("check the columns, and that command and position are from one actuator")
            .at(records[0].source(), None));
    };
    let declared_delay_s = match settings.delay {
        DelayChoice::Declared(delay) => Some(delay),
        DelayChoice::Free => None,
    };
    let mut starts = coarse.clone();
    if let Some(given) = &settings.starts {
        starts.clear();
        for values in given {
            let base = Base::from_values(*values)?;
            starts.push(Delayed { base, order: Order::Third, delay_s: declared_delay_s.unwrap_or(0.0) });
        }
    }
    let lag = if settings.order == OrderChoice::Second { Lag::None } else { Lag::Free };
    let layout = Layout { lag, declared_delay_s, sign: first.base.k().signum() };
    let search = Search::run(&drives, layout, &starts)?;
    search.result(records, settings)
}

/// A finished search: the model with most freedom that was asked for, and the same without a pole.
struct Search<'a> {
    problem: OutputError<'a>,
    minimum: Minimum,
    /// Without a pole.
    second: Minimum,
    found: Vec<Found>,
    misfit: bool,
    notes: Vec<String>,
}

impl<'a> Search<'a> {
    fn run(drives: &'a [(&'a Record, Drive<'a>)], layout: Layout, starts: &[Delayed]) -> Result<Self> {
        let sizes: Vec<f64> = drives.iter().map(|(record, _)| rms(record.position()).max(f64::MIN_POSITIVE)).collect();
        let noise = sizes.iter().map(|size| Noise::white(*size)).collect();
        let mut problem = OutputError::new(layout, drives, noise);
        let found = search::from_starts(&problem, starts);
        let Some(best) = search::best(&found) else {
            return Err(Error::new("search", "no start with a finite cost", "one"));
        };
        let mut minimum = best.clone();
        let floors: Vec<f64> = sizes.iter().map(|size| size * ROUNDING_SHARE).collect();
        let of_each = |problem: &OutputError, x: &[f64], noise: &dyn Fn(&[f64], f64) -> Noise| -> Vec<Noise> {
            let remainders = problem.remainders(x);
            remainders.iter().zip(&floors).map(|(remainder, floor)| noise(&remainder.residual, *floor)).collect()
        };

        // White noise of each record's own size.
        let white = of_each(&problem, &minimum.x, &|residual, floor| Noise::white(rms(residual).max(floor)));
        problem = OutputError::new(layout, drives, white);
        minimum = minimise(&problem, &minimum.x);

        // Coloured noise.
        let mut coloured = OutputError::new(layout, drives, of_each(&problem, &minimum.x, &Noise::of));
        let mut notes = Vec::new();
        let mut misfit = false;
        if coloured.noise().iter().any(|noise| !noise.coefficients.is_empty()) {
            let (sandwich, inflation) = sandwich(&problem, &coloured, &minimum);
            let mut whitened = minimise(&coloured, &minimum.x);
            for _ in 1..ROUNDS {
                coloured = OutputError::new(layout, drives, of_each(&coloured, &whitened.x, &Noise::of));
                whitened = minimise(&coloured, &whitened.x);
            }
            misfit = (LN_K..=LN_ZETA).any(|place| {
                (whitened.x[place] - minimum.x[place]).abs() > SAME_WITHIN * sandwich[(place, place)].sqrt()
            });
            if misfit {
                notes.push(
                    "the residual is not noise alone: what is left depends on the command, so that the model lacks something; \
                     standard errors allow for the colour of the residual, not for what the model lacks"
                        .to_owned(),
                );
                let inflate = |noise: &Noise| Noise::white(noise.innovation_rms * inflation.sqrt());
                problem = OutputError::new(layout, drives, problem.noise().iter().map(inflate).collect());
                minimum = minimise(&problem, &minimum.x);
            } else {
                (problem, minimum) = (coloured, whitened);
            }
        }
        let second = without_pole(&problem, &minimum);
        Ok(Self { problem, minimum, second, found, misfit, notes })
    }

    fn result(mut self, records: &[Record], settings: &Settings) -> Result<Fit> {
        let samples: f64 = records.iter().zip(self.problem.noise()).map(|(record, _)| count(record.len())).sum();
        let mut evidence = Vec::new();
        let mut choice = Choice::second(&self.problem, &self.second);
        if self.problem.layout.lag == Lag::Free {
            let study = pole::study(&self.problem, &self.minimum, self.second.at.cost, samples, settings.lag_prior);
            let mut rows = vec![("third order", 1, 0.0), ("second order", 0, study.odds)];
            if study.odds < 0.0 {
                rows = vec![("second order", 0, 0.0), ("third order", 1, -study.odds)];
            }
            evidence.extend(rows.into_iter().map(|(model, more, delta_bic)| Evidence {
                model: model.into(),
                parameters: self.second.x.len() + more,
                delta_bic,
            }));
            // Eq. (6) is eq. (1) without a lag: unless the evidence speaks against a pole, it stays, with what is unknown of it.
            if settings.order == OrderChoice::Third || study.odds > -STRONG {
                self.notes.extend(prior_note(settings.lag_prior, &study));
                choice = Choice::third(&self.problem, &self.minimum, study);
            } else {
                choice.limit_s = study.limit_s;
            }
        }
        self.notes.extend(self.delay_note(&choice, samples));
        choice.finish(evidence, self, records, settings)
    }

    /// A delay that nobody declared but the records show.
    fn delay_note(&self, choice: &Choice, samples: f64) -> Option<String> {
        self.problem.layout.declared_delay_s?;
        let layout = Layout { lag: Lag::None, declared_delay_s: None, ..self.problem.layout };
        let problem = self.problem.with_layout(layout);
        let start = self.problem.with_layout(choice.layout).layout.model(&choice.x)?;
        let lag = 2.0 * start.base.zeta() / start.base.omega()
            + if choice.layout.lag == Lag::None { 0.0 } else { 1.0 / start.base.p() };
        let delay_s = start.delay_s + 0.3 * lag;
        let base = Base::new(start.base.k(), start.base.p(), start.base.omega() / 0.7, start.base.zeta()).ok()?;
        let with = minimise(&problem, &layout.place(&Delayed { base, order: Order::Second, delay_s }));
        let gain = 2.0 * (choice.cost - with.at.cost) - samples.ln();
        let found = with.x[with.x.len() - 1];
        (gain > STRONG).then(|| {
            format!(
                "second order with a delay of {:.2} ms explains the records better (twice the logarithm of the odds {gain:.0}): \
                 declare it, or estimate it with --delay free",
                1e3 * found
            )
        })
    }
}

#[allow(clippy::cast_precision_loss)] // counts of samples
fn count(samples: usize) -> f64 {
    samples as f64
}

/// Covariance of a search with white noise when the noise is coloured, A⁻¹ J'ΩJ A⁻¹, and the greatest share by which it
/// exceeds the one that white noise would have.
fn sandwich(white: &OutputError<'_>, coloured: &OutputError<'_>, minimum: &Minimum) -> (DMatrix<f64>, f64) {
    let size = minimum.x.len();
    let mut middle = DMatrix::zeros(size, size);
    let columns = white.projected(&minimum.x);
    for ((columns, white), coloured) in columns.iter().zip(white.noise()).zip(coloured.noise()) {
        let weight = coloured.innovation_rms.powi(2) / white.innovation_rms.powi(4);
        let columns: Vec<Vec<f64>> = columns.iter().map(|column| coloured.colour_backwards(column)).collect();
        for row in 0..size {
            for column in 0..size {
                middle[(row, column)] += weight * dot(&columns[row], &columns[column]);
            }
        }
    }
    let Some(inverse) = minimum.at.curvature.clone().try_inverse() else {
        return (DMatrix::from_element(size, size, f64::INFINITY), 1.0);
    };
    let covariance = &inverse * middle * &inverse;
    let inflation = (0..size).map(|place| covariance[(place, place)] / inverse[(place, place)]).fold(1.0, f64::max);
    (covariance, inflation)
}

/// The best model without a pole: from the one with a pole, whose lag goes to the second-order part.
fn without_pole(problem: &OutputError<'_>, minimum: &Minimum) -> Minimum {
    if problem.layout.lag == Lag::None {
        return minimum.clone();
    }
    let layout = Layout { lag: Lag::None, ..problem.layout };
    let second = problem.with_layout(layout);
    let mut start: Vec<f64> = minimum.x.iter().enumerate().filter(|(place, _)| *place != 3).map(|(_, x)| *x).collect();
    let (omega, zeta) = (start[LN_OMEGA].exp(), start[LN_ZETA].exp());
    let own = 2.0 * zeta / omega;
    start[LN_OMEGA] -= (1.0 + minimum.x[3] / own).ln();
    minimise(&second, &start)
}

fn prior_note(prior: LagPrior, study: &Study) -> Option<String> {
    study.limit_s?;
    Some(match prior {
        LagPrior::Small => format!(
            "the records do not tell p; omega and zeta are stated for the most probable lag 1/p = {:.3} ms, and their standard \
             errors include what is unknown of it, given that it is small ({:.1} ms or less, unless the records say otherwise)",
            1e3 * study.lag_s,
            1e3 * SMALL_LAG_S
        ),
        LagPrior::Flat => format!(
            "the records do not tell p; omega and zeta are stated for the most likely lag 1/p = {:.3} ms, and their standard errors \
             include what is unknown of it",
            1e3 * study.lag_s
        ),
    })
}

/// The model that is reported.
struct Choice {
    layout: Layout,
    x: Vec<f64>,
    cost: f64,
    covariance: Option<DMatrix<f64>>,
    /// Upper limit of the lag; none where the pole is found or was not asked for.
    limit_s: Option<f64>,
    at_bound: Vec<bool>,
}

impl Choice {
    fn second(problem: &OutputError<'_>, minimum: &Minimum) -> Self {
        Self {
            layout: Layout { lag: Lag::None, ..problem.layout },
            x: minimum.x.clone(),
            cost: minimum.at.cost,
            covariance: minimum.at.curvature.clone().try_inverse(),
            limit_s: None,
            at_bound: minimum.at_bound.clone(),
        }
    }

    fn third(problem: &OutputError<'_>, minimum: &Minimum, study: Study) -> Self {
        let x = if study.limit_s.is_some() { pole::at_lag(problem, minimum, study.lag_s) } else { minimum.x.clone() };
        Self {
            layout: problem.layout,
            cost: problem.cost(&x),
            covariance: pole::covariance(problem, &x, study.spread_s),
            x,
            limit_s: study.limit_s,
            at_bound: minimum.at_bound.clone(),
        }
    }

    /// Estimates in the order k, p, omega, zeta, delay, each with its place in θ.
    fn estimates(&self, model: &Delayed) -> Vec<(Estimate, usize)> {
        let error = |place: usize| self.covariance.as_ref().map(|covariance| covariance[(place, place)].sqrt());
        // A logarithm's error is a relative one.
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
        let mut estimates = vec![logarithmic("k", "deg/deg", base.k(), LN_K)];
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

    fn correlations(&self, estimates: &[(Estimate, usize)]) -> Vec<Vec<f64>> {
        let Some(covariance) = &self.covariance else { return Vec::new() };
        // p falls when its lag grows.
        let sign = |estimate: &Estimate| if estimate.name == "p" { -1.0 } else { 1.0 };
        let row = |(one, a): &(Estimate, usize)| -> Vec<f64> {
            let with = |(other, b): &(Estimate, usize)| {
                let scale = (covariance[(*a, *a)] * covariance[(*b, *b)]).sqrt();
                sign(one) * sign(other) * covariance[(*a, *b)] / scale
            };
            estimates.iter().map(with).collect()
        };
        estimates.iter().map(row).collect()
    }

    /// Of ln k, ln ω, ln ζ and the lag, which is not there or fixed in some layouts.
    fn joint_covariance(&self) -> Option<[[f64; 4]; 4]> {
        let covariance = self.covariance.as_ref()?;
        let places = if self.layout.lag == Lag::Free { 4 } else { 3 };
        let at = |row: usize, column: usize| {
            if row < places && column < places { covariance[(row, column)] } else { 0.0 }
        };
        Some(std::array::from_fn(|row| std::array::from_fn(|column| at(row, column))))
    }

    fn finish(
        self,
        evidence: Vec<Evidence>,
        search: Search<'_>,
        records: &[Record],
        settings: &Settings,
    ) -> Result<Fit> {
        let Search { problem, minimum, found, misfit, mut notes, .. } = search;
        let problem = problem.with_layout(self.layout);
        let Some(delayed) = self.layout.model(&self.x) else {
            return Err(Error::new("fit", "parameters outside their range", "a model"));
        };
        let estimates = self.estimates(&delayed);
        let correlations = self.correlations(&estimates);
        let joint = self.joint_covariance();
        let remainders = problem.remainders(&self.x);
        let each: Vec<RecordFit> =
            records.iter().zip(&remainders).map(|(record, remainder)| RecordFit::new(record, remainder)).collect();
        let residual: Vec<f64> = remainders.into_iter().flat_map(|remainder| remainder.residual).collect();
        let estimates: Vec<Estimate> = estimates.into_iter().map(|(estimate, _)| estimate).collect();
        let pole = match (self.layout.lag, self.limit_s) {
            (_, Some(limit)) => Pole::Above(1.0 / limit),
            (Lag::Free, None) => Pole::Found,
            _ => Pole::Untold,
        };
        let mut not_identifiable = Vec::new();
        if let Pole::Above(bound) = pole {
            not_identifiable.push(format!("p: above {} 1/s (95 %), no more can be told", significant(bound)));
        }
        not_identifiable.extend(estimates.iter().filter_map(unknown));
        if misfit {
            notes.push("compare models by their residuals on records that were not fitted".to_owned());
        }
        let noise: Vec<Noise> = records
            .iter()
            .zip(problem.remainders(&self.x))
            .map(|(record, r)| Noise::of(&r.residual, ROUNDING_SHARE * rms(record.position())))
            .collect();
        let effective: f64 =
            records.iter().zip(&noise).map(|(record, noise)| count(record.len()) * noise.effective_share()).sum();
        let innovation: f64 =
            records.iter().zip(&noise).map(|(record, noise)| count(record.len()) * noise.innovation_rms.powi(2)).sum();
        let all: f64 = records.iter().map(|record| count(record.len())).sum();
        let model = self.model(&delayed, &estimates, pole, records, settings)?;
        let starts = start_results(&found, problem.layout, &minimum);
        Ok(Fit {
            model,
            method: Method::Likelihood,
            correlations,
            covariance: joint,
            pole,
            delay_s: delayed.delay_s,
            ending: minimum.ending.sentence().to_owned(),
            converged: minimum.ending.is_minimum(),
            at_bound: estimates
                .iter()
                .filter(|estimate| estimate.at_bound)
                .map(|estimate| estimate.name.to_owned())
                .collect(),
            not_identifiable,
            starts,
            unit: records[0].unit().name(),
            residual_rms: rms(&residual),
            innovation_rms: (innovation / all).sqrt(),
            noise_order: noise.iter().map(|noise| noise.coefficients.len()).max().unwrap_or(0),
            effective_samples: effective,
            records: each,
            evidence,
            notes,
            estimates,
        })
    }

    fn model(
        &self,
        delayed: &Delayed,
        estimates: &[Estimate],
        pole: Pole,
        records: &[Record],
        settings: &Settings,
    ) -> Result<Model> {
        let base = &delayed.base;
        let no_lag = self.layout.lag == Lag::None || 1.0 / base.p() < 1e-9;
        // A file has to hold some p. Without a pole it is not used; with one that is not known, it is that of the stated lag.
        let p = match (no_lag, pole) {
            (true, Pole::Above(bound)) => bound,
            (true, _) => Base::PARAMETERS[1].nominal,
            _ => base.p(),
        };
        let mut model = Model::new(
            Base::new(base.k(), p, base.omega(), base.zeta())?,
            if no_lag { Order::Second } else { Order::Third },
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

fn unknown(estimate: &Estimate) -> Option<String> {
    // An error of half the value leaves no digit of it.
    const SHARE: f64 = 0.5;
    match estimate.std_error {
        Some(error) if estimate.name == "delay" => {
            (error * NORMAL_95 > estimate.value).then(|| "delay: cannot be told from none".to_owned())
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

fn start_results(found: &[Found], layout: Layout, minimum: &Minimum) -> Vec<StartResult> {
    let _ = layout;
    found
        .iter()
        .map(|found| StartResult {
            start: found.start.base.values(),
            end: found.end.base.values(),
            cost: found.minimum.at.cost,
            iterations: found.minimum.iterations,
            ending: found.minimum.ending.sentence().to_owned(),
            converged: found.minimum.ending.is_minimum(),
            at_best: search::agree(&found.minimum.x, &minimum.x, 0.01),
        })
        .collect()
}
