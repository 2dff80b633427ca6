//! Where the search for parameters begins, and where each start led.

use super::{
    output_error::{LN_K, LN_ZETA, OutputError, dot, fastest},
    simulation::{Delayed, Drive, Start},
};
use crate::{
    least_squares::{Minimum, ROUGH, minimise},
    parameters::{Base, Order},
    signal::record::Record,
};

/// Frequencies ω of the coarse look, each a share of the one above, from the greatest that samples can tell.
const COARSE_OMEGAS: i32 = 16;
const COARSE_STEP: f64 = 0.68;

/// Damping ratios ζ of the coarse look.
const COARSE_ZETA: [f64; 3] = [0.3, 0.7, 1.5];

/// Starts that are searched from.
const STARTS: usize = 3;

/// k, and the share of the position that stays unexplained, by linear regression on the response of a second-order model.
fn coarse(records: &[(&Record, Drive<'_>)], omega: f64, zeta: f64) -> Option<(f64, f64)> {
    let base = Base::new(1.0, 1.0 / super::output_error::NO_LAG_S, omega, zeta).ok()?;
    let model = Delayed { base, order: Order::Second, delay_s: 0.0 };
    let (mut cross, mut own, mut all) = (0.0, 0.0, 0.0);
    for (record, drive) in records {
        let modelled = without_mean(&drive.position(&model, Start::zeros()));
        let measured = without_mean(record.position());
        cross += dot(&modelled, &measured);
        own += dot(&modelled, &modelled);
        all += dot(&measured, &measured);
    }
    let k = cross / own;
    (k != 0.0 && k.is_finite()).then(|| (k, 1.0 - cross * cross / (own * all)))
}

#[allow(clippy::cast_precision_loss)] // counts of samples
fn without_mean(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|value| value - mean).collect()
}

/// The models that explain most, from a coarse look; the best one first. Empty when the position has nothing to do with the
/// command.
pub fn starts(records: &[(&Record, Drive<'_>)]) -> Vec<Delayed> {
    let fastest = fastest(records);
    let mut tried: Vec<(f64, Delayed)> = (0..COARSE_OMEGAS)
        .map(|index| 0.99 * fastest * COARSE_STEP.powi(index))
        .flat_map(|omega| COARSE_ZETA.iter().map(move |zeta| (omega, *zeta)))
        .filter_map(|(omega, zeta)| {
            let (k, unexplained) = coarse(records, omega, zeta)?;
            let base = Base::new(k.clamp(-900.0, 900.0), 1.0 / super::output_error::NO_LAG_S, omega, zeta).ok()?;
            Some((unexplained, Delayed { base, order: Order::Second, delay_s: 0.0 }))
        })
        .collect();
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    tried.into_iter().take(STARTS).map(|(_, model)| model).collect()
}

/// Where a start led.
#[derive(Debug, Clone)]
pub struct Found {
    /// The start.
    pub start: Delayed,
    /// The end.
    pub end: Delayed,
    /// The same as numbers, with its cost.
    pub minimum: Minimum,
}

/// Searches from each start; where the delay is free, also from the best end with a part of its lag given to the delay.
pub fn from_starts(problem: &OutputError<'_>, starts: &[Delayed]) -> Vec<Found> {
    let layout = problem.layout;
    let search = |start: &Delayed| {
        let minimum = minimise(problem, &layout.place(start), ROUGH);
        let end = layout.model(&minimum.x)?;
        Some(Found { start: *start, end, minimum })
    };
    let mut found: Vec<Found> = starts.iter().filter_map(search).collect();
    if layout.delay_place().is_some() {
        let delayed: Vec<Delayed> = starts.iter().take(1).flat_map(with_delays).collect();
        found.extend(delayed.iter().filter_map(search));
    }
    found
}

/// A second-order model lags by 2ζ/ω at low frequency; a delay may be a part of that, or nearly all.
fn with_delays(start: &Delayed) -> Vec<Delayed> {
    let base = &start.base;
    let lag = 2.0 * base.zeta() / base.omega();
    [0.4, 0.8]
        .iter()
        .filter_map(|share| {
            let faster = Base::new(base.k(), base.p(), base.omega() / (1.0 - share), base.zeta()).ok()?;
            Some(Delayed { base: faster, delay_s: share * lag, ..*start })
        })
        .collect()
}

/// The one with the least cost.
pub fn best(found: &[Found]) -> Option<&Minimum> {
    let finite = found.iter().map(|found| &found.minimum).filter(|minimum| minimum.at.cost.is_finite());
    finite.min_by(|a, b| a.at.cost.total_cmp(&b.at.cost))
}

/// Whether k, ω and ζ of two ends agree within a share.
pub fn agree(a: &[f64], b: &[f64], share: f64) -> bool {
    (LN_K..=LN_ZETA).all(|place| (a[place] - b[place]).abs() < share)
}
