//! Screening: every effect is simulated once at each value of its ladder of start values, and the part of the residual that a refit of the base would
//! explain is predicted from its sensitivities. The best start value of each effect ranks it.

use std::f64::consts::LN_2;

use super::{
    fitted::Fitted,
    hypothesis::{Hypothesis, MeasurementTerm},
    jacobian::SimulationCache,
    output_error::{BaseSensitivities, OutputError},
    plausibility::is_sampled,
    sensitivities::{LinearStep, Sensitivities},
    space::Space,
    spectral_peak,
    trace::{Motion, Trace},
};
use crate::{
    estimate::noise::Noise,
    parallel,
    signal::{record::rms, sampling::Sampling},
};
use actuator_fmu::{
    effects::{CHAIN, Effect, Observed, Parameter},
    parameters::Model,
};

/// Quantities that start values are derived from: ranges and peaks of the motion, size and frequency of the residual.
pub fn observe(model: &Model, residuals: &[Vec<f64>], traces: &[Trace<'_>]) -> Observed {
    let motions: Vec<Motion> = traces.iter().filter_map(|trace| trace.motion(model)).collect();
    let peak = |of: &dyn Fn(&Motion) -> &Vec<f64>| {
        motions.iter().flat_map(of).fold(0.0, |peak: f64, value| peak.max(value.abs()))
    };
    let positions = || traces.iter().flat_map(|trace| trace.record.position());
    let commands = traces.iter().flat_map(|trace| trace.record.command());
    let all: Vec<f64> = residuals.iter().flatten().copied().collect();
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
        acceleration_peak: peak(&|motion| &motion.acceleration_demand),
        residual_rms: rms(&all),
        residual_mean: all.iter().sum::<f64>() / count,
        residual_frequency_hz: spectral_peak::strongest_frequency_hz(residuals, traces),
        position_step: traces.iter().map(Trace::step).fold(f64::INFINITY, f64::min),
        duration_s: longest,
        sample_time_s,
    }
}

/// A screened start value.
pub struct Screened {
    /// Starts at this value, with the base adjusted by one linear step.
    pub space: Space,
    /// Bayesian information criterion predicted there.
    pub bic: f64,
    effect: &'static Effect,
    strength: Vec<f64>,
}

