//! Maximum likelihood on the records themselves.
//!
//! 1. A grid over ω and ζ gives the start values ([`super::search`]); each is searched with white noise.
//! 2. Size and colour of the noise are estimated from the residual ([`super::noise`]), and the search is repeated, whitened.
//! 3. With a correct model both ends agree within their standard errors. If they do not, the residual is not noise but model
//!    error; then the unwhitened residual decides (a user can check its minimum rms), and standard errors allow for its
//!    colour.
//! 4. The pole is assessed ([`super::pole`]), the order selected, and the result stated ([`super::outcome`]).

use nalgebra::DMatrix;

use super::{
    layout::{LN_K, LN_OMEGA, LN_ZETA, Lag, Layout},
    noise::{Noise, ROUNDING_SHARE},
    outcome::{Outcome, StatedModel, significant},
    output_error::{OutputError, dot},
    pole::{self, LagEstimate, LagPrior, SMALL_LAG_S},
    result::{Evidence, Fit},
    search::{self, LocalMinimum},
    settings::{DelayChoice, OrderChoice, Settings},
    simulation::Simulator,
};
use crate::{
    frequency::DelayedModel,
    least_squares::{Minimum, Problem, TIGHT_TOLERANCE, minimise},
    progress::{Report, Stage, Work},
    signal::record::{Record, rms},
    sorting::sort_by_number,
};
use actuator_fmu::{
    error::{Error, Result},
    parameters::{Base, Order},
};

/// Evidence (twice the logarithm of the odds) that counts as strong.
const STRONG: f64 = 10.0;

/// Ends of two searches that differ by more than this many standard errors are not estimates of the same parameters.
const AGREEMENT: f64 = 3.0;

/// Number of iterations between noise and parameters.
const ROUNDS: usize = 2;

/// Maximum number of iterations between spikes and parameters: spikes masked by a wrong model appear in the residual of a better one.
const SPIKE_ROUNDS: usize = 4;

/// Maximum number of times a stopped search is resumed.
const CONTINUATIONS: usize = 3;

/// A residual below this multiple of rounding errors is not tested for dependence.
const FLOORS: f64 = 100.0;

/// The stages of a search: start values and their ends, the noise, the order. The number of simulations of all samples in each, as counted
/// on records of second and third order.
const STARTS: usize = 0;
const NOISE: usize = 1;
const ORDER: usize = 2;
const EXPECTED_PASSES: [f64; 3] = [250.0, 200.0, 70.0];
const EXPECTED_PASSES_WITH_DELAY: [f64; 3] = [600.0, 400.0, 1000.0];

/// Fits records; `progress` receives the completed fraction of the search.
pub fn fit(records: &[Record], settings: &Settings, report: Option<Report<'_>>) -> Result<Fit> {
    let samples: usize = records.iter().map(Record::len).sum();
    let passes = if settings.delay == DelayChoice::Free { EXPECTED_PASSES_WITH_DELAY } else { EXPECTED_PASSES };
    #[allow(clippy::cast_precision_loss)] // a count
    let stages = passes.map(|passes| Stage { samples: passes * samples as f64, chance: 1.0 });
    let work = Work::new(stages.to_vec(), report);
    let fit = searched(records, settings, &work);
    work.end();
    fit
}

fn searched(records: &[Record], settings: &Settings, work: &Work<'_>) -> Result<Fit> {
    let simulators: Vec<(&Record, Simulator)> =
        records.iter().map(|record| (record, Simulator::new(record).part_of(work))).collect();
    work.begin(STARTS);
    let start_values = search::starts(&simulators);
    let Some(first) = start_values.first() else {
        return Err(Error::new("position", "no motion that follows the command", "a response to the command")
            .remedy("check the columns, and that command and position are from one actuator")
            .at(records[0].source(), None));
    };
    let declared_delay_s = match settings.delay {
        DelayChoice::Declared(delay) => Some(delay),
        DelayChoice::Free => None,
    };
    let mut starts = start_values.clone();
    if let Some(given) = &settings.starts {
        starts.clear();
        for values in given {
            let base = Base::from_values(*values)?;
            starts.push(DelayedModel { base, order: Order::Third, delay_s: declared_delay_s.unwrap_or(0.0) });
        }
    }
    let lag = if settings.order == OrderChoice::Second { Lag::None } else { Lag::Free };
    let layout = Layout { lag, declared_delay_s, sign: first.base.k().signum() };
    let search = Search::run(&simulators, layout, &starts, work)?;
    work.begin(ORDER);
    search.choose(records, settings)
}

