//! The wide search: one effect beside a free base, by plain output error.
//!
//! A linear model fitted to limited motion may be a factor away from the base on which the limit acts. The base is therefore searched from several
//! starts, with p, a delay and a level in each record free; every effect is screened at its ladder of start values on each of several bases and
//! refined for a few iterations, the best ones fully.

use std::f64::consts::PI;

use super::{
    given_effects::delay_s,
    hypothesis::{DELAY, Hypothesis, MeasurementTerm},
    jacobian::SimulationCache,
    output_error::OutputError,
    plain_fit::{PlainFit, mean_square},
    plausibility::is_plausible,
    screening::{changes, is_linear_in_strength, observe, scaled},
    sensitivities::{Columns, LinearStep, Sensitivities},
    space::Space,
    trace::{Trace, interval_s},
};
use crate::{estimate::noise::Noise, parallel, sorting::sort_by_number};
use actuator_fmu::{
    effects::{CHAIN, Effect, Observed, find},
    parameters::{Base, Model, Order},
};

/// Multiples of the given ω, or of twice the slow pole of an overdamped pair, from which the base is searched.
const OMEGA_FACTORS: [f64; 5] = [0.6, 1.0, 1.6, 3.0, 8.0];
/// Start values of the damping ratio besides the given one.
const DAMPING_RATIOS: [f64; 2] = [0.5, 1.0];
/// Start value of a free pole, as a multiple of ω: fast enough to be simulated as a decay.
const POLE_RATIO: f64 = 5.0;
/// Smallest start value of a free delay, in samples.
const DELAY_SAMPLES: f64 = 0.5;
/// Number of bases that are refined.
const BASES_REFINED: usize = 3;

const PRELIMINARY_ITERATIONS: usize = 5;
const FINAL_ITERATIONS: usize = 25;
/// Number of effects that are refined fully.
const EFFECTS_REFINED: usize = 6;

/// The outcome of a wide search on some records.
pub struct Wide {
    /// The free base without an effect.
    pub base: PlainFit,
    /// Fits with one effect, best first.
    pub candidates: Vec<PlainFit>,
}

/// Searches; none where the motion of every base diverges.
pub fn search(given: &Model, traces: &[Trace<'_>]) -> Option<Wide> {
    let interval_s = interval_s(traces);
    let starts = base_starts(given, interval_s);
    let free = Hypothesis { base_free: true, wide: true, ..Hypothesis::default() };
    let preliminary = |start: &Model| {
        let space = Space::new(free.clone(), start, &given.base, 0.0).within_sampling(interval_s);
        PlainFit::search(space, traces, PRELIMINARY_ITERATIONS)
    };
    let mut bases: Vec<PlainFit> = parallel::map(&starts, preliminary).into_iter().flatten().collect();
    sort_by_number(&mut bases, |one| one.mean_square());
    bases.truncate(BASES_REFINED);
    let mut bases: Vec<PlainFit> = parallel::map_owned(bases, |base| further(base, traces));
    sort_by_number(&mut bases, |one| one.mean_square());
    let base = bases.into_iter().next()?;
    let is_shifted = |start: &Model| start.base.zeta() != DAMPING_RATIOS[1] && start.base.omega() >= given.base.omega();
    let shifted: Vec<Model> = starts.into_iter().filter(is_shifted).collect();
    let observed = observe(&base.model, &base.residuals, traces);
    let sensitivities = sensitivities(&base, traces).map(Sensitivities::new);
    let preliminary = |effect: &&'static Effect| -> Vec<PlainFit> {
        let beside = (&base, sensitivities.as_ref());
        let starts = start_values(effect, beside, &shifted, given, &observed, traces).into_iter();
        starts.filter_map(|start| PlainFit::search(start, traces, PRELIMINARY_ITERATIONS)).collect()
    };
    let found = parallel::map(&candidates(given, traces), preliminary);
    let mut preliminary: Vec<PlainFit> = found.into_iter().flatten().collect();
    sort_by_number(&mut preliminary, |one| one.mean_square());
    let mut seen = Vec::new();
    preliminary.retain(|fit| {
        let effect = effect_of(fit);
        let new = !seen.contains(&effect);
        seen.push(effect);
        new
    });
    let rest = preliminary.split_off(EFFECTS_REFINED.min(preliminary.len()));
    let mut candidates: Vec<PlainFit> = parallel::map_owned(preliminary, |fit| further(fit, traces));
    candidates.extend(rest);
    sort_by_number(&mut candidates, |one| one.mean_square());
    Some(Wide { base, candidates })
}

/// The effect of a candidate.
pub fn effect_of(fit: &PlainFit) -> &'static str {
    fit.space.hypothesis.effects.last().copied().unwrap_or("")
}

