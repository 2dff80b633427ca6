//! The search for an explanation: forward selection, exchange and elimination of effects, and pairs where that is not adequate.

use std::collections::BTreeSet;

use super::{
    candidates::{add_effect, add_effect_of_family, add_measurement_term, add_other_effect, prefer_given_base},
    evidence::REQUIRED_BIC_LEAD,
    fitted::{Fitted, SearchEffort},
    hypothesis::{Hypothesis, MeasurementTerm},
    predictable::ADEQUATE_SHARE,
    selection::StructureSelection,
    space::Space,
};
use crate::{signal::record::rms, sorting::sort_by_number};
use actuator_fmu::{effects::find, parameters::Model};

/// Largest number of effects: enough of them explain anything.
const MOST_EFFECTS: usize = 3;

/// Rms with one more effect over that without it, above which the selection ends if the motion predicts the residual.
const MOST_LEFT_BY_ONE_MORE: f64 = 0.8;

/// Best hypotheses of a round that are kept as candidates.
const BEAM_WIDTH: usize = 3;

/// Single effects from which pairs are searched, where the best one is not adequate.
const PAIR_BEAM_WIDTH: usize = 2;

/// Hypotheses refined before they are rejected.
const MOST_REFINED: usize = 3;

/// A coarse search whose BIC is higher by less than this may still be best when refined.
pub const REFINEMENT_BIC_RANGE: f64 = 200.0;

