//! What records can say of the first-order pole p, and what not knowing it costs the rest.
//!
//! In 0.5-12 Hz the pole of the tables (p = 10 000 1/s) shows as a lag 1/p of 0.1 ms and nothing else, and ω, which has a
//! lag 2ζ/ω of its own, hides it: each 0.1 ms that is left out of the model moves ω by about one percent. The profile of the
//! likelihood over the lag,
//!
//! ```text
//! D(τ) = 2 (least cost with 1/p = τ  -  least cost of all)
//! ```
//!
//! says what the records know. Its 95 % limit D = 2.71 gives "p above ...". A number for p is stated only where the records
//! give it to an eighth or better.
//!
//! Where they do not, a lag has to be chosen all the same, and choosing none would put every standard error of ω in the
//! wrong place. Prior knowledge, stated in every result and dropped on request, decides: the lag is small, of the order of
//! 0.3 ms or less (Student's t with 3 degrees of freedom, so that records overrule it), where the tables' own are 0.1 ms, 0.14
//! ms and next to nothing. Values are those of the most probable lag; standard errors include what remains unknown of it.

use nalgebra::{DMatrix, DVector};

use super::output_error::{Lag, Layout, OutputError};
use crate::least_squares::{Minimum, Problem, minimise};

/// Prior knowledge of the lag 1/p.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LagPrior {
    /// Small, if the records say nothing else.
    #[default]
    Small,
    /// None: any lag from zero on is as likely.
    Flat,
}

/// Scale of a small lag [s]: p of 3 300 1/s.
pub const SMALL_LAG_S: f64 = 3e-4;

/// A standard error of the lag below this share of it makes p a number.
const FOUND_SHARE: f64 = 0.125;

/// One-sided 95 % limit of the profile: the square of 1.645.
const LIMIT: f64 = 2.706;

/// What the records say of the lag.
pub struct Study {
    /// The lag that the result is stated for [s].
    pub lag_s: f64,
    /// What is unknown of it [s].
    pub spread_s: f64,
    /// Upper 95 % limit [s]; none where the pole is found.
    pub limit_s: Option<f64>,
    /// Twice the natural logarithm of the odds for a pole against none.
    pub odds: f64,
}

impl LagPrior {
    /// Density at a lag ≥ 0 [1/s]; none for a flat prior.
    fn density(self, lag_s: f64) -> Option<f64> {
        // Γ(2) / (√(3π) Γ(3/2)), twice that for one side.
        const NORM: f64 = 2.0 * 0.367_552_596_947_861_3;
        let t = lag_s / SMALL_LAG_S;
        (self == Self::Small).then(|| NORM / SMALL_LAG_S * (1.0 + t * t / 3.0).powi(-2))
    }
}

/// Nodes of the profile, one standard error apart.
const BELOW: f64 = 4.0;
const ABOVE: f64 = 5.0;

/// Points between the nodes at which the profile is interpolated.
const FINE: usize = 60;

/// From the minimum with the lag free and the cost without a lag.
#[allow(clippy::cast_precision_loss)] // counts of samples and nodes
pub fn study(problem: &OutputError<'_>, minimum: &Minimum, cost_without: f64, samples: f64, prior: LagPrior) -> Study {
    let place = 3;
    let lag = minimum.x[place];
    let covariance = minimum.at.curvature.clone().try_inverse();
    let sigma = covariance.map_or(f64::NAN, |covariance| covariance[(place, place)].sqrt());
    let without = 2.0 * (cost_without - minimum.at.cost).max(0.0);
    if sigma < FOUND_SHARE * lag && without > FOUND_SHARE.powi(-2) {
        return Study { lag_s: lag, spread_s: sigma, limit_s: None, odds: without - samples.ln() };
    }
    // A curvature that says nothing of the lag: nodes over what the prior allows.
    let step = if sigma.is_finite() && sigma < 10.0 * SMALL_LAG_S { sigma } else { SMALL_LAG_S };
    let first = (lag - BELOW * step).max(0.0);
    let count = ((lag + ABOVE * step - first) / step).ceil().max(3.0);
    let width = (lag + ABOVE * step - first) / count;
    let nodes = Nodes::new(problem, minimum, first, width, count);
    let fine = |index: usize| first + width * index as f64 / FINE as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a dozen nodes
    let points = count as usize * FINE;
    let weights: Vec<f64> = (0..=points)
        .map(|index| (-0.5 * nodes.deviance(fine(index))).exp() * prior.density(fine(index)).unwrap_or(1.0))
        .collect();
    let best = (0..=points).max_by(|a, b| weights[*a].total_cmp(&weights[*b])).unwrap_or(0);
    let sum: f64 = weights.iter().sum();
    let second: f64 =
        weights.iter().enumerate().map(|(index, weight)| weight * (fine(index) - fine(best)).powi(2)).sum();
    let least = (0..=points).min_by(|a, b| nodes.deviance(fine(*a)).total_cmp(&nodes.deviance(fine(*b)))).unwrap_or(0);
    let limit = (least..=points).find(|index| nodes.deviance(fine(*index)) > LIMIT).unwrap_or(points);
    let odds = match prior {
        LagPrior::Small => 2.0 * (sum * width / FINE as f64).ln() + without,
        LagPrior::Flat => without - samples.ln(),
    };
    Study { lag_s: fine(best), spread_s: (second / sum).sqrt(), limit_s: Some(fine(limit)), odds }
}