/// The best start value of every admissible effect, and the sensitivities to the base.
pub fn screen(
    current: &Fitted,
    observed: &Observed,
    traces: &[Trace<'_>],
    admissible: &dyn Fn(&Effect) -> bool,
) -> Option<(Vec<Screened>, BaseSensitivities)> {
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
    let cache = SimulationCache::default();
    let problem = OutputError::new(&free.space, traces, &flat, &cache);
    let columns = problem.sensitivities(&free.x, &problem.simulated(&free.x)?);
    let sensitivities = Sensitivities::new(columns);
    let active: Vec<&str> = current.model.effects.active().map(|(effect, _)| effect.name).collect();
    let candidates: Vec<&'static Effect> = CHAIN
        .iter()
        .copied()
        .filter(|effect| !active.contains(&effect.name) && !current.space.hypothesis.effects.contains(&effect.name))
        .filter(|effect| effect.name != "quantisation" && admissible(effect))
        .collect();
    let ladders = candidates
        .iter()
        .flat_map(|effect| (effect.start_values)(observed).into_iter().map(|guess| (*effect, guess)))
        .filter(|(effect, guess)| is_sampled(effect, guess, observed.sample_time_s));
    let score_all = |start_values: Vec<(&'static Effect, Vec<f64>)>| -> Vec<Screened> {
        let scored = parallel::map(&start_values, |(effect, guess)| {
            score_start_value(&free, effect, guess, &sensitivities, observed, traces)
        });
        scored.into_iter().flatten().collect()
    };
    let mut best = Vec::new();
    keep_best(&mut best, score_all(ladders.collect()));
    // A limit that is only just reached acts between two start values or not at all.
    let close = best
        .iter()
        .filter(|one| !is_linear_in_strength(one.effect) && MeasurementTerm::of(one.effect.name).is_none())
        .flat_map(|one| {
            NEIGHBOUR_FACTORS.map(|share| (one.effect, one.strength.iter().map(|value| share * value).collect()))
        })
        .collect();
    keep_best(&mut best, score_all(close));
    let base = sensitivities.into_columns().into_iter().map(|mut record| {
        record.truncate(BASE_PARAMETERS);
        record
    });
    Some((best, base.collect()))
}

/// Values on both sides of the best start value that are tried as well, as multiples of it.
const NEIGHBOUR_FACTORS: [f64; 2] = [0.94, 1.06];

/// Keeps the start value of each effect with the smallest BIC.
fn keep_best(best: &mut Vec<Screened>, screened: Vec<Screened>) {
    for candidate in screened {
        match best.iter_mut().find(|other| other.effect.name == candidate.effect.name) {
            Some(other) if other.bic <= candidate.bic => {}
            Some(other) => *other = candidate,
            None => best.push(candidate),
        }
    }
}

/// Largest linear step of the logarithms of k, ω and ζ, a factor of two: beyond it the extrapolation is not valid, and a free base would reach poles
/// that take thousands of steps to simulate.
const LARGEST_STEP: f64 = LN_2;

/// k, ω and ζ come first in every vector of a free base.
const BASE_PARAMETERS: usize = 3;

/// Scores one start value: the effect at this strength, the free parameters adjusted by one linear least-squares step.
fn score_start_value(
    free: &Fitted,
    effect: &'static Effect,
    guess: &[f64],
    sensitivities: &Sensitivities,
    observed: &Observed,
    traces: &[Trace<'_>],
) -> Option<Screened> {
    let mut hypothesis = free.space.hypothesis.clone();
    hypothesis.effects.push(effect.name);
    let mut start = free.model.clone();
    start.effects = start.effects.with(effect, guess).ok()?;
    let chatter_hz =
        if effect.name == "chatter" { observed.residual_frequency_hz } else { free.space.chatter_hz(&free.x) };
    let space = Space::new(hypothesis, &start, free.space.given(), chatter_hz);
    let x = space.start();
    let residuals = residuals(&space, &x, traces)?;
    let share = is_linear_in_strength(effect).then(|| changes(&free.residuals, &residuals));
    let from = if share.is_some() { &free.residuals } else { &residuals };
    let LinearStep { factors: step, left } = sensitivities.step(share.as_deref(), from);
    let bic = Fitted::predicted_bic(&space, &left, traces);
    // Effects are in the order of the chain, so that the new one may come before others: only the places of the base are the same.
    let mut moved = x;
    let bounds = space.bounds();
    for (place, step) in step.iter().enumerate().take(BASE_PARAMETERS) {
        let step = step.clamp(-LARGEST_STEP, LARGEST_STEP);
        moved[place] = (moved[place] + step).clamp(bounds[place][0], bounds[place][1]);
    }
    let mut model = space.model(&moved)?;
    if let (Some(_), Some(share)) = (&share, step.last()) {
        model.effects = model.effects.with(effect, &scaled(effect, guess, *share)).unwrap_or(model.effects);
    }
    let strength = model.effects.values_of(effect.name)?.to_vec();
    let space = Space::new(space.hypothesis, &model, free.space.given(), chatter_hz);
    Some(Screened { space, bic, effect, strength })
}

/// Whether the response is taken to be linear in the effect's strength: its parameters grow from a neutral value near zero.
pub fn is_linear_in_strength(effect: &Effect) -> bool {
    let deciding = effect.parameters.iter().filter(|parameter| parameter.decides);
    MeasurementTerm::of(effect.name).is_none() && deciding.clone().all(|parameter| parameter.neutral.abs() < 1.5)
}

/// Parameters of a start value, with their distance from neutral scaled.
pub fn scaled(effect: &Effect, guess: &[f64], share: f64) -> Vec<f64> {
    // Beyond these factors the linear extrapolation is not valid.
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

pub fn changes(before: &[Vec<f64>], after: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let each = before.iter().zip(after);
    each.map(|(before, after)| before.iter().zip(after).map(|(before, after)| before - after).collect()).collect()
}

fn without_terms(fitted: &Fitted) -> Model {
    fitted.space.model(&fitted.x).unwrap_or_else(|| fitted.model.clone())
}

/// Residuals of a vector, not whitened.
fn residuals(space: &Space, x: &[f64], traces: &[Trace<'_>]) -> Option<Vec<Vec<f64>>> {
    let noise: Vec<Noise> = traces.iter().map(|_| Noise::white(1.0)).collect();
    let cache = SimulationCache::default();
    let problem = OutputError::new(space, traces, &noise, &cache);
    Some(problem.record_residuals(x)?.into_iter().map(|record| record.residual).collect())
}
