//! The candidates: every effect of the chain at its place, started from what the records show, the base free beside it.
//!
//! Each rung of an effect's ladder of first guesses is simulated once; what the base could still take of the residual is taken by
//! its sensitivities. The most promising are then searched for in earnest, and the base given is tried beside the base free:
//! an effect that needs no other numbers than the given ones is the simpler explanation.

use rayon::prelude::*;

use super::{
    fitted::{Care, Fitted},
    lattice, line,
    problem::{BaseColumns, Explanation, Lately, solve},
    space::{Hypothesis, Space, Term, is_plausible},
    trace::{Motion, Trace},
    verdict,
};
use crate::{estimate::noise::Noise, signal::record::Sampling};
use actuator_fmu::{
    effects::{CHAIN, Effect, Observed, Parameter},
    parameters::Model,
};

/// Effects searched for in earnest after the first look, at least and at most.
const FEWEST: usize = 5;
const MOST: usize = 9;

/// A first look that is this far behind the best one in BIC is not followed. Coarse: the look is at one rung of a ladder.
const BEHIND: f64 = 0.5;

/// The same for a search that is to be continued, and how close it must have come in BIC to be continued whatever the best one gains.
const HARDLY_BEHIND: f64 = 0.15;
const STILL_OPEN: f64 = 200.0;

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
        residual_frequency_hz: line::strongest_hz(&current.residuals, traces),
        position_step: traces.iter().map(|trace| lattice::step(trace.record.position())).fold(f64::INFINITY, f64::min),
        duration_s: longest,
        sample_time_s,
    }
}

/// All hypotheses with one effect more than the current one, best first.
pub fn with_one_more(current: &Fitted, given: &Model, traces: &[Trace<'_>]) -> Vec<Fitted> {
    with_one_of(current, given, traces, &|_| true, MOST)
}

/// The same for all effects but some, with none left out after the first look.
pub fn with_any_but(known: &[&str], current: &Fitted, given: &Model, traces: &[Trace<'_>]) -> Vec<Fitted> {
    with_one_of(current, given, traces, &|effect| !known.contains(&effect.name), usize::MAX)
}

/// The same for the others of an effect's family.
pub fn with_one_of_family(current: &Fitted, effect: &str, given: &Model, traces: &[Trace<'_>]) -> Vec<Fitted> {
    let family = verdict::family(effect);
    with_one_of(current, given, traces, &|other| other.name != effect && other.family.name() == family, usize::MAX)
}

/// The same with one of the terms of the measurement, which do not know the motion.
pub fn with_one_more_term(current: &Fitted, given: &Model, traces: &[Trace<'_>]) -> Vec<Fitted> {
    with_one_of(current, given, traces, &|effect| Term::of(effect.name).is_some(), MOST)
}

fn with_one_of(
    current: &Fitted,
    given: &Model,
    traces: &[Trace<'_>],
    wanted: &dyn Fn(&Effect) -> bool,
    most: usize,
) -> Vec<Fitted> {
    let observed = observe(current, traces);
    let Some((mut looks, columns)) = look(current, &observed, traces, wanted) else { return Vec::new() };
    looks.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    let Some(best) = looks.first().map(|best| best.bic) else { return Vec::new() };
    let reach = (BEHIND * (current.bic - best)).max(0.0);
    let followed = looks
        .into_iter()
        .enumerate()
        .filter(|(place, look)| *place < FEWEST || most == usize::MAX || (*place < most && look.bic < best + reach));
    let followed: Vec<Fitted> = followed.map(|(_, look)| look).collect();
    let search = |fitted: &Fitted, care: Care| {
        let space = restart(fitted, fitted.space.hypothesis.base_free);
        Fitted::search_near(space, traces, care, Some(&columns))
    };
    let mut found: Vec<Fitted> = followed.into_par_iter().filter_map(|look| search(&look, Care::Promise)).collect();
    let best = found.iter().map(|fitted| fitted.bic).fold(f64::INFINITY, f64::min);
    let reach = (HARDLY_BEHIND * (current.bic - best)).max(STILL_OPEN);
    found.par_iter_mut().filter(|fitted| fitted.bic < best + reach).for_each(|fitted| {
        if let Some(further) = search(fitted, Care::Kept).filter(|further| further.bic < fitted.bic) {
            *fitted = further;
        }
    });
    // One that was given up where it explains less than nothing does says nothing of its effect.
    let nothing = current.rms();
    found.retain(|fitted| fitted.bic < best + reach || fitted.rms() <= nothing);
    found.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    with_base_given(&mut found, given, traces);
    found.retain(plausible);
    found
}

/// A space that starts where a search ended, with the base free or not.
pub fn restart(fitted: &Fitted, base_free: bool) -> Space {
    let chatter_hz = fitted.space.chatter_hz(&fitted.x);
    let hypothesis = Hypothesis { base_free, ..fitted.space.hypothesis.clone() };
    Space::new(hypothesis, &fitted.model, fitted.space.given(), chatter_hz)
}

/// The same effects with the base as given, where that is the simpler explanation.
pub fn with_base_given(found: &mut [Fitted], given: &Model, traces: &[Trace<'_>]) {
    // Of the best ones: fixing the base lowers the BIC by a few tens at most.
    const WITHIN: f64 = 60.0;
    let Some(best) = found.first().map(|best| best.bic) else { return };
    found.par_iter_mut().filter(|fitted| fitted.bic < best + WITHIN).for_each(|fitted| {
        let start = Model { base: given.base, order: given.order, ..fitted.model.clone() };
        let hypothesis = Hypothesis { base_free: false, ..fitted.space.hypothesis.clone() };
        let space = Space::new(hypothesis, &start, &given.base, fitted.space.chatter_hz(&fitted.x));
        let simpler = Fitted::search(space, traces, Care::Rough);
        if let Some(simpler) = simpler.filter(|simpler| simpler.bic < fitted.bic) {
            *fitted = simpler;
        }
    });
    found.sort_by(|a, b| a.bic.total_cmp(&b.bic));
}

fn plausible(fitted: &Fitted) -> bool {
    let added = &fitted.space.hypothesis.effects;
    CHAIN.iter().filter(|effect| added.contains(&effect.name)).all(|effect| is_plausible(effect, &fitted.model.effects))
}

/// The best rung of every wanted effect's ladder, and the sensitivities to the base.
fn look(
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
        candidates.iter().flat_map(|effect| (effect.start_values)(observed).into_iter().map(|guess| (*effect, guess)));
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
        for (column, step) in columns[index].iter().chain(share).zip(&step) {
            residual.iter_mut().zip(column).for_each(|(value, column)| *value -= step * column);
        }
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
