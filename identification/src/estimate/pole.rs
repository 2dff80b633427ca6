//! What records tell of the first-order pole p, and what its uncertainty adds to that of the other parameters.
//!
//! In 0.5-12 Hz the pole of the tables (p = 10 000 1/s) shows as a lag 1/p of 0.1 ms and nothing else, and ω, which has a
//! lag 2ζ/ω of its own, hides it: each 0.1 ms that is left out of the model moves ω by about one percent. The profile of the
//! likelihood over the lag,
//!
//! ```text
//! D(τ) = 2 (least cost with 1/p = τ  -  least cost of all)
//! ```
//!
//! holds what the records tell. Its 95 % limit D = 2.71 gives "p above ...". A number for p is stated only where the records
//! give it to an eighth or better.
//!
//! Where they do not, a lag has to be chosen all the same, and choosing none would put every standard error of ω in the
//! wrong place. Prior knowledge, stated in every result and dropped on request, decides: the lag is small, as likely below as
//! above 0.15 ms (half a Cauchy distribution, whose long tail lets records overrule it); the tables' own are 0.1 ms, once
//! 0.145 ms and once next to nothing. Values are those of the median lag, as likely too short as too long; the most probable one
//! would often be none at all, which is the edge of what is possible. Without the prior they are those of the most likely lag.
//! Standard errors include what remains unknown of it.

use nalgebra::{DMatrix, DVector};

use super::{
    covariance,
    layout::{GREATEST_LAG_S, Lag, Layout},
    output_error::OutputError,
};
use crate::least_squares::{Ending, Minimum, Problem, TIGHT_TOLERANCE, minimise};

/// Prior knowledge of the lag 1/p.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LagPrior {
    /// Small, unless the records say otherwise.
    #[default]
    Small,
    /// None: any lag from zero on is as likely.
    Flat,
}

/// A lag that smaller and greater ones are as likely as [s]: the greatest of the tables, of p = 6 898 1/s.
pub const SMALL_LAG_S: f64 = 1.5e-4;

/// A standard error of the lag below this share of it makes p a number.
const FOUND_SHARE: f64 = 0.125;

/// One-sided 95 % limit of the profile: the square of 1.645.
const LIMIT: f64 = 2.706;

/// What the records say of the lag.
pub struct LagEstimate {
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
        let t = lag_s / SMALL_LAG_S;
        (self == Self::Small).then(|| std::f64::consts::FRAC_2_PI / (SMALL_LAG_S * (1.0 + t * t)))
    }
}

/// Nodes of the profile in standard errors of the lag, below and above it, one apart.
const BELOW: f64 = 4.0;
const ABOVE: f64 = 5.0;

/// A standard error above this multiple of a small lag leaves the choice to the prior, and nodes follow its scale.
const WIDE_ERROR: f64 = 5.0;

/// Where nodes follow the prior, the first one above zero, in small lags; each further one doubles it.
const FIRST_NODE: f64 = 0.25;

/// Nodes that are closer, in small lags, are one.
const NODE_SEPARATION: f64 = 1e-3;

/// Points between two nodes at which the profile is interpolated.
const INTERPOLATION_POINTS: u32 = 40;

/// From the minimum with the lag free and the cost without a lag.
pub fn estimate_lag(
    problem: &OutputError<'_>,
    minimum: &Minimum,
    cost_without: f64,
    samples: f64,
    prior: LagPrior,
) -> LagEstimate {
    let place = 3;
    let lag = minimum.x[place];
    let covariance = covariance::inverse(&minimum.at.curvature);
    let sigma = covariance.map(|covariance| covariance[(place, place)].sqrt()).filter(|sigma| sigma.is_finite());
    let without = 2.0 * (cost_without - minimum.at.cost).max(0.0);
    if let Some(sigma) = sigma.filter(|sigma| *sigma < FOUND_SHARE * lag && without > FOUND_SHARE.powi(-2)) {
        return LagEstimate { lag_s: lag, spread_s: sigma, limit_s: None, odds: without - samples.ln() };
    }
    let profile = Profile::new(problem, minimum, nodes(lag, sigma.unwrap_or(f64::INFINITY)));
    let points = profile.points();
    // Trapezoids: half the distance to the points on both sides.
    let width = |index: usize| 0.5 * (points[(index + 1).min(points.len() - 1)].0 - points[index.saturating_sub(1)].0);
    let density = |(lag, deviance): (f64, f64)| (-0.5 * deviance).exp() * prior.density(lag).unwrap_or(1.0);
    let masses: Vec<f64> = (0..points.len()).map(|index| width(index) * density(points[index])).collect();
    let mass: f64 = masses.iter().sum();
    let stated = match prior {
        LagPrior::Small => median(&points, &masses).unwrap_or(lag),
        LagPrior::Flat => lag,
    };
    let second: f64 = points.iter().zip(&masses).map(|(point, mass)| mass * (point.0 - stated).powi(2)).sum();
    let least = (0..points.len()).min_by(|a, b| points[*a].1.total_cmp(&points[*b].1)).unwrap_or(0);
    let limit = points[least..].iter().find(|(_, deviance)| *deviance > LIMIT).or(points.last()).map_or(lag, |p| p.0);
    let odds = match prior {
        LagPrior::Small => 2.0 * mass.ln() + without,
        LagPrior::Flat => without - samples.ln(),
    };
    LagEstimate { lag_s: stated, spread_s: (second / mass).sqrt(), limit_s: Some(limit), odds }
}