impl StructureSelection<'_> {
    /// The first of some hypotheses, best first, that is significant. A coarse search may end too early to show it: the most promising
    /// ones are refined before they are rejected.
    pub fn first_significant(&self, richer: &[Fitted], poorer: &Fitted) -> Option<Fitted> {
        let promising =
            |place: usize, fitted: &Fitted| place < MOST_REFINED && fitted.bic + REQUIRED_BIC_LEAD < poorer.bic;
        richer.iter().enumerate().find_map(|(place, fitted)| {
            if self.is_significant(fitted, poorer) {
                return Some(fitted.clone());
            }
            let refined = promising(place, fitted).then(|| self.refined(fitted.clone()))?;
            self.is_significant(&refined, poorer).then_some(refined)
        })
    }

    /// All hypotheses with one effect more, best first. A base far from the given one may imitate the missing effect: unless the best
    /// hypothesis returns to the given base and leaves noise, the effects are tried from the given base as well.
    pub fn with_one_more_effect(&self, current: &Fitted) -> Vec<Fitted> {
        let mut more = add_effect(current, self.given, &self.fit);
        let is_conclusive = |best: &Fitted| {
            !base_deviates(&best.model, self.given)
                && self.is_significant(best, current)
                && self.misfit(best).is_some_and(|misfit| misfit.is_noise())
        };
        if !base_deviates(&current.model, self.given) || more.first().is_some_and(is_conclusive) {
            return more;
        }
        let Some(back) = self.at_given_base(current) else { return more };
        more.extend(add_effect(&back, self.given, &self.fit));
        best_per_hypothesis(&mut more);
        more
    }

    /// The same effects with the given base, without a search.
    fn at_given_base(&self, current: &Fitted) -> Option<Fitted> {
        let model = Model { base: self.given.base, order: self.given.order, ..current.model.clone() };
        let chatter_hz = current.space.chatter_hz(&current.x);
        let space = Space::new(current.space.hypothesis.clone(), &model, &self.given.base, chatter_hz);
        Fitted::at_start(space, &self.fit)
    }

    /// Forward selection with exchange of earlier effects, then backward elimination.
    pub fn select_forward(&self, best: Fitted, candidates: &mut Vec<Fitted>) -> Option<Fitted> {
        let mut best = self.refined(best);
        while best.space.hypothesis.effects.len() < MOST_EFFECTS && !self.is_over() {
            // Measurement terms do not depend on the motion: the misfit does not show them.
            let is_left =
                self.misfit(&best)?.is_significant() || self.predictable_when_fitted(&best).share > ADEQUATE_SHARE;
            let more = if is_left {
                self.with_one_more_effect(&best)
            } else {
                add_measurement_term(&best, self.given, &self.fit)
            };
            let likeliest = &more[..more.len().min(BEAM_WIDTH)];
            let Some(mut richer) = self.first_significant(likeliest, &best) else { break };
            if self.takes_little(&richer, &best) {
                // It may be likelier than one that explains much, where the remainder beside it is taken for noise.
                let much = likeliest.iter().filter(|other| other.rms() < MOST_LEFT_BY_ONE_MORE * best.rms());
                let much: Vec<Fitted> = much.cloned().collect();
                let Some(other) = self.first_significant(&much, &best) else {
                    best = richer;
                    break;
                };
                richer = other;
            }
            best = self.exchange_in_family(self.refined(richer), candidates);
            candidates.extend(more.into_iter().take(BEAM_WIDTH));
        }
        let best = self.eliminate_backward(best, 1, candidates);
        candidates.push(best.clone());
        Some(best)
    }

    /// Whether a hypothesis leaves nearly as much as a poorer one, and the motion predicts its residual: several effects that each explain a little
    /// of an error of structure are no explanation.
    fn takes_little(&self, richer: &Fitted, poorer: &Fitted) -> bool {
        richer.rms() > MOST_LEFT_BY_ONE_MORE * poorer.rms()
            && self.predictable_when_fitted(richer).share > ADEQUATE_SHARE
    }

    /// Earlier effects are exchanged for others of their family that fit better beside the later ones.
    fn exchange_in_family(&self, mut best: Fitted, candidates: &mut Vec<Fitted>) -> Fitted {
        let Some((_, earlier)) =
            best.space.hypothesis.effects.clone().split_last().map(|(last, rest)| (*last, rest.to_vec()))
        else {
            return best;
        };
        for effect in earlier {
            let Some(bare) = self.with_effect_neutral(&best, effect) else { continue };
            let mut found = add_effect_of_family(&bare, effect, self.given, &self.fit);
            if base_deviates(&bare.model, self.given)
                && let Some(back) = self.at_given_base(&bare)
            {
                found.extend(add_effect_of_family(&back, effect, self.given, &self.fit));
                best_per_hypothesis(&mut found);
            }
            if let Some(other) = found.first().filter(|other| other.bic < best.bic + REFINEMENT_BIC_RANGE) {
                let other = self.refined(other.clone());
                if other.bic < best.bic {
                    candidates.push(best);
                    best = other;
                }
            }
            candidates.extend(found);
        }
        best
    }

    /// Pairs that begin with any of the best single effects, where forward selection was not adequate.
    pub fn search_pairs(&self, base: &Fitted, current: &Fitted, candidates: &mut Vec<Fitted>) -> Option<Fitted> {
        let single = |fitted: &&Fitted| fitted.space.hypothesis.effects.len() == 1;
        let mut starts: Vec<Fitted> = candidates.iter().filter(single).cloned().collect();
        let known: Vec<&str> = starts.iter().map(|start| start.space.hypothesis.effects[0]).collect();
        starts.extend(add_other_effect(&known, base, self.given, &self.fit));
        best_per_hypothesis(&mut starts);
        let adequate = starts.iter().find(|single| {
            self.is_significant(single, current) && self.misfit(single).is_some_and(|misfit| misfit.is_noise())
        });
        if let Some(single) = adequate.cloned() {
            candidates.extend(starts);
            return self.select_forward(single, candidates);
        }
        let pairs = starts
            .iter()
            .take(PAIR_BEAM_WIDTH)
            .flat_map(|start| self.with_one_more_effect(start).into_iter().take(BEAM_WIDTH).collect::<Vec<Fitted>>());
        let mut all: Vec<Fitted> = pairs.collect();
        all.extend(starts);
        sort_by_number(&mut all, |one| one.bic);
        let (promising, others) = all.split_at(MOST_REFINED.min(all.len()));
        let mut promising: Vec<Fitted> = promising.iter().map(|fitted| self.refined(fitted.clone())).collect();
        promising.extend(others.iter().cloned());
        sort_by_number(&mut promising, |one| one.bic);
        let better = promising.iter().find(|other| self.is_significant(other, current)).cloned();
        candidates.extend(promising);
        self.select_forward(better?, candidates)
    }

    /// A hypothesis on the fit records with one effect set to neutral, all other parameters held.
    fn with_effect_neutral(&self, best: &Fitted, effect: &str) -> Option<Fitted> {
        let mut hypothesis = Hypothesis { base_free: true, ..best.space.hypothesis.clone() };
        hypothesis.effects.retain(|other| *other != effect);
        let model = Model { effects: best.model.effects.without(find(effect)?), ..best.model.clone() };
        let space = Space::new(hypothesis, &model, &self.given.base, best.space.chatter_hz(&best.x));
        Fitted::at_start(space, &self.fit)
    }

    /// Without effects that the motion never reaches, such as a limit beyond all of it: the base beside them is then what explains the records.
    pub fn without_unmet_effects(&self, mut found: Fitted) -> Fitted {
        // Rms of the change that an effect makes over that of the residual, below which it is never reached.
        const UNMET: f64 = 1e-3;
        for effect in found.space.hypothesis.effects.clone() {
            // A limit of the given model that is no longer reached is what was found.
            if MeasurementTerm::of(effect).is_some() || self.is_given(effect) {
                continue;
            }
            let Some(without) = self.with_effect_neutral(&found, effect) else { continue };
            let changes: Vec<f64> = (found.residuals.iter().flatten())
                .zip(without.residuals.iter().flatten())
                .map(|(with, without)| with - without)
                .collect();
            if rms(&changes) < UNMET * found.rms() {
                found = Fitted { converged: found.converged, ..without };
            }
        }
        found
    }

    /// Backward elimination: effects that are not significant beside the others are removed, to as few as `fewest`.
    pub fn eliminate_backward(&self, mut best: Fitted, fewest: usize, candidates: &mut Vec<Fitted>) -> Fitted {
        while best.space.hypothesis.effects.len() > fewest {
            let effects = best.space.hypothesis.effects.clone();
            let fewer = effects.iter().filter_map(|needless| self.refit_without(&best, needless));
            let Some(least) = fewer.min_by(|a, b| a.bic.total_cmp(&b.bic)) else { break };
            candidates.push(least.clone());
            if self.is_significant(&best, &least) {
                break;
            }
            best = least;
        }
        best
    }

    /// An explanation refitted without one effect.
    pub fn refit_without(&self, best: &Fitted, needless: &str) -> Option<Fitted> {
        let mut hypothesis = best.space.hypothesis.clone();
        hypothesis.effects.retain(|effect| *effect != needless);
        hypothesis.base_free = true;
        let effect = find(needless)?;
        let mut start = best.model.clone();
        start.effects = start.effects.without(effect);
        let space = Space::new(hypothesis, &start, &self.given.base, best.space.chatter_hz(&best.x));
        let found = vec![Fitted::search(space, &self.fit, SearchEffort::Coarse)?];
        prefer_given_base(found, self.given, &self.fit).pop()
    }
}