/// The maximum-likelihood parameters for the present estimate of the noise.
struct Likeliest<'a> {
    problem: OutputError<'a>,
    minimum: Minimum,
    /// Whether the residual is consistent with noise.
    noise_alone: bool,
}

impl<'a> Likeliest<'a> {
    /// Continues with different noise.
    fn search(&mut self, problem: OutputError<'a>) {
        self.minimum = minimise(&problem, &self.minimum.x, TIGHT_TOLERANCE);
        self.problem = problem;
    }
}

/// A finished search: the requested model with most freedom, and the same without a pole.
struct Search<'a> {
    problem: OutputError<'a>,
    minimum: Minimum,
    without_pole: Minimum,
    found: Vec<LocalMinimum>,
    notes: Vec<String>,
}

impl<'a> Search<'a> {
    fn run(
        simulators: &'a [(&'a Record, Simulator<'a>)],
        layout: Layout,
        starts: &[DelayedModel],
        work: &Work<'_>,
    ) -> Result<Self> {
        let sizes: Vec<f64> =
            simulators.iter().map(|(record, _)| rms(record.position()).max(f64::MIN_POSITIVE)).collect();
        let mut problem = OutputError::new(layout, simulators, sizes.iter().map(|size| Noise::white(*size)).collect());
        let found = search::from_starts(&problem, starts);
        let Some(best) = search::best(&found) else {
            return Err(Error::new("search", "no start with a finite cost", "one"));
        };
        work.begin(NOISE);
        let remains = |problem: &OutputError, x: &[f64], noise: &dyn Fn(&[f64], f64) -> Noise| -> Vec<Noise> {
            let each = problem.residuals(x).into_iter().zip(&sizes);
            each.map(|(record_residual, size)| noise(&record_residual.residual, ROUNDING_SHARE * size)).collect()
        };

        // White noise with the variance of each record, without spikes.
        let white = |problem: &OutputError, x: &[f64]| {
            remains(problem, x, &|residual, floor| Noise::white(rms(residual).max(floor)))
        };
        problem = problem.with_noise(white(&problem, &best.x), &best.x);
        let mut minimum = minimise(&problem, &best.x, TIGHT_TOLERANCE);
        for _ in 0..SPIKE_ROUNDS {
            let spikes = problem.find_spikes(&minimum.x);
            if spikes == problem.spikes() {
                break;
            }
            problem = problem.with_spikes(spikes);
            problem = problem.with_noise(white(&problem, &minimum.x), &minimum.x);
            minimum = minimise(&problem, &minimum.x, TIGHT_TOLERANCE);
        }
        let mut notes: Vec<String> = spike_note(problem.spikes(), simulators).into_iter().collect();

        // Coloured noise, with rate-dependent size.
        let mut likeliest = Likeliest { problem, minimum, noise_alone: true };
        let coloured = likeliest
            .problem
            .with_noise(remains(&likeliest.problem, &likeliest.minimum.x, &Noise::of), &likeliest.minimum.x);
        let (covariance, inflation) = sandwich(&likeliest.problem, &coloured, &likeliest.minimum);
        let plain = (likeliest.problem.with_layout(layout), likeliest.minimum.clone());
        let agree = |minimum: &Minimum| {
            let apart = |place: usize| (minimum.x[place] - plain.1.x[place]).abs() / covariance[(place, place)].sqrt();
            !(LN_K..=LN_ZETA).any(|place| apart(place) > AGREEMENT)
        };
        if coloured.noise().iter().any(|noise| !noise.coefficients.is_empty()) {
            likeliest.search(coloured);
            for _ in 1..ROUNDS {
                let noise = remains(&likeliest.problem, &likeliest.minimum.x, &Noise::of);
                likeliest.search(likeliest.problem.with_noise(noise, &likeliest.minimum.x));
            }
            likeliest.noise_alone = agree(&likeliest.minimum);
        }
        let residuals = likeliest.problem.residuals(&likeliest.minimum.x);
        let mut floors = residuals.iter().zip(&sizes);
        if floors.all(|(left, size)| rms(&left.residual) > FLOORS * ROUNDING_SHARE * size) {
            if likeliest.noise_alone {
                let noise_sizes = likeliest.problem.find_noise_sizes(&likeliest.minimum.x);
                notes.extend(rate_note(&noise_sizes));
                if noise_sizes.iter().any(Option::is_some) {
                    likeliest.search(likeliest.problem.with_noise_sizes(noise_sizes));
                    likeliest.noise_alone = agree(&likeliest.minimum);
                }
            }
            likeliest.noise_alone &= !likeliest.problem.depends_on_motion(&likeliest.minimum.x);
        }
        let Likeliest { mut problem, mut minimum, noise_alone } = likeliest;
        if !noise_alone {
            notes.retain(|note| !note.starts_with(RATE_NOTE));
            notes.push(MISFIT.to_owned());
            (problem, minimum) = plain;
            let inflated = |noise: &Noise| Noise::white(noise.innovation_rms * inflation.sqrt());
            problem = problem.with_noise(problem.noise().iter().map(inflated).collect(), &minimum.x);
            minimum = minimise(&problem, &minimum.x, TIGHT_TOLERANCE);
        }
        let without_pole = without_pole(&problem, &minimum);
        if layout.lag == Lag::Free && without_pole.at.cost < minimum.at.cost {
            // A lag of zero is a model without a pole: if that is better, the search with a lag ended in another minimum.
            let mut start = without_pole.x.clone();
            start.insert(3, 0.0);
            let nested = minimise(&problem, &start, TIGHT_TOLERANCE);
            if nested.at.cost < minimum.at.cost {
                minimum = nested;
            }
        }
        for _ in 0..CONTINUATIONS {
            if minimum.ending.is_minimum() {
                break;
            }
            minimum = minimise(&problem, &minimum.x, TIGHT_TOLERANCE);
        }
        Ok(Self { problem, minimum, without_pole, found, notes })
    }

