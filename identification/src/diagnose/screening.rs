//! Screening: every effect at each value of its ladder of start values is simulated once, and what the base could still take of the
//! residual is predicted by its sensitivities. The best start value of each effect ranks it.

use rayon::prelude::*;

use super::{
    fitted::Fitted,
    hypothesis::{Hypothesis, Term},
    output_error::{BaseColumns, Explanation, Lately},
    quantiser,
    space::Space,
    spectral_peak,
    trace::{Motion, Trace},
};
use crate::{
    estimate::noise::Noise,
    linear_least_squares::{solve, subtract},
    signal::record::Sampling,
};
use actuator_fmu::{
    effects::{CHAIN, Effect, Observed, Parameter},
    parameters::Model,
};

/// What records show of a motion and of what a hypothesis leaves.
pub fn observe(current: &Fitted, traces: &[Trace<'_>]) -> Observed {
    let motions: Vec<Motion> = traces.iter().filter_map(|trace| trace.motion(&current.model)).collect();
    let peak = |of: &dyn Fn(&Motion) -> &Vec<f64>| {
        motions.iter().flat_map(of).fold(0.0, |peak: f64, value| peak.max(value.abs()))
    };
    let positions = || traces.iter().flat_map(|trace| trace.record.position());
    let commands = traces.iter().flat_map(|trace| trace.record.command());
    let all: Vec<f64> = current.residuals.iter().flatten().copied().collect();
    #[allow(clippy::cast_precision_loss)] // a count of samples
    let count = all.len().max(1) as f64;
    let longest = traces.iter().map(|trace| trace.record.duration_s()).fold(0.0, f64::max);
    let (Sampling::Even(sample_time_s) | Sampling::Uneven(sample_time_s)) = traces[0].record.sampling();
    Observed {
        command_peak: commands.fold(0.0, |peak: f64, value| peak.max(value.abs())),
        position_range: (
            positions().copied().fold(f64::INFINITY, f64::min),
            positions().copied().fold(f64::NEG_INFINITY, f64::max),
        ),
        rate_peak: peak(&|motion| &motion.rate),
        acceleration_peak: peak(&|motion| &motion.drive),
        residual_rms: current.rms(),
        residual_mean: all.iter().sum::<f64>() / count,
        residual_frequency_hz: spectral_peak::strongest_hz(&current.residuals, traces),
        position_step: traces
            .iter()
            .map(|trace| quantiser::step(trace.record.position()))
            .fold(f64::INFINITY, f64::min),
        duration_s: longest,
        sample_time_s,
    }
}

/// The best rung of every wanted effect's ladder, and the sensitivities to the base.
pub fn look(
    current: &Fitted,
    observed: &Observed,
    traces: &[Trace<'_>],
    wanted: &dyn Fn(&Effect) -> bool,
) -> Option<(Vec<Fitted>, BaseColumns)> {
    let flat: Vec<Noise> = traces.iter().map(|_| Noise::white(1.0)).collect();
    let mut free = current.clone();
    free.space = Space::new(
        Hypothesis { base_free: true, ..current.space.hypothesis.clone() },
        &current.model,
        current.space.given(),
        current.space.chatter_hz(&current.x),
    );
    free.x = free.space.start();
    free.model = without_terms(&free);
    let lately = Lately::default();
    let explanation = Explanation { space: &free.space, traces, noise: &flat, base_columns: None, lately: &lately };
    let columns = explanation.sensitivities(&free.x, &explanation.simulated(&free.x)?);
    let active: Vec<&str> = current.model.effects.active().map(|(effect, _)| effect.name).collect();
    let candidates: Vec<&'static Effect> = CHAIN
        .iter()
        .copied()
        .filter(|effect| !active.contains(&effect.name) && !current.space.hypothesis.effects.contains(&effect.name))
        .filter(|effect| effect.name != "quantisation" && wanted(effect))
        .collect();
    let ladders =
        candidates.iter().flat_map(|effect| (effect.guess)(observed).into_iter().map(|guess| (*effect, guess)));
    let try_all = |rungs: Vec<(&'static Effect, Vec<f64>)>| -> Vec<Fitted> {
        let tried = rungs.into_par_iter();
        tried.filter_map(|(effect, guess)| rung(&free, effect, &guess, &columns, observed, traces)).collect()
    };
    let mut best = Vec::new();
    keep_best(&mut best, try_all(ladders.collect()));
    // A limit that is only just reached shows between two rungs or not at all.
    let close: Vec<(&Effect, Vec<f64>)> = candidates
        .iter()
        .filter(|effect| !is_proportional(effect) && Term::of(effect.name).is_none())
        .filter_map(|effect| {
            Some((*effect, values_of(best.iter().find(|look| added(look) == Some(effect.name))?, effect)?))
        })
        .flat_map(|(effect, values)| BETWEEN.map(|share| (effect, values.iter().map(|value| share * value).collect())))
        .collect();
    keep_best(&mut best, try_all(close));
    let base = columns.into_iter().map(|mut record| {
        record.truncate(BASE_NUMBERS);
        record
    });
    Some((best, base.collect()))
}

/// Between a rung and its neighbours.
const BETWEEN: [f64; 2] = [0.94, 1.06];

fn added(look: &Fitted) -> Option<&'static str> {
    look.space.hypothesis.effects.last().copied()
}

fn values_of(look: &Fitted, effect: &Effect) -> Option<Vec<f64>> {
    look.model.effects.iter().find(|(other, _)| other.name == effect.name).map(|(_, values)| values.to_vec())
}

/// Of each effect the look that explains most.
fn keep_best(best: &mut Vec<Fitted>, looks: Vec<Fitted>) {
    for look in looks {
        match best.iter_mut().find(|other| added(other) == added(&look)) {
            Some(other) if other.bic <= look.bic => {}
            Some(other) => *other = look,
            None => best.push(look),
        }
    }
}

/// k, ω and ζ come first in every vector of a free base.
const BASE_NUMBERS: usize = 3;

/// One rung: the effect at this strength, and what the numbers searched for so far would still take of the residual.
fn rung(
    free: &Fitted,
    effect: &'static Effect,
    guess: &[f64],
    columns: &[Vec<Vec<f64>>],
    observed: &Observed,
    traces: &[Trace<'_>],
) -> Option<Fitted> {
    let mut hypothesis = free.space.hypothesis.clone();
    hypothesis.effects.push(effect.name);
    let mut start = free.model.clone();
    start.effects = start.effects.with(effect, guess).ok()?;
    let chatter_hz =
        if effect.name == "chatter" { observed.residual_frequency_hz } else { free.space.chatter_hz(&free.x) };
    let space = Space::new(hypothesis, &start, free.space.given(), chatter_hz);
    let first = Fitted::at_start(space.clone(), traces)?;
    let shares = is_proportional(effect).then(|| changes(&free.residuals, &first.residuals));
    let step =
        solve_together(columns, shares.as_deref(), if shares.is_some() { &free.residuals } else { &first.residuals });
    let mut left = if shares.is_some() { free.residuals.clone() } else { first.residuals.clone() };
    for (index, residual) in left.iter_mut().enumerate() {
        let share = shares.as_ref().map(|shares| &shares[index]);
        subtract(residual, columns[index].iter().chain(share), &step);
    }
    let bic = Fitted::judged(&first.space, &left, traces);
    // The base and the effects so far come before the new one in the chain's order or behind: only the base's places are known.
    let mut moved = first.x.clone();
    let bounds = space.bounds();
    for (place, step) in step.iter().enumerate().take(BASE_NUMBERS) {
        moved[place] = (moved[place] + step).clamp(bounds[place][0], bounds[place][1]);
    }
    let mut model = space.model(&moved)?;
    if let (Some(_), Some(share)) = (&shares, step.last()) {
        model.effects = model.effects.with(effect, &scaled(effect, guess, *share)).unwrap_or(model.effects);
    }
    let space = Space::new(space.hypothesis, &model, free.space.given(), chatter_hz);
    let x = space.start();
    Some(Fitted { bic, space, x, model, ..first })
}

/// Whether a little of the effect does a little of what more of it does: its parameters grow from nothing.
fn is_proportional(effect: &Effect) -> bool {
    let deciding = effect.parameters.iter().filter(|parameter| parameter.decides);
    Term::of(effect.name).is_none() && deciding.clone().all(|parameter| parameter.neutral.abs() < 1.5)
}

/// Parameters of a guess, as far from neutral as this share of it.
fn scaled(effect: &Effect, guess: &[f64], share: f64) -> Vec<f64> {
    // Further than this the proportion is not to be believed.
    const LEAST: f64 = 0.03;
    const MOST: f64 = 10.0;
    let parameters = effect.parameters.iter().zip(guess);
    let scale = |(parameter, value): (&Parameter, &f64)| {
        if !parameter.decides {
            return *value;
        }
        let share =
            if parameter.min >= parameter.neutral { share.clamp(LEAST, MOST) } else { share.clamp(-MOST, MOST) };
        (parameter.neutral + share * (value - parameter.neutral)).clamp(parameter.min, parameter.max)
    };
    parameters.map(scale).collect()
}

fn changes(before: &[Vec<f64>], after: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let each = before.iter().zip(after);
    each.map(|(before, after)| before.iter().zip(after).map(|(before, after)| before - after).collect()).collect()
}

fn without_terms(fitted: &Fitted) -> Model {
    fitted.space.model(&fitted.x).unwrap_or_else(|| fitted.model.clone())
}

/// Least-squares factors of columns that records have in common, and of one more.
fn solve_together(columns: &[Vec<Vec<f64>>], more: Option<&[Vec<f64>]>, residuals: &[Vec<f64>]) -> Vec<f64> {
    let size = columns.first().map_or(0, Vec::len);
    let mut joined: Vec<Vec<f64>> =
        (0..size).map(|place| columns.iter().flat_map(|record| record[place].iter().copied()).collect()).collect();
    joined.extend(more.map(<[Vec<f64>]>::concat));
    solve(&joined, &residuals.concat())
}
