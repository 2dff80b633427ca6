//! Adequacy: whether the residual is independent of the motion, as noise is.
//!
//! The whitened residual is regressed on functions of the simulated motion (position, rate, direction, command, time, load), through which any
//! missing effect must act. A significant explained part is a misfit, whatever its cause. With N samples, m regressors and the sums of squares before
//! and after the regression:
//!
//! ```text
//! F = ((before - after) / m) / (after / (N - m)),    share = 1 - (after / (N - m)) / (before / N)
//! ```
//!
//! It is tested on fit and on check records. The segments between the gaps of one record form one test, with separate factors for each: the shorter a
//! segment, the less perfect its whitening, and the worst of many exceeds a limit by chance.

use super::{
    fitted::Fitted,
    output_error::white,
    regressors::{ExplainingRegressor, Regressor, Scales, regressors},
    trace::Trace,
};
use crate::{
    inspect::whole_record,
    linear_least_squares::{dot, solve, subtract},
    parallel,
    signal::record::rms,
};

/// Share of the variance of the innovations that the motion explains, on one set of records.
#[derive(Debug, Clone, Copy, Default)]
pub struct Misfit {
    /// Explained share, adjusted for the number of regressors.
    pub share: f64,
    /// F of the regression.
    pub f: f64,
    /// Critical value of F.
    pub critical: f64,
}

/// Share of the innovations' variance below which a significant misfit is immaterial.
const MATERIAL_SHARE: f64 = 0.03;

/// A residual whose rms is below this share of that of the position is no misfit: without noise it is rounding and the tolerance of the search.
const NEGLIGIBLE_SHARE: f64 = 1e-4;

/// A record with fewer samples per regressor than this, and less than a quarter of the longest one, is not tested: in a segment between two gaps the
/// start of its motion is hardly distinguishable from noise.
const FEWEST_PER_REGRESSOR: usize = 15;
const SHORT_BESIDE: usize = 4;

/// Standard deviations of F above its mean at the critical value: a false alarm rate of about 1e-5, since whitening is not perfect.
const CRITICAL_DEVIATIONS: f64 = 5.0;

impl Misfit {
    /// Insignificant or immaterial.
    #[must_use]
    pub fn is_noise(&self) -> bool {
        self.share < MATERIAL_SHARE || !self.is_significant()
    }

    /// Significant, though it may be small.
    #[must_use]
    pub fn is_significant(&self) -> bool {
        self.f > self.critical
    }

    /// The larger of two misfits.
    #[must_use]
    pub fn greater(self, other: Self) -> Self {
        let excess = |misfit: &Self| if misfit.is_noise() { 0.0 } else { misfit.share };
        if excess(&other) > excess(&self) || (excess(&self) == 0.0 && other.share > self.share) { other } else { self }
    }
}