    /// The order, and the note on the pole.
    fn choose(mut self, records: &[Record], settings: &Settings) -> Result<Fit> {
        #[allow(clippy::cast_precision_loss)] // counts of samples
        let samples: f64 = records.iter().map(|record| record.len() as f64).sum();
        let mut evidence = Vec::new();
        let mut stated = StatedModel::second(&self.problem, &self.without_pole);
        if self.problem.layout.lag == Lag::Free {
            let lag = pole::estimate_lag(
                &self.problem,
                &self.minimum,
                self.without_pole.at.cost,
                samples,
                settings.lag_prior,
            );
            evidence = orders(lag.odds, self.without_pole.x.len());
            // Eq. (6) is eq. (1) without a lag: unless the evidence is against a pole, it is kept, with its uncertainty.
            let third = StatedModel::third(&self.problem, &self.minimum, &lag);
            let [second_rms, third_rms] = [&stated, &third].map(|stated| stated.residual_rms(&self.problem));
            if settings.order == OrderChoice::Third || lag.odds > -STRONG {
                self.notes.extend(prior_note(settings.lag_prior, &lag));
                if settings.order == OrderChoice::Auto && larger(third_rms, second_rms) {
                    self.notes.push(format!(
                        "third order is stated although second order has the smaller residual, {} rather than {} rms: its lag 1/p is not \
                         identified and follows from the prior, and the evidence against a pole, {:.1}, is below {STRONG}",
                        significant(second_rms), significant(third_rms), (-lag.odds).max(0.0)
                    ));
                }
                stated = third;
            } else {
                if larger(second_rms, third_rms) {
                    self.notes.push(format!(
                        "second order is stated although third order has the smaller residual, {} rather than {} rms: the evidence against a \
                         pole, {:.1}, is above {STRONG}, since its lag 1/p would be far greater than the prior expects or gains less than \
                         one more parameter costs",
                        significant(third_rms), significant(second_rms), -lag.odds
                    ));
                }
                stated.limit_s = lag.limit_s;
            }
        } else {
            self.notes.push(SECOND_ORDER.to_owned());
        }
        self.notes.extend(self.delay_note(&stated, samples));
        let outcome = Outcome { stated, problem: self.problem, found: self.found, evidence, notes: self.notes };
        outcome.into_fit(records, settings)
    }

