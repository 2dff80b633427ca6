//! Candidates: every effect of the chain at its place, with the base free.
//!
//! All are screened ([`super::screening`]). The most promising are fitted, first to a loose tolerance; those close to the best one are then fitted
//! further. The given base is tried as well as the free one: an effect that needs no other base is the simpler hypothesis.

use super::{
    fitted::{Fitted, SearchEffort},
    given_effects::{changeable, with_strengths_of},
    hypothesis::{Hypothesis, MeasurementTerm, family},
    plausibility::{is_plausible, is_sampled},
    screening::{Screened, observe, screen},
    space::Space,
    trace::Trace,
};
use crate::{parallel, sorting::sort_by_number};
use actuator_fmu::{effects::Effect, parameters::Model};

/// Effects fitted after screening, at least and at most.
const FEWEST_SEARCHED: usize = 5;
const MOST_SEARCHED: usize = 9;

/// A screened effect is fitted if its gain in BIC falls short of the best gain by less than this share of it. Wide, since it is screened at a start
/// value.
const SCREENING_RANGE: f64 = 0.5;

/// A preliminary fit is continued if its gain in BIC falls short of the best gain by less than this share of it, or by less than this BIC.
const CONTINUATION_RANGE: f64 = 0.15;
const CONTINUATION_BIC_RANGE: f64 = 200.0;

/// All hypotheses with one effect more than the current one, best first.
pub fn add_effect(current: &Fitted, given: &Model, traces: &[Trace<'_>]) -> Vec<Fitted> {
    add_one_of(current, given, traces, &|_| true, MOST_SEARCHED)
}

/// The same for all effects except the known ones; all of them are fitted, whatever their screening.
pub fn add_other_effect(known: &[&str], current: &Fitted, given: &Model, traces: &[Trace<'_>]) -> Vec<Fitted> {
    add_one_of(current, given, traces, &|effect| !known.contains(&effect.name), usize::MAX)
}

/// The same for the other effects of an effect's family.
pub fn add_effect_of_family(current: &Fitted, effect: &str, given: &Model, traces: &[Trace<'_>]) -> Vec<Fitted> {
    let family = family(effect);
    add_one_of(current, given, traces, &|other| other.name != effect && other.family.name() == family, usize::MAX)
}

/// The same with one of the measurement terms, which do not depend on the motion.
pub fn add_measurement_term(current: &Fitted, given: &Model, traces: &[Trace<'_>]) -> Vec<Fitted> {
    add_one_of(current, given, traces, &|effect| MeasurementTerm::of(effect.name).is_some(), MOST_SEARCHED)
}

fn add_one_of(
    current: &Fitted,
    given: &Model,
    traces: &[Trace<'_>],
    admissible: &dyn Fn(&Effect) -> bool,
    most: usize,
) -> Vec<Fitted> {
    let observed = observe(&current.model, &current.residuals, traces);
    let Some((mut screened, columns)) = screen(current, &observed, traces, admissible) else { return Vec::new() };
    sort_by_number(&mut screened, |one| one.bic);
    let Some(best) = screened.first().map(|best| best.bic) else { return Vec::new() };
    let reach = (SCREENING_RANGE * (current.bic - best)).max(0.0);
    let followed = screened.into_iter().enumerate().filter(|(place, candidate)| {
        *place < FEWEST_SEARCHED || most == usize::MAX || (*place < most && candidate.bic < best + reach)
    });
    let followed: Vec<Screened> = followed.map(|(_, candidate)| candidate).collect();
    let search =
        |space: Space, effort: SearchEffort| Fitted::search_with_sensitivities(space, traces, effort, Some(&columns));
    let preliminary = parallel::map_owned(followed, |candidate| search(candidate.space, SearchEffort::Preliminary));
    let found: Vec<Fitted> = preliminary.into_iter().flatten().collect();
    let best = found.iter().map(|fitted| fitted.bic).fold(f64::INFINITY, f64::min);
    let reach = (CONTINUATION_RANGE * (current.bic - best)).max(CONTINUATION_BIC_RANGE);
    let mut found = parallel::map_owned(found, |fitted| {
        let again = || search(restart(&fitted, fitted.space.hypothesis.base_free), SearchEffort::Continued);
        let further = (fitted.bic < best + reach).then(again).flatten();
        match further {
            Some(further) if further.bic < fitted.bic => further,
            Some(further) => Fitted { converged: fitted.converged || further.converged, ..fitted },
            None => fitted,
        }
    });
    // A preliminary fit that is worse than no effect at all has not converged: it is no evidence.
    let without_effect = current.rms();
    found.retain(|fitted| fitted.bic < best + reach || fitted.rms() <= without_effect);
    sort_by_number(&mut found, |one| one.bic);
    let mut found = prefer_given_base(found, given, traces);
    found.retain(|fitted| plausible(fitted, observed.sample_time_s));
    found
}

/// A space that starts where a search ended, with the base free or not.
pub fn restart(fitted: &Fitted, base_free: bool) -> Space {
    let chatter_hz = fitted.space.chatter_hz(&fitted.x);
    let hypothesis = Hypothesis { base_free, ..fitted.space.hypothesis.clone() };
    Space::new(hypothesis, &fitted.model, fitted.space.given(), chatter_hz)
}

/// The same effects with the base as given, where that is the simpler explanation.
pub fn prefer_given_base(found: Vec<Fitted>, given: &Model, traces: &[Trace<'_>]) -> Vec<Fitted> {
    // BIC above the best one up to which the given base is tried: fixing the base lowers the BIC by a few tens at most.
    const GIVEN_BASE_BIC_RANGE: f64 = 60.0;
    let Some(best) = found.first().map(|best| best.bic) else { return found };
    let mut found = parallel::map_owned(found, |fitted| {
        if fitted.bic >= best + GIVEN_BASE_BIC_RANGE {
            return fitted;
        }
        // Beside a free base the effects of the given model were free as well.
        let own = &fitted.space.hypothesis.effects;
        let others = changeable(given).filter(|effect| !own.contains(&effect.name));
        let effects = with_strengths_of(given, others, fitted.model.effects.clone());
        let start = Model { base: given.base, order: given.order, effects, ..fitted.model.clone() };
        let hypothesis = Hypothesis { base_free: false, ..fitted.space.hypothesis.clone() };
        let space = Space::new(hypothesis, &start, &given.base, fitted.space.chatter_hz(&fitted.x));
        let simpler = Fitted::search(space, traces, SearchEffort::Coarse);
        simpler.filter(|simpler| simpler.bic < fitted.bic).unwrap_or(fitted)
    });
    sort_by_number(&mut found, |one| one.bic);
    found
}

fn plausible(fitted: &Fitted, interval_s: f64) -> bool {
    let added =
        fitted.model.effects.iter().filter(|(effect, _)| fitted.space.hypothesis.effects.contains(&effect.name));
    added
        .into_iter()
        .all(|(effect, values)| is_plausible(effect, &fitted.model.effects) && is_sampled(effect, values, interval_s))
}
