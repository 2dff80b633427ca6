//! Start values of the search for parameters, and their ends.

use super::{
    layout::{LN_K, LN_ZETA, NO_LAG_S},
    output_error::{OutputError, dot, greatest_omega},
    simulation::{LANES, Simulator, Start},
};
use crate::{
    frequency::DelayedModel,
    least_squares::{LOOSE_TOLERANCE, Minimum, minimise},
    signal::record::{Record, without_mean},
    sorting::sort_by_number,
};
use actuator_fmu::parameters::{Base, Order};

/// Frequencies ω of the grid of start values, each a fraction of the previous one, from the maximum that the sampling can resolve.
const GRID_OMEGAS: i32 = 16;
const GRID_RATIO: f64 = 0.68;

/// Damping ratios ζ of the grid.
const GRID_ZETA: [f64; 3] = [0.3, 0.7, 1.5];

/// Number of starts.
const STARTS: usize = 3;

/// Ends whose k, ω and ζ differ by less than this fraction are the same.
pub const SAME_MINIMUM_SHARE: f64 = 0.01;

/// The fastest start, as a fraction of the bound: a search that starts on a bound may stay there.
const BELOW_BOUND: f64 = 0.99;

/// Maximum |k| of a start, within the range of a [`Base`].
const GREATEST_GAIN: f64 = 900.0;

/// Fractions of a model's lag that are assigned to a delay for further starts.
const DELAY_SHARES: [f64; 2] = [0.4, 0.8];

/// For each model with k = 1: k, and the unexplained fraction of the position, by linear regression on its response.
fn regress_gains(records: &[(&Record, Simulator<'_>)], models: &[DelayedModel]) -> Vec<(f64, f64)> {
    let mut sums = vec![[0.0; 3]; models.len()];
    for (record, simulator) in records {
        let measured = without_mean(record.position());
        let all = dot(&measured, &measured);
        for ([cross, own, total], modelled) in sums.iter_mut().zip(simulator.positions(models, Start::zeros())) {
            let modelled = without_mean(&modelled);
            *cross += dot(&modelled, &measured);
            *own += dot(&modelled, &modelled);
            *total += all;
        }
    }
    sums.into_iter().map(|[cross, own, all]| (cross / own, 1.0 - cross * cross / (own * all))).collect()
}

/// Start values: the models of the grid that explain most, the best one first. Empty if the position is unrelated to the command.
pub fn starts(records: &[(&Record, Simulator<'_>)]) -> Vec<DelayedModel> {
    let fastest = greatest_omega(records);
    let infinite = 1.0 / NO_LAG_S;
    let model = |k: f64, omega: f64, zeta: f64| {
        let base = Base::new(k, infinite, omega, zeta).ok()?;
        Some(DelayedModel { base, order: Order::Second, delay_s: 0.0 })
    };
    let models: Vec<DelayedModel> = (0..GRID_OMEGAS)
        .map(|index| BELOW_BOUND * fastest * GRID_RATIO.powi(index))
        .flat_map(|omega| GRID_ZETA.iter().filter_map(move |zeta| model(1.0, omega, *zeta)))
        .collect();
    // A few at a time, since their positions are in memory together.
    let mut tried: Vec<(f64, DelayedModel)> = models
        .chunks(LANES)
        .flat_map(|models| models.iter().zip(regress_gains(records, models)))
        .filter(|(_, (k, unexplained))| *k != 0.0 && k.is_finite() && unexplained.is_finite())
        .filter_map(|(DelayedModel { base, .. }, (k, unexplained))| {
            let k = k.clamp(-GREATEST_GAIN, GREATEST_GAIN);
            Some((unexplained, model(k, base.omega(), base.zeta())?))
        })
        .collect();
    sort_by_number(&mut tried, |one| one.0);
    tried.into_iter().take(STARTS).map(|(_, model)| model).collect()
}

/// End of a start.
#[derive(Debug, Clone)]
pub struct LocalMinimum {
    /// The start.
    pub start: DelayedModel,
    /// The end.
    pub end: DelayedModel,
    /// As above as numbers, with its cost.
    pub minimum: Minimum,
}

/// Searches from each start; if the delay is free, also from the best end with a part of its lag assigned to the delay.
pub fn from_starts(problem: &OutputError<'_>, starts: &[DelayedModel]) -> Vec<LocalMinimum> {
    let layout = problem.layout;
    let search = |start: &DelayedModel| {
        let minimum = minimise(problem, &layout.vector(start), LOOSE_TOLERANCE);
        let end = layout.model(&minimum.x)?;
        Some(LocalMinimum { start: *start, end, minimum })
    };
    let mut found: Vec<LocalMinimum> = starts.iter().filter_map(search).collect();
    if layout.delay_place().is_some() {
        let delayed: Vec<DelayedModel> = starts.iter().take(1).flat_map(with_delays).collect();
        found.extend(delayed.iter().filter_map(search));
    }
    found
}

/// A second-order model lags by 2ζ/ω at low frequency; a delay may be a part of that, or nearly all.
fn with_delays(start: &DelayedModel) -> Vec<DelayedModel> {
    let base = &start.base;
    let lag = 2.0 * base.zeta() / base.omega();
    DELAY_SHARES
        .iter()
        .filter_map(|share| {
            let faster = Base::new(base.k(), base.p(), base.omega() / (1.0 - share), base.zeta()).ok()?;
            Some(DelayedModel { base: faster, delay_s: share * lag, ..*start })
        })
        .collect()
}

/// The one with the least cost.
pub fn best(found: &[LocalMinimum]) -> Option<&Minimum> {
    let finite = found.iter().map(|found| &found.minimum).filter(|minimum| minimum.at.cost.is_finite());
    finite.min_by(|a, b| a.at.cost.total_cmp(&b.at.cost))
}

/// Whether k, ω and ζ of two ends agree within [`SAME_MINIMUM_SHARE`].
pub fn agree(a: &[f64], b: &[f64]) -> bool {
    (LN_K..=LN_ZETA).all(|place| (a[place] - b[place]).abs() < SAME_MINIMUM_SHARE)
}