/// The profile at equal distances, with parabolas between.
struct Nodes {
    first: f64,
    width: f64,
    deviances: Vec<f64>,
}

impl Nodes {
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a dozen nodes
    fn new(problem: &OutputError<'_>, minimum: &Minimum, first: f64, width: f64, count: f64) -> Self {
        let slope = slope(&minimum.at.curvature, 3);
        let costs: Vec<f64> = (0..=count as usize)
            .map(|index| {
                let lag = first + width * index as f64;
                let fixed = problem.with_layout(Layout { lag: Lag::Fixed(lag), ..problem.layout });
                let start = without(&minimum.x, 3, |place, value| value + slope[place] * (lag - minimum.x[3]));
                minimise(&fixed, &start).at.cost
            })
            .collect();
        let least = costs.iter().copied().fold(minimum.at.cost, f64::min);
        Self { first, width, deviances: costs.iter().map(|cost| 2.0 * (cost - least)).collect() }
    }

    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a dozen nodes
    fn deviance(&self, lag: f64) -> f64 {
        let place = (lag - self.first) / self.width;
        let middle = (place.round() as usize).clamp(1, self.deviances.len() - 2);
        let t = place - middle as f64;
        let [left, here, right] = [self.deviances[middle - 1], self.deviances[middle], self.deviances[middle + 1]];
        (here + 0.5 * t * (right - left) + 0.5 * t * t * (right - 2.0 * here + left)).max(0.0)
    }
}

/// How the other parameters move with one along the bottom of the valley: -H_oo⁻¹ H_op.
pub fn slope(curvature: &DMatrix<f64>, place: usize) -> DVector<f64> {
    let others = curvature.clone().remove_row(place).remove_column(place);
    let cross = curvature.column(place).into_owned().remove_row(place);
    others.cholesky().map_or_else(|| DVector::zeros(cross.len()), |factor| -factor.solve(&cross))
}

/// Without one element, the others changed.
fn without(x: &[f64], place: usize, change: impl Fn(usize, f64) -> f64) -> Vec<f64> {
    let others = x.iter().enumerate().filter(|(index, _)| *index != place).map(|(_, value)| *value);
    others.enumerate().map(|(index, value)| change(index, value)).collect()
}

/// θ at a lag, from the minimum with the lag free.
pub fn at_lag(problem: &OutputError<'_>, minimum: &Minimum, lag_s: f64) -> Vec<f64> {
    let slope = slope(&minimum.at.curvature, 3);
    let fixed = problem.with_layout(Layout { lag: Lag::Fixed(lag_s), ..problem.layout });
    let start = without(&minimum.x, 3, |place, value| value + slope[place] * (lag_s - minimum.x[3]));
    let mut x = minimise(&fixed, &start).x;
    x.insert(3, lag_s);
    x
}

/// Covariance of θ at a lag that is known to `spread_s`: what the records leave open at this lag, and what the lag carries over.
pub fn covariance(problem: &OutputError<'_>, x: &[f64], spread_s: f64) -> Option<DMatrix<f64>> {
    let curvature = problem.expand(x).curvature;
    let conditional = curvature.clone().remove_row(3).remove_column(3).try_inverse()?;
    let carried = slope(&curvature, 3).insert_row(3, 1.0);
    let alone = conditional.insert_row(3, 0.0).insert_column(3, 0.0);
    Some(alone + &carried * carried.transpose() * spread_s * spread_s)
}
