//! Residuals of an explanation on unseen records: each record by a fit to the others.

use std::ops::Range;

use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

use super::{
    hypothesis::Hypothesis,
    plain_fit::{PlainFit, mean_square},
    space::Space,
    trace::Trace,
};
use crate::parallel;

/// Iterations of a refit, which starts from the fit of all records.
pub const REFIT_ITERATIONS: usize = 8;
/// Largest number of folds: more records are left out in groups.
const MOST_FOLDS: usize = 5;

/// Share of the resamples of a bootstrap in which an explanation must be better.
pub const LEAST_BOOTSTRAP: f64 = 0.95;

/// s and n below which an effect explains nearly all that the base and the linear model leave.
pub const NEARLY_NOTHING: f64 = 0.1;

/// An explanation, judged on unseen records.
#[derive(Clone)]
pub struct Judged {
    /// Fitted to all records.
    pub fit: PlainFit,
    /// Its effect.
    pub effect: &'static str,
    /// Mean square on each unseen record.
    pub left: Vec<f64>,
    /// Share of the base's excess that it leaves, s; for a delay beside the given base that of the given model's, d.
    pub remaining_share: f64,
    /// Share of the given model's excess that it explains beyond the free base, g; for a delay 1 - `remaining_share`.
    pub part: f64,
    /// Share of the linear model's excess that it leaves with such a model beside it, n; none where that leaves noise alone.
    pub nonlinear_share: Option<f64>,
    /// Mean square on each record with a linear model beside it.
    pub beside_linear: Vec<f64>,
    /// Whether its residual is smaller than that of the linear model, or it explains most of what that leaves.
    pub beats_linear: bool,
    /// Parameters of the effect fitted to each record alone, the base held: parameter, record.
    pub of_records: Vec<Vec<f64>>,
    /// Sums of squares of blocks of the unseen records.
    pub blocks: Vec<f64>,
    /// Excess of the effect in the given model, its base held, over that of the given model; none where it is not needed.
    pub left_in_given: Option<f64>,
    /// Why it does not lead; none where it does.
    pub why_not: Option<String>,
}

impl Judged {
    /// Whether it explains nearly all that the free base and the linear model leave.
    pub fn leaves_nearly_nothing(&self) -> bool {
        self.remaining_share < NEARLY_NOTHING && self.nonlinear_share.is_some_and(|share| share < NEARLY_NOTHING)
    }

    /// Root mean square of its residual on the unseen records of a range.
    pub fn rms_of(&self, records: std::ops::RangeFrom<usize>) -> f64 {
        let some = self.left.get(records).unwrap_or_default();
        #[allow(clippy::cast_precision_loss)] // a count of records
        let count = some.len().max(1) as f64;
        (some.iter().sum::<f64>() / count).sqrt()
    }
}

/// Excess of each record, from mean squares.
pub fn excesses<'a>(left: &'a [f64], noise: &'a [f64], counts: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    left.iter().zip(noise).zip(counts).map(|((left, noise), count)| count * (left - noise))
}

/// Excess of all records together.
pub fn excess(left: &[f64], noise: &[f64], counts: &[f64]) -> f64 {
    excesses(left, noise, counts).sum()
}

/// Number of evaluated samples of each record.
pub fn sample_counts(fit: &PlainFit) -> Vec<f64> {
    fit.residuals.iter().map(|residual| count(residual)).collect()
}

