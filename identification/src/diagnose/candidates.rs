//! The candidates: every effect of the chain at its place, started from what the records show, the base free beside it.
//!
//! Each rung of an effect's ladder of first guesses is simulated once; what the base could still take of the residual is taken by
//! its sensitivities. The most promising are then searched for in earnest, and the base given is tried beside the base free:
//! an effect that needs no other numbers than the given ones is the simpler explanation.

use rayon::prelude::*;

use super::{
    fitted::{Care, Fitted},
    hypothesis::{Hypothesis, Term, family},
    screening::{look, observe},
    space::{Space, is_plausible},
    trace::Trace,
};
use actuator_fmu::{
    effects::{CHAIN, Effect},
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
    let family = family(effect);
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