/// A fit with its search continued to the end.
pub fn further(fit: PlainFit, traces: &[Trace<'_>]) -> PlainFit {
    let next = PlainFit::search_from(fit.space.clone(), &fit.x, traces, FINAL_ITERATIONS);
    next.filter(|next| next.mean_square() <= fit.mean_square()).unwrap_or(fit)
}

/// Why the parameters of a fit are implausible, or at a bound; none otherwise.
pub fn implausible(fit: &PlainFit) -> Option<String> {
    let effect = find(effect_of(fit))?;
    if !is_plausible(effect, &fit.model.effects) {
        return Some("its parameters are implausible".to_owned());
    }
    if fit.space.is_base_at_bound(&fit.x) {
        return Some("the base beside it is at a bound of its range".to_owned());
    }
    fit.space.effect_at_bound(&fit.x).then(|| "a parameter is at a bound of its range".to_owned())
}

fn base_starts(given: &Model, interval_s: f64) -> Vec<Model> {
    let [k, p, omega, zeta] = given.base.values();
    // A search by the logarithm does not leave a delay of practically zero, with which fits may end.
    let delay_s = delay_s(given).max(DELAY_SAMPLES * interval_s);
    let effects = match find(DELAY).map(|delay| given.effects.with(delay, &[delay_s])) {
        Some(Ok(effects)) => effects,
        _ => given.effects.clone(),
    };
    let start = |factor: f64, zeta: f64, p: f64| {
        let base = Base::from_values([k, p, factor * omega, zeta]).ok()?;
        Some(Model { base, order: Order::Third, effects: effects.clone(), ..given.clone() })
    };
    let fast = if given.order == Order::Third { p } else { POLE_RATIO * omega };
    let mut starts: Vec<Model> = start(1.0, zeta, fast).into_iter().collect();
    // If the fast pole of an overdamped pair is beyond the motion, so is ω; the lag of the pair is that of its slow pole.
    let reference = if zeta > 1.0 { (2.0 * given.base.pair_decay() / omega).min(1.0) } else { 1.0 };
    let factors = OMEGA_FACTORS.map(|factor| factor * reference);
    let sampled = factors.into_iter().filter(|factor| *factor <= 1.0 || factor * omega <= PI / interval_s);
    for factor in sampled {
        for zeta in DAMPING_RATIOS {
            starts.extend(start(factor, zeta, POLE_RATIO * factor * omega));
        }
    }
    starts
}

/// Effects that a linear base cannot imitate and that the motion identifies.
fn candidates(given: &Model, traces: &[Trace<'_>]) -> Vec<&'static Effect> {
    const LINEAR: [&str; 4] = ["delay", "sensor_lag", "structural_mode", "quantisation"];
    let active: Vec<&str> = given.effects.active().map(|(effect, _)| effect.name).collect();
    let has_load = traces.iter().any(|trace| trace.record.load().is_some());
    let admissible = |effect: &&&Effect| {
        !LINEAR.contains(&effect.name)
            && !active.contains(&effect.name)
            && MeasurementTerm::of(effect.name).is_none()
            && (effect.name != "hinge_load" || has_load)
    };
    CHAIN.iter().filter(admissible).copied().collect()
}

/// Sensitivities of each record to the parameters of a base.
fn sensitivities(base: &PlainFit, traces: &[Trace<'_>]) -> Option<Columns> {
    let noise: Vec<Noise> = traces.iter().map(|_| Noise::white(1.0)).collect();
    let cache = SimulationCache::default();
    let problem = OutputError::new(&base.space, traces, &noise, &cache);
    Some(problem.sensitivities(&base.x, &problem.simulated(&base.x)?))
}

/// The best starts beside the refined base, by the residual predicted after a linear step and without one, and the best one beside the shifted bases.
fn start_values(
    effect: &'static Effect,
    (base, sensitivities): (&PlainFit, Option<&Sensitivities>),
    shifted: &[Model],
    given: &Model,
    observed: &Observed,
    traces: &[Trace<'_>],
) -> Vec<Space> {
    let ladder = (effect.start_values)(observed);
    let hypothesis = Hypothesis { effects: vec![effect.name], base_free: true, wide: true, ..Hypothesis::default() };
    let space_with = |model: &Model, values: &[f64]| {
        let effects = model.effects.with(effect, values).ok()?;
        let start = Model { effects, ..model.clone() };
        Some(Space::new(hypothesis.clone(), &start, &given.base, 0.0).within_sampling(interval_s(traces)))
    };
    let at = |values: &Vec<f64>| PlainFit::at_start(space_with(&base.model, values)?, traces);
    let beside_base: Vec<(&Vec<f64>, PlainFit)> =
        ladder.iter().filter_map(|values| Some((values, at(values)?))).collect();
    let mut starts = Vec::new();
    if let Some(sensitivities) = sensitivities {
        let scored = beside_base.iter().filter_map(|(values, at)| {
            let shares = is_linear_in_strength(effect).then(|| changes(&base.residuals, &at.residuals));
            let from = if shares.is_some() { &base.residuals } else { &at.residuals };
            let LinearStep { factors, left } = sensitivities.step(shares.as_deref(), from);
            let start = match (&shares, factors.last()) {
                (Some(_), Some(share)) => space_with(&base.model, &scaled(effect, values, *share))?,
                _ => at.space.clone(),
            };
            Some((mean_square(&left.concat()), start))
        });
        starts.extend(scored.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, start)| start));
    }
    let order = |a: &PlainFit, b: &PlainFit| a.mean_square().total_cmp(&b.mean_square());
    let beside_shifted = shifted.iter().flat_map(|model| ladder.iter().filter_map(|values| space_with(model, values)));
    let of_base = beside_base.into_iter().map(|(_, fit)| fit).min_by(order);
    for best in [of_base, PlainFit::nearest_start(beside_shifted, traces)].into_iter().flatten() {
        if starts.iter().all(|start| start.start() != best.x) {
            starts.push(best.space);
        }
    }
    starts
}