/// The best fit of each hypothesis, best first.
fn best_per_hypothesis(found: &mut Vec<Fitted>) {
    sort_by_number(found, |one| one.bic);
    let mut seen = BTreeSet::new();
    found.retain(|fitted| seen.insert(fitted.space.hypothesis.name()));
}

/// Whether a search has moved any parameter of the base by more than estimates of a real actuator differ.
fn base_deviates(free: &Model, given: &Model) -> bool {
    const BASE_DEVIATION: f64 = 0.12;
    let pairs = free.base.values().into_iter().zip(given.base.values());
    pairs.into_iter().any(|(free, given)| (free / given).abs().ln().abs() > BASE_DEVIATION)
}

#[cfg(test)]
mod tests {
    use crate::diagnose::{
        diagnosis::Verdict,
        three_records::{said, three_records_of},
    };
    use actuator_fmu::{
        effects::find,
        parameters::{Base, Model, table},
    };

    /// A command that may move at a quarter of the rate that the actuator reaches, and a line that nothing commands.
    #[test]
    fn a_low_limit_of_the_rate_of_the_command_is_named_beside_chatter() {
        let actuator =
            table().iter().map(Model::from_set).find(|model| (model.base.values()[2] - 212.5).abs() < 1e-9).unwrap();
        let [k, p, omega, zeta] = actuator.base.values();
        let given = Model { base: Base::from_values([1.01 * k, p, 1.02 * omega, zeta]).unwrap(), ..actuator.clone() };
        let with = |model: &Model, effect: &str, values: &[f64]| Model {
            effects: model.effects.with(find(effect).unwrap(), values).unwrap(),
            ..model.clone()
        };
        let limited = with(&actuator, "command_rate_limit", &[78.023_474_409_178_45; 2]);
        let truth = with(&limited, "chatter", &[0.6, 38.7, 0.5]);
        let (verdict, found) = said(&given, &three_records_of(&truth, 4.0, 8.0));
        assert_eq!(verdict, Verdict::Named);
        let (effect, rates, _) = found.unwrap();
        assert_eq!(effect, "command_rate_limit");
        assert!(rates.iter().all(|rate| (rate - 78.0).abs() < 0.8), "{rates:?}");
    }
}
