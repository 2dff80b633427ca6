//! Information in the records on the first-order pole p, and the effect of its uncertainty on the other parameters.
//!
//! In 0.5-12 Hz the pole of the tables (p = 10 000 1/s) appears only as a lag 1/p of 0.1 ms, and it is masked by ω, which has a lag 2ζ/ω of
//! its own: each 0.1 ms omitted from the model changes ω by about one percent. The profile of the likelihood over the lag,
//!
//! ```text
//! D(τ) = 2 (minimum cost with 1/p = τ  -  global minimum of the cost)
//! ```
//!
//! contains the information in the records. Its 95 % limit D = 2.71 gives "p above ...". A value of p is stated only if the records
//! determine it to an eighth or better.
//!
//! If they do not, a lag still has to be chosen, and a lag of zero would misplace the interval of ω. Prior knowledge, stated in every
//! result and disabled on request, decides: the lag is small, equally likely below and above 0.15 ms (a half-Cauchy distribution, whose
//! long tail lets records override it); those of the tables are 0.1 ms, once 0.145 ms and once next to zero. Values are stated for the
//! median lag; the most probable one would often be zero, the bound of its range. Without the prior they are stated for the
//! maximum-likelihood lag. Standard errors include the remaining uncertainty of the lag.

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
    /// Small, unless the records show otherwise.
    #[default]
    Small,
    /// None: all lags from zero on are equally likely.
    Flat,
}

/// Median of the prior of the lag [s]: the maximum of the tables, for p = 6 898 1/s.
pub const SMALL_LAG_S: f64 = 1.5e-4;

/// A value of p is stated if the relative standard error of the lag is below this.
const FOUND_SHARE: f64 = 0.125;

/// One-sided 95 % limit of the profile: the square of 1.645.
const LIMIT: f64 = 2.706;

/// Information in the records on the lag.
pub struct LagEstimate {
    /// The lag for which the result is stated [s].
    pub lag_s: f64,
    /// Its uncertainty [s].
    pub spread_s: f64,
    /// Upper 95 % limit [s]; `None` if the pole is identified.
    pub limit_s: Option<f64>,
    /// Twice the natural logarithm of the odds for a pole against none.
    pub odds: f64,
}

impl LagPrior {
    /// Density at a lag ≥ 0 [1/s]; `None` for a flat prior.
    fn density(self, lag_s: f64) -> Option<f64> {
        let t = lag_s / SMALL_LAG_S;
        (self == Self::Small).then(|| std::f64::consts::FRAC_2_PI / (SMALL_LAG_S * (1.0 + t * t)))
    }
}

/// Nodes of the profile in standard errors of the lag, below and above it, spaced by one.
const BELOW: f64 = 4.0;
const ABOVE: f64 = 5.0;

/// If the standard error exceeds this multiple of a small lag, the prior decides, and nodes follow its scale.
const WIDE_ERROR: f64 = 5.0;

/// The first node above zero on the scale of the prior, in small lags; each further one doubles it.
const FIRST_NODE: f64 = 0.25;

/// Nodes closer than this, in small lags, are merged.
const NODE_SEPARATION: f64 = 1e-3;

/// Interpolation points of the profile between two nodes.
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
    // Trapezoidal rule: half the distance to the points on both sides.
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

/// The median lag: half of a point's own mass lies on either side of it, with linear interpolation.
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
    // From a fraction of a small lag, each twice the previous one.
    let last = (lag + ABOVE * sigma).min(GREATEST_LAG_S);
    let doubled = (0..).map(|power| FIRST_NODE * SMALL_LAG_S * 2.0_f64.powi(power)).take_while(|node| *node < last);
    let mut nodes: Vec<f64> = std::iter::once(0.0).chain(doubled).chain([last, lag]).collect();
    nodes.sort_by(f64::total_cmp);
    nodes.dedup_by(|a, b| (*a - *b).abs() < NODE_SEPARATION * SMALL_LAG_S);
    nodes
}

/// D at some lags, with parabolic interpolation.
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

    /// Lags and D, at the nodes and between them.
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

/// Change of the other parameters with one along the valley: -H_oo⁻¹ H_op.
pub fn slope(curvature: &DMatrix<f64>, place: usize) -> DVector<f64> {
    let others = curvature.clone().remove_row(place).remove_column(place);
    let cross = curvature.column(place).into_owned().remove_row(place);
    others.cholesky().map_or_else(|| DVector::zeros(cross.len()), |factor| -factor.solve(&cross))
}

/// Without one element; the others are changed.
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