/// Regresses residuals on functions of the motion, record by record, and returns the largest misfit.
pub fn misfit(fitted: &Fitted, traces: &[Trace<'_>]) -> Misfit {
    let longest = fitted.residuals.iter().map(Vec::len).max().unwrap_or_default();
    let each: Vec<Option<Regression>> = parallel::indexed(traces.len(), |index| {
        let regressors = of_motion(fitted, &traces[index])?;
        let residual = &fitted.residuals[index];
        let is_short =
            residual.len() < FEWEST_PER_REGRESSOR * regressors.len() && SHORT_BESIDE * residual.len() < longest;
        let is_negligible = rms(residual) < NEGLIGIBLE_SHARE * rms(traces[index].record.position());
        (!is_short && !is_negligible).then(|| of_trace(fitted, index, &regressors))
    });
    let all: Vec<(&Trace<'_>, Option<Regression>)> = traces.iter().zip(each).collect();
    // None for a record without gaps.
    let cut_from = |trace: &Trace<'_>| {
        let source = trace.record.source();
        Some(whole_record(source)).filter(|whole| *whole != source.display().to_string())
    };
    let is_next = |one, next| cut_from(one).is_some_and(|record| Some(record) == cut_from(next));
    let of_one_record = all.chunk_by(|(one, _), (next, _)| is_next(one, next));
    let misfits = of_one_record.map(|segments| {
        let regressions = segments.iter().filter_map(|(_, regression)| *regression);
        regressions.reduce(Regression::with).map(|together| together.misfit()).unwrap_or_default()
    });
    misfits.reduce(Misfit::greater).unwrap_or_default()
}

/// Root mean square of the part of the residual that no regressor explains [deg]: an estimate of the noise that does not depend on what the model
/// lacks.
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn noise_rms(fitted: &Fitted, traces: &[Trace<'_>]) -> f64 {
    let each = traces.iter().enumerate().filter_map(|(index, trace)| {
        let regressors = of_motion(fitted, trace)?;
        let free = fitted.residuals[index].len().saturating_sub(regressors.len()).max(1);
        Some((of_trace(fitted, index, &regressors).rest_squares, free as f64))
    });
    let (squares, free) = each.fold((0.0, 0.0), |(squares, sum), (square, free)| (squares + square, sum + free));
    (squares / f64::max(free, 1.0)).sqrt()
}

/// Regressors of the simulated motion that vary.
fn of_motion(fitted: &Fitted, trace: &Trace<'_>) -> Option<Vec<Regressor>> {
    let motion = trace.motion(&fitted.model)?;
    let scales = Scales::of(std::slice::from_ref(&motion));
    let mut found = regressors(trace, &motion, scales);
    found.retain(|regressor| rms(&regressor.values) > 0.0);
    Some(found)
}

/// Result of the regression of a residual.
#[derive(Debug, Clone, Copy)]
struct Regression {
    /// Σ w² of the whitened residual w, before and after the regression.
    before: f64,
    after: f64,
    /// Numbers of samples, of regressors, and of records or segments that each have such regressors.
    count: f64,
    regressors: f64,
    segments: f64,
    /// Sum of squares of the residual without the explained part [deg²].
    rest_squares: f64,
}

impl Regression {
    /// Both together, each with its own factors.
    fn with(self, other: Self) -> Self {
        Self {
            before: self.before + other.before,
            after: self.after + other.after,
            count: self.count + other.count,
            regressors: self.regressors + other.regressors,
            segments: self.segments + other.segments,
            rest_squares: self.rest_squares + other.rest_squares,
        }
    }

    fn misfit(&self) -> Misfit {
        let free = (self.count - self.regressors).max(1.0);
        let left = (self.after / free).max(f64::MIN_POSITIVE);
        Misfit {
            share: self.share(),
            f: (self.before - self.after) / self.regressors / left,
            critical: 1.0 + CRITICAL_DEVIATIONS * (2.0 * self.segments / self.regressors).sqrt(),
        }
    }

    fn share(&self) -> f64 {
        let free = (self.count - self.regressors).max(1.0);
        (1.0 - (self.after / free) / (self.before / self.count)).max(0.0)
    }
}

#[allow(clippy::cast_precision_loss)] // counts of samples
fn of_trace(fitted: &Fitted, index: usize, regressors: &[Regressor]) -> Regression {
    let noise = &fitted.noise[index];
    let residual = white(noise, fitted.residuals[index].clone());
    let columns: Vec<Vec<f64>> = regressors.iter().map(|regressor| white(noise, regressor.values.clone())).collect();
    let factors = solve(&columns, &residual);
    let mut left = residual.clone();
    subtract(&mut left, &columns, &factors);
    let mut gap = vec![0.0; residual.len()];
    for (regressor, factor) in regressors.iter().zip(&factors) {
        gap.iter_mut().zip(&regressor.values).for_each(|(value, column)| *value += factor * column);
    }
    let plain = &fitted.residuals[index];
    let rest: Vec<f64> = plain.iter().zip(&gap).map(|(all, gap)| all - gap).collect();
    Regression {
        before: dot(&residual, &residual),
        after: dot(&left, &left),
        count: residual.len() as f64,
        regressors: columns.len() as f64,
        segments: 1.0,
        // Factors fitted to the whitened residual need not reduce the plain one.
        rest_squares: dot(&rest, &rest).min(dot(plain, plain)),
    }
}

/// Regressors that explain the residual of the record with the largest misfit, by orthogonal matching pursuit: a sparse regression that does not
/// identify the cause.
pub fn explaining_regressors(fitted: &Fitted, traces: &[Trace<'_>]) -> Vec<ExplainingRegressor> {
    const MOST: usize = 5;
    let of = |index: usize| {
        let regressors = of_motion(fitted, &traces[index])?;
        Some((of_trace(fitted, index, &regressors).share(), index, regressors))
    };
    let worst = (0..traces.len()).filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, index, regressors)) = worst else { return Vec::new() };
    let noise = &fitted.noise[index];
    let residual = white(noise, fitted.residuals[index].clone());
    let columns: Vec<Vec<f64>> = regressors.iter().map(|regressor| white(noise, regressor.values.clone())).collect();
    let whole = dot(&residual, &residual);
    let (mut chosen, mut left, mut found) = (Vec::<usize>::new(), whole, Vec::new());
    while chosen.len() < MOST {
        let with = |place: usize| {
            let tried: Vec<Vec<f64>> = chosen.iter().chain([&place]).map(|place| columns[*place].clone()).collect();
            let factors = solve(&tried, &residual);
            let mut rest = residual.clone();
            subtract(&mut rest, &tried, &factors);
            (dot(&rest, &rest), place)
        };
        let places = (0..columns.len()).filter(|place| !chosen.contains(place));
        let Some((rest, place)) = places.map(with).min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        let share = (left - rest) / whole;
        if share < 0.5 * MATERIAL_SHARE {
            break;
        }
        let Regressor { name, kind, .. } = regressors[place];
        let sentence = format!(
            "{name} explains {:.0} % of the residual of {}",
            100.0 * share,
            traces[index].record.source().display()
        );
        found.push(ExplainingRegressor { term: name, kind, share, sentence });
        chosen.push(place);
        left = rest;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1000 samples in units of the noise, with 40 regressors that explain this sum of squares.
    fn explained(squares: f64) -> Regression {
        Regression {
            before: 1000.0,
            after: 1000.0 - squares,
            count: 1000.0,
            regressors: 40.0,
            segments: 1.0,
            rest_squares: 1000.0 - squares,
        }
    }

    #[test]
    fn a_misfit_of_all_segments_of_a_record_is_one_and_the_worst_of_many_is_none() {
        // Of noise they explain 40; another 75 in one of six segments is 8 % of this segment and 1 % of the record.
        let alone = explained(115.0).misfit();
        assert!(!alone.is_noise() && alone.share > 0.07, "{alone:?}");
        let others = std::iter::repeat_n(explained(40.0), 5);
        let together = others.fold(explained(115.0), Regression::with).misfit();
        assert!(together.is_noise() && together.share < 0.02, "{together:?}");
        assert!((together.critical - alone.critical).abs() < 1e-12);
        let everywhere = std::iter::repeat_n(explained(115.0), 5).fold(explained(115.0), Regression::with).misfit();
        assert!(!everywhere.is_noise() && (everywhere.share - alone.share).abs() < 1e-12, "{everywhere:?}");
    }
}