/// Mean square on each record by fits to the others, and sums of squares of blocks.
pub fn unseen(fit: &PlainFit, traces: &[Trace<'_>]) -> Option<(Vec<f64>, Vec<f64>)> {
    let folds = traces.len().min(MOST_FOLDS);
    let jacobian = fit.jacobian(traces)?;
    let held: Vec<Option<PlainFit>> = parallel::indexed(folds, |fold| {
        let (unseen, seen): (Vec<usize>, Vec<usize>) = (0..traces.len()).partition(|index| index % folds == fold);
        let unseen: Vec<Trace<'_>> = unseen.into_iter().map(|index| traces[index].clone()).collect();
        let taught = if folds < 2 { fit.clone() } else { fit.refitted(&jacobian, &seen, traces, REFIT_ITERATIONS)? };
        taught.on(&unseen)
    });
    let mut residuals: Vec<Vec<f64>> = vec![Vec::new(); traces.len()];
    for (fold, fit) in held.into_iter().enumerate() {
        let places = (0..traces.len()).filter(|index| index % folds == fold);
        places.zip(fit?.residuals).for_each(|(index, residual)| residuals[index] = residual);
    }
    let left = residuals.iter().map(|residual| mean_square(residual)).collect();
    Some((left, blocks(&residuals)))
}

/// Sums of squares of the tenths of each record.
fn blocks(residuals: &[Vec<f64>]) -> Vec<f64> {
    residuals
        .iter()
        .flat_map(|residual| residual.chunks(block_length(residual)))
        .map(|block| block.iter().map(|value| value * value).sum())
        .collect()
}

/// Places of the blocks of a record.
pub fn blocks_of(fit: &PlainFit, record: usize) -> Range<usize> {
    let counts: Vec<usize> =
        fit.residuals.iter().map(|residual| residual.len().div_ceil(block_length(residual))).collect();
    let from = counts[..record].iter().sum();
    from..from + counts[record]
}

/// Samples of a block.
fn block_length(residual: &[f64]) -> usize {
    const BLOCKS: usize = 10;
    residual.len().div_ceil(BLOCKS).max(1)
}

#[allow(clippy::cast_precision_loss)] // a count of samples
fn count(values: &[f64]) -> f64 {
    values.len() as f64
}

/// The effect's parameters fitted to each record by itself.
pub fn of_records(fit: &PlainFit, effect: &str, traces: &[Trace<'_>]) -> Vec<Vec<f64>> {
    by_parameter(parallel::map(traces, |trace| {
        let (_, own) = on_one(fit, trace)?;
        own.model.effects.values_of(effect).map(<[f64]>::to_vec)
    }))
}

/// The same, but those of all records where a record's own hardly reduce its residual: it does not determine them.
pub fn strengths_by_record(fit: &PlainFit, effect: &str, traces: &[Trace<'_>]) -> Vec<Vec<f64>> {
    const HARDLY_LESS: f64 = 0.9;
    by_parameter(parallel::map(traces, |trace| {
        let (common, own) = on_one(fit, trace)?;
        let fit = if own.mean_square() < HARDLY_LESS * common.mean_square() { own } else { common };
        fit.model.effects.values_of(effect).map(<[f64]>::to_vec)
    }))
}

/// A fit on one record, as it is and with the parameters of its effects refitted.
fn on_one(fit: &PlainFit, trace: &Trace<'_>) -> Option<(PlainFit, PlainFit)> {
    let hypothesis = Hypothesis { base_free: false, ..fit.space.hypothesis.clone() };
    let space = Space::new(hypothesis, &fit.model, fit.space.given(), 0.0);
    let alone = [trace.clone()];
    let common = PlainFit::at_start(space.clone(), &alone)?;
    Some((common, PlainFit::search(space, &alone, REFIT_ITERATIONS)?))
}

/// Values by parameter and record; not a number for records without.
fn by_parameter(each: Vec<Option<Vec<f64>>>) -> Vec<Vec<f64>> {
    let parameters = each.iter().flatten().map(Vec::len).max().unwrap_or_default();
    (0..parameters)
        .map(|place| {
            each.iter().map(|values| values.as_ref().map_or(f64::NAN, |values| values[place])).collect::<Vec<f64>>()
        })
        .collect()
}

/// Share of resamples of the blocks in which the residual of an explanation is smaller than that of a rival.
pub fn bootstrap(rival: &[f64], own: &[f64]) -> f64 {
    const RESAMPLES: u32 = 400;
    let count = rival.len().min(own.len());
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut draw = || random.random_range(0..count.max(1));
    let better = (0..RESAMPLES).filter(|_| {
        let gain: f64 = (0..count).map(|_| draw()).map(|block| rival[block] - own[block]).sum();
        gain > 0.0
    });
    f64::from(u32::try_from(better.count()).unwrap_or_default()) / f64::from(RESAMPLES)
}