/// The lag with half of the mass below it: half of a point's own mass lies on either side of it, straight lines between.
fn median(points: &[(f64, f64)], masses: &[f64]) -> Option<f64> {
    let half = 0.5 * masses.iter().sum::<f64>();
    let mut below = 0.0;
    let mut before: Option<(f64, f64)> = None;
    for ((lag, _), mass) in points.iter().zip(masses) {
        let here = below + 0.5 * mass;
        if here >= half {
            return Some(match before {
                Some((earlier, reached)) if here > reached => {
                    earlier + (lag - earlier) * (half - reached) / (here - reached)
                }
                _ => *lag,
            });
        }
        before = Some((*lag, here));
        below += mass;
    }
    None
}

/// Lags at which the profile is computed [s].
fn nodes(lag: f64, sigma: f64) -> Vec<f64> {
    if sigma < WIDE_ERROR * SMALL_LAG_S {
        let first = (lag - BELOW * sigma).max(0.0);
        let count = ((lag + ABOVE * sigma - first) / sigma).ceil();
        let width = (lag + ABOVE * sigma - first) / count;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // nine at most
        return (0..=count as u32).map(|index| first + width * f64::from(index)).collect();
    }
    // From a part of a small lag, each twice the one before.
    let last = (lag + ABOVE * sigma).min(GREATEST_LAG_S);
    let doubled = (0..).map(|power| FIRST_NODE * SMALL_LAG_S * 2.0_f64.powi(power)).take_while(|node| *node < last);
    let mut nodes: Vec<f64> = std::iter::once(0.0).chain(doubled).chain([last, lag]).collect();
    nodes.sort_by(f64::total_cmp);
    nodes.dedup_by(|a, b| (*a - *b).abs() < NODE_SEPARATION * SMALL_LAG_S);
    nodes
}

/// D at some lags, with parabolas between.
struct Profile {
    nodes: Vec<(f64, f64)>,
}

impl Profile {
    fn new(problem: &OutputError<'_>, minimum: &Minimum, lags: Vec<f64>) -> Self {
        let slope = slope(&minimum.at.curvature, 3);
        let cost = |lag: f64| {
            let fixed = problem.with_layout(Layout { lag: Lag::Fixed(lag), ..problem.layout });
            let start = without(&minimum.x, 3, |place, value| value + slope[place] * (lag - minimum.x[3]));
            minimise(&fixed, &start, TIGHT_TOLERANCE).at.cost
        };
        let nodes: Vec<(f64, f64)> = lags.into_iter().map(|lag| (lag, cost(lag))).collect();
        let least = nodes.iter().map(|node| node.1).fold(minimum.at.cost, f64::min);
        Self { nodes: nodes.into_iter().map(|(lag, cost)| (lag, 2.0 * (cost - least))).collect() }
    }

    /// Lags and D, the nodes and what lies between.
    fn points(&self) -> Vec<(f64, f64)> {
        let pairs = self.nodes.windows(2).enumerate();
        let between = pairs.flat_map(|(index, pair)| {
            let (from, to) = (pair[0].0, pair[1].0);
            (0..INTERPOLATION_POINTS).map(move |step| {
                let lag = from + (to - from) * f64::from(step) / f64::from(INTERPOLATION_POINTS);
                (lag, self.deviance(lag, index))
            })
        });
        between.chain(self.nodes.last().copied()).collect()
    }

    /// The parabola through three nodes around a lag (Lagrange).
    fn deviance(&self, lag: f64, pair: usize) -> f64 {
        let first = pair.min(self.nodes.len().saturating_sub(3));
        let three = &self.nodes[first..(first + 3).min(self.nodes.len())];
        let term = |(one, (at, deviance)): (usize, &(f64, f64))| {
            let others = three.iter().enumerate().filter(|(other, _)| *other != one);
            deviance * others.map(|(_, (other, _))| (lag - other) / (at - other)).product::<f64>()
        };
        three.iter().enumerate().map(term).sum::<f64>().max(0.0)
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

/// θ at a lag, from the minimum with the lag free, and how the search for it ended.
pub fn at_lag(problem: &OutputError<'_>, minimum: &Minimum, lag_s: f64) -> (Vec<f64>, Ending) {
    let slope = slope(&minimum.at.curvature, 3);
    let fixed = problem.with_layout(Layout { lag: Lag::Fixed(lag_s), ..problem.layout });
    let start = without(&minimum.x, 3, |place, value| value + slope[place] * (lag_s - minimum.x[3]));
    let Minimum { mut x, ending, .. } = minimise(&fixed, &start, TIGHT_TOLERANCE);
    x.insert(3, lag_s);
    (x, ending)
}

/// Covariance of θ at a lag that is known to `spread_s`: what the records leave open at this lag, and what the lag carries over.
pub fn covariance(problem: &OutputError<'_>, x: &[f64], spread_s: f64) -> Option<DMatrix<f64>> {
    let curvature = problem.expand(x).curvature;
    let conditional = covariance::inverse(&curvature.clone().remove_row(3).remove_column(3))?;
    let carried = slope(&curvature, 3).insert_row(3, 1.0);
    let alone = conditional.insert_row(3, 0.0).insert_column(3, 0.0);
    Some(alone + &carried * carried.transpose() * spread_s * spread_s)
}
