//! Effects of the given model at another strength: play that has grown, a limit that has become lower. The model of an earlier diagnosis is the
//! baseline of later records, so that wear shows here first.

use super::{
    candidates::restart,
    evidence::REQUIRED_BIC_LEAD,
    fitted::{Fitted, SearchEffort},
    given_effects::{changeable, with_strengths_of},
    hypothesis::Hypothesis,
    screening::{observe, scaled},
    selection::StructureSelection,
    space::{ParameterIndex, Space},
};
use crate::parallel;
use actuator_fmu::{
    effects::{Effect, Effects, UNLIMITED},
    parameters::Model,
};

/// Start values of a changed strength, over that in the given model.
const SHARES: [f64; 6] = [0.2, 0.5, 0.8, 1.25, 2.0, 5.0];

/// Starts that are refined.
const REFINED: usize = 2;

/// A strength has changed if it differs by more than this share of the larger value, and by more than this number of its standard errors.
const LEAST_CHANGE: f64 = 0.05;
const LEAST_DEVIATIONS: f64 = 2.3;

impl StructureSelection<'_> {
    /// Each effect of the given model at another strength beside the given base, best first.
    pub fn changed(&self, given: &Fitted) -> Vec<Fitted> {
        let effects: Vec<&'static Effect> = changeable(self.given).collect();
        let found = parallel::map(&effects, |effect| self.at_other_strength(effect, given));
        let mut found: Vec<Fitted> = found.into_iter().flatten().collect();
        crate::sorting::sort_by_number(&mut found, |one| one.bic);
        found
    }

    /// The likeliest strength of an effect of the given model, from its ladder of start values and from shares of the given one.
    fn at_other_strength(&self, effect: &'static Effect, given: &Fitted) -> Option<Fitted> {
        let values = self.given.effects.values_of(effect.name)?;
        let observed = observe(&given.model, &given.residuals, &self.fit);
        let ladder = (effect.start_values)(&observed).into_iter();
        let starts = ladder.chain(SHARES.iter().map(|share| at_share(effect, values, *share)));
        let at = |values: Vec<f64>| {
            let start = Model { effects: self.given.effects.with(effect, &values).ok()?, ..self.given.clone() };
            let hypothesis = Hypothesis { effects: vec![effect.name], ..Hypothesis::default() };
            Fitted::at_start(Space::new(hypothesis, &start, &self.given.base, 0.0), &self.fit)
        };
        let mut starts: Vec<Fitted> = starts.filter_map(at).collect();
        crate::sorting::sort_by_number(&mut starts, Fitted::rms);
        starts.truncate(REFINED);
        let search = |start: &Fitted| Fitted::search(restart(start, false), &self.fit, SearchEffort::Full);
        let found = starts.iter().filter_map(search).min_by(|a, b| a.bic.total_cmp(&b.bic));
        // A limit that is no longer reached is removed, unless the BIC without it is higher by this.
        const AS_LIKELY: f64 = 1.0;
        let none = effect.parameters.iter().map(|parameter| parameter.neutral).collect();
        let gone = if is_limit(effect) { at(none) } else { None };
        let is_gone = |gone: &Fitted| found.as_ref().is_none_or(|found| gone.bic < found.bic + AS_LIKELY);
        gone.filter(is_gone).or(found)
    }

    /// The base refitted together with the effects of the given model, starting from their given strengths and from the likeliest change of one of
    /// them.
    pub fn shifted(&self, changed: &[Fitted]) -> Option<Fitted> {
        let free = |start: &Model| self.fit(Hypothesis { base_free: true, ..Hypothesis::default() }, start);
        let starts = std::iter::once(self.given).chain(changed.first().map(|best| &best.model));
        starts.filter_map(free).min_by(|a, b| a.bic.total_cmp(&b.bic))
    }

    /// Whether the given model has an effect.
    pub fn is_given(&self, effect: &str) -> bool {
        self.given.effects.active_values_of(effect).is_some()
    }

    /// An explanation, or another strength of one effect of the given model where its BIC is no higher. Where the effects of the given model were
    /// refitted with the explanation, those that have changed are named with it, unless the base alone explains the records as well.
    pub fn named_by_changes(&self, found: Option<Fitted>, changed: &[Fitted], given: &Fitted) -> Option<Fitted> {
        let single = changed.first().filter(|single| {
            found.as_ref().is_none_or(|found| single.bic <= found.bic)
                && self.have_changed(single, &single.space.hypothesis.effects)
                && self.is_significant(single, given)
                && self.is_adequate(Some(single), given)
        });
        if single.is_some() {
            return single.cloned();
        }
        let found = found?;
        let names: Vec<&'static str> = changeable(self.given)
            .map(|effect| effect.name)
            .filter(|name| self.have_changed(&found, &[name]))
            .collect();
        if names.is_empty() || !found.space.hypothesis.base_free {
            return Some(found);
        }
        let held = Hypothesis { given_held: true, ..found.space.hypothesis.clone() };
        let of_names = changeable(self.given).filter(|effect| names.contains(&effect.name));
        let effects = with_strengths_of(self.given, of_names, found.model.effects.clone());
        let start = Model { effects, ..found.model.clone() };
        let held = Space::new(held, &start, &self.given.base, found.space.chatter_hz(&found.x));
        let is_needed = Fitted::search(held, &self.fit, SearchEffort::Full)
            .is_none_or(|held| found.bic + REQUIRED_BIC_LEAD < held.bic && found.rms() < held.rms());
        if !is_needed {
            return Some(found);
        }
        let others = found.space.hypothesis.effects.iter().copied();
        let effects = others.filter(|other| !names.contains(other)).chain(names.iter().copied()).collect();
        let hypothesis = Hypothesis { effects, ..found.space.hypothesis.clone() };
        let space = Space::new(hypothesis, &found.model, &self.given.base, found.space.chatter_hz(&found.x));
        let named = Fitted::at_start(space, &self.fit)?;
        Some(Fitted { converged: found.converged, ..named })
    }

    /// Whether one of these effects of the given model has changed its strength in a hypothesis.
    fn have_changed(&self, fitted: &Fitted, names: &[&str]) -> bool {
        let covariance = fitted.covariance(&self.fit);
        let (before, after) = (self.given.effects.values(), fitted.model.effects.values());
        Effects::parameters().enumerate().filter(|(_, (effect, _))| names.contains(&effect.name)).any(|(index, _)| {
            let (before, after) = (before[index], after[index]);
            let error = fitted.std_error(covariance.as_ref(), ParameterIndex::Effect(index)).unwrap_or_default();
            let change = (after - before).abs();
            change > LEAST_CHANGE * before.abs().max(after.abs()) && change > LEAST_DEVIATIONS * error
        })
    }
}

/// Values of an effect at a share of its strength: its distance from the neutral value is scaled, or the value itself if it is a limit.
fn at_share(effect: &Effect, values: &[f64], share: f64) -> Vec<f64> {
    if !is_limit(effect) {
        return scaled(effect, values, share);
    }
    let scale = |value: &f64| if value.abs() < UNLIMITED { value * share } else { *value };
    values.iter().map(scale).collect()
}

/// Whether the neutral value of an effect is infinitely large.
fn is_limit(effect: &Effect) -> bool {
    effect.parameters.iter().any(|parameter| parameter.decides && parameter.neutral.abs() >= UNLIMITED)
}