    /// A delay that was not declared but is evident in the records.
    fn delay_note(&self, stated: &StatedModel, samples: f64) -> Option<String> {
        self.problem.layout.declared_delay_s?;
        // A fraction of the lag of the model without it, as the start value of the delay.
        const SHARE: f64 = 0.3;
        let layout = Layout { lag: Lag::None, declared_delay_s: None, ..self.problem.layout };
        let model = stated.layout.model(&stated.x)?;
        // Both models without the start of each record, which may depend on commands from before it.
        let problem =
            self.problem.with_layout(layout).with_noise(self.problem.noise().to_vec(), &layout.vector(&model));
        let without = problem.with_layout(stated.layout).cost(&stated.x);
        let own = 2.0 * model.base.zeta() / model.base.omega();
        let lag = if model.order == Order::Third { own + 1.0 / model.base.p() } else { own };
        let omega = model.base.omega() / (1.0 - SHARE);
        let base = Base::new(model.base.k(), model.base.p(), omega, model.base.zeta()).ok()?;
        let start = DelayedModel { base, order: Order::Second, delay_s: model.delay_s + SHARE * lag };
        let with = minimise(&problem, &layout.vector(&start), TIGHT_TOLERANCE);
        // With the noise variance free: N ln(cost / cost), with N the effective number of independent samples.
        let gain = 2.0 * without * (without / with.at.cost.max(f64::MIN_POSITIVE)).ln() - samples.ln();
        let delay_ms = 1e3 * with.x[with.x.len() - 1];
        (gain > STRONG).then(|| {
            format!(
                "second order with a delay of {delay_ms:.2} ms explains the records better (twice the logarithm of the odds \
                 {gain:.0}): declare it, or estimate it with --delay free"
            )
        })
    }
}

const MISFIT: &str = "the residual is not noise alone: it depends on the command, so the model lacks something; standard errors allow for \
the colour of the residual, not for what the model lacks; compare models by their residuals on records that were not fitted";

const RATE_NOTE: &str = "the size of the noise depends on the rate";

fn rate_note(noise_sizes: &[Option<Vec<f64>>]) -> Option<String> {
    let all = || noise_sizes.iter().flatten().flatten();
    let [least, greatest] = [all().copied().fold(f64::INFINITY, f64::min), all().copied().fold(0.0, f64::max)];
    (greatest > 0.0).then(|| {
        format!(
            "{RATE_NOTE}, from {} to {} of its rms: samples are weighted by 1/variance at their rate",
            significant(least),
            significant(greatest)
        )
    })
}

fn spike_note(left_out: &[Vec<usize>], simulators: &[(&Record, Simulator<'_>)]) -> Option<String> {
    let spikes = left_out
        .iter()
        .zip(simulators)
        .map(|(samples, (record, _))| samples.iter().filter(|sample| record.is_measured(**sample)).count());
    let count: usize = spikes.sum();
    (count > 0).then(|| {
        format!("{count} samples are spikes, beyond six standard deviations of the residual around them, and left out")
    })
}

/// Whether one residual is larger than another by more than rounding.
fn larger(one: f64, other: f64) -> bool {
    const ROUNDING: f64 = 1e-9;
    one > other * (1.0 + ROUNDING)
}

const SECOND_ORDER: &str = "omega and zeta are those of eq. (6), which has no lag 1/p: for an actuator with a pole, omega of eq. (1) is \
higher, by about one percent for 0.1 ms of lag 1/p";

/// Covariance of a search with white noise when the noise is coloured, A⁻¹ J'ΩJ A⁻¹, and its maximum relative increase over that for white
/// noise.
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

/// The best model without a pole, from the one with a pole by moving its lag to the second-order part.
fn without_pole(problem: &OutputError<'_>, minimum: &Minimum) -> Minimum {
    if problem.layout.lag == Lag::None {
        return minimum.clone();
    }
    let second = problem.with_layout(Layout { lag: Lag::None, ..problem.layout });
    let mut start: Vec<f64> = minimum.x.iter().enumerate().filter(|(place, _)| *place != 3).map(|(_, x)| *x).collect();
    let own = 2.0 * start[LN_ZETA].exp() / start[LN_OMEGA].exp();
    start[LN_OMEGA] -= (1.0 + minimum.x[3] / own).ln();
    minimise(&second, &start, TIGHT_TOLERANCE)
}

/// The better order first.
fn orders(odds: f64, parameters: usize) -> Vec<Evidence> {
    let row = |model: &str, parameters, delta_bic| Evidence { model: model.into(), parameters, delta_bic };
    let mut rows =
        vec![row("third order", parameters + 1, (-odds).max(0.0)), row("second order", parameters, odds.max(0.0))];
    sort_by_number(&mut rows, |row| row.delta_bic);
    rows
}

fn prior_note(prior: LagPrior, lag: &LagEstimate) -> Option<String> {
    lag.limit_s?;
    let (which, given) = match prior {
        LagPrior::Small => {
            ("median", format!(", under a prior of small lags, of the order of {} ms", 1e3 * SMALL_LAG_S))
        }
        LagPrior::Flat => ("most likely", String::new()),
    };
    Some(format!(
        "the records do not identify p; omega and zeta are stated for the {which} lag 1/p = {:.3} ms, and their standard errors include its \
         uncertainty{given}",
        1e3 * lag.lag_s
    ))
}
