//! The search for an explanation: forward selection, exchange and elimination of effects, and pairs where that is not adequate.

use std::collections::BTreeSet;

use super::{
    adequacy::Misfit,
    candidates::{with_any_but, with_base_given, with_one_more, with_one_more_term, with_one_of_family},
    evidence::MARGIN,
    fitted::{Care, Fitted},
    hypothesis::Hypothesis,
    selection::Study,
    space::Space,
};
use actuator_fmu::{effects::find, parameters::Model};

/// More effects than this are not sought: with enough of them anything can be explained.
const MOST_EFFECTS: usize = 3;

/// Best hypotheses of a round that are kept.
const BEAM: usize = 3;

/// Single effects from which pairs are sought, where the best one leads nowhere.
const WIDE_BEAM: usize = 4;

/// Explanations searched for in earnest before they are passed over.
const PROMISING: usize = 3;

/// A rough search this far behind in BIC may still win when it is continued.
const DOUBT: f64 = 200.0;

/// What the search came to.
pub struct Outcome {
    pub given: Fitted,
    /// The given model, or that with its base refitted where that is better.
    pub base: Fitted,
    /// Best first.
    pub candidates: Vec<Fitted>,
    /// None where the given model needs none.
    pub explanation: Option<Fitted>,
    /// What the explanation leaves.
    pub misfit: Misfit,
    /// The explanation is named although it leaves a smaller gap.
    pub forgiven: bool,
}

impl Study<'_> {
    /// The search: base, single effects, more of them, wider where that leads nowhere.
    pub fn explain(&self) -> Option<Outcome> {
        let given = self.fit(Hypothesis::default(), self.given)?;
        let free = self.fit(Hypothesis { base_free: true, ..Hypothesis::default() }, self.given)?;
        let base = if free.bic < given.bic { &free } else { &given };
        let first = self.one_more(base);
        let mut candidates: Vec<Fitted> = vec![given.clone(), free.clone()];
        candidates.extend(first.iter().cloned());
        let earned = self.earning(&first, base);
        let mut explanation = earned.and_then(|single| self.grow(single, &mut candidates));
        if explanation.is_none() && (self.gains(&free, &given) || self.mends(&free, &given)?) {
            explanation = Some(free.clone());
        }
        let current = explanation.as_ref().unwrap_or(base);
        if !self.misfit(current)?.is_noise() || current.space.is_base_at_bound(&current.x) {
            explanation = self.search_wider(base, current, &mut candidates).or(explanation);
        }
        candidates.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let mut misfit = self.misfit(explanation.as_ref().unwrap_or(&given))?;
        let mut forgiven = false;
        if !misfit.is_noise()
            && let Some(limit) = self.limit_that_shows(base, &candidates)
        {
            misfit = self.misfit(limit)?;
            explanation = Some(limit.clone());
            forgiven = true;
        }
        let base = base.clone();
        Some(Outcome { given, base, candidates, explanation, misfit, forgiven })
    }

    /// The first of some explanations, best first, that is worth its price. A rough search may end short of where it would have been worth
    /// it: the most promising ones are searched for in earnest before they are passed over.
    pub fn earning(&self, richer: &[Fitted], poorer: &Fitted) -> Option<Fitted> {
        let promising = |place: usize, fitted: &Fitted| place < PROMISING && fitted.bic + MARGIN < poorer.bic;
        richer.iter().enumerate().find_map(|(place, fitted)| {
            if self.gains(fitted, poorer) {
                return Some(fitted.clone());
            }
            let refined = promising(place, fitted).then(|| self.refined(fitted.clone()))?;
            self.gains(&refined, poorer).then_some(refined)
        })
    }

    /// All explanations with one effect more, best first. A base that is far from the given one imitates what is missing: unless the best
    /// of them brings it back and leaves nothing, the truth may be nearer to where it was.
    pub fn one_more(&self, current: &Fitted) -> Vec<Fitted> {
        let mut more = with_one_more(current, self.given, &self.fit);
        let settles = |best: &Fitted| {
            !has_moved(&best.model, self.given)
                && self.gains(best, current)
                && self.misfit(best).is_some_and(|misfit| misfit.is_noise())
        };
        if !has_moved(&current.model, self.given) || more.first().is_some_and(settles) {
            return more;
        }
        let Some(back) = self.at_given_base(current) else { return more };
        more.extend(with_one_more(&back, self.given, &self.fit));
        best_of_each(&mut more);
        more
    }

    /// The same effects on the given base, nothing searched for.
    fn at_given_base(&self, current: &Fitted) -> Option<Fitted> {
        let model = Model { base: self.given.base, order: self.given.order, ..current.model.clone() };
        let chatter_hz = current.space.chatter_hz(&current.x);
        let space = Space::new(current.space.hypothesis.clone(), &model, &self.given.base, chatter_hz);
        Fitted::at_start(space, &self.fit)
    }

    /// More effects one at a time, each with a second thought about those before it, then without those that the others have made
    /// needless.
    pub fn grow(&self, best: Fitted, candidates: &mut Vec<Fitted>) -> Option<Fitted> {
        let mut best = self.refined(best);
        while best.space.hypothesis.effects.len() < MOST_EFFECTS {
            // What does not know the motion does not show in the misfit.
            let more = if self.misfit(&best)?.is_more_than_chance() {
                self.one_more(&best)
            } else {
                with_one_more_term(&best, self.given, &self.fit)
            };
            let Some(richer) = self.earning(&more[..more.len().min(1)], &best) else { break };
            best = self.exchanged(self.refined(richer), candidates);
            candidates.extend(more.into_iter().take(BEAM));
        }
        let best = self.without_needless(best, candidates);
        candidates.push(best.clone());
        Some(best)
    }

    /// An effect that was chosen before the others were there gives way to one of its family that does better beside them.
    fn exchanged(&self, mut best: Fitted, candidates: &mut Vec<Fitted>) -> Fitted {
        let Some((_, earlier)) =
            best.space.hypothesis.effects.clone().split_last().map(|(last, rest)| (*last, rest.to_vec()))
        else {
            return best;
        };
        for effect in earlier {
            let Some(bare) = self.without_searching(&best, effect) else { continue };
            let mut found = with_one_of_family(&bare, effect, self.given, &self.fit);
            if has_moved(&bare.model, self.given)
                && let Some(back) = self.at_given_base(&bare)
            {
                found.extend(with_one_of_family(&back, effect, self.given, &self.fit));
                best_of_each(&mut found);
            }
            if let Some(other) = found.first().filter(|other| other.bic < best.bic + DOUBT) {
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

    /// Where one effect after another leads to no adequate explanation: pairs that begin with any of the best single ones, all of which
    /// are searched for in earnest.
    pub fn search_wider(&self, base: &Fitted, current: &Fitted, candidates: &mut Vec<Fitted>) -> Option<Fitted> {
        let single = |fitted: &&Fitted| fitted.space.hypothesis.effects.len() == 1;
        let mut starts: Vec<Fitted> = candidates.iter().filter(single).cloned().collect();
        let known: Vec<&str> = starts.iter().map(|start| start.space.hypothesis.effects[0]).collect();
        starts.extend(with_any_but(&known, base, self.given, &self.fit));
        best_of_each(&mut starts);
        let enough = starts
            .iter()
            .find(|single| self.gains(single, current) && self.misfit(single).is_some_and(|misfit| misfit.is_noise()));
        if let Some(single) = enough.cloned() {
            candidates.extend(starts);
            return self.grow(single, candidates);
        }
        let pairs = starts
            .iter()
            .take(WIDE_BEAM)
            .flat_map(|start| self.one_more(start).into_iter().take(BEAM).collect::<Vec<Fitted>>());
        let mut all: Vec<Fitted> = pairs.collect();
        all.extend(starts);
        all.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let (promising, others) = all.split_at(PROMISING.min(all.len()));
        let mut promising: Vec<Fitted> = promising.iter().map(|fitted| self.refined(fitted.clone())).collect();
        promising.extend(others.iter().cloned());
        promising.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let better = promising.iter().find(|other| self.gains(other, current)).cloned();
        candidates.extend(promising);
        self.grow(better?, candidates)
    }

    /// On the fitted records: an explanation with one effect made neutral, all other numbers as they are.
    fn without_searching(&self, best: &Fitted, effect: &str) -> Option<Fitted> {
        let mut hypothesis = Hypothesis { base_free: true, ..best.space.hypothesis.clone() };
        hypothesis.effects.retain(|other| *other != effect);
        let model = Model { effects: best.model.effects.without(find(effect)?), ..best.model.clone() };
        let space = Space::new(hypothesis, &model, &self.given.base, best.space.chatter_hz(&best.x));
        Fitted::at_start(space, &self.fit)
    }

    pub fn without_needless(&self, mut best: Fitted, candidates: &mut Vec<Fitted>) -> Fitted {
        while best.space.hypothesis.effects.len() > 1 {
            let effects = best.space.hypothesis.effects.clone();
            let fewer = effects.iter().filter_map(|needless| self.without(&best, needless));
            let Some(least) = fewer.min_by(|a, b| a.bic.total_cmp(&b.bic)) else { break };
            candidates.push(least.clone());
            if self.gains(&best, &least) {
                break;
            }
            best = least;
        }
        best
    }

    pub fn without(&self, best: &Fitted, needless: &str) -> Option<Fitted> {
        let mut hypothesis = best.space.hypothesis.clone();
        hypothesis.effects.retain(|effect| *effect != needless);
        hypothesis.base_free = true;
        let effect = find(needless)?;
        let mut start = best.model.clone();
        start.effects = start.effects.without(effect);
        let space = Space::new(hypothesis, &start, &self.given.base, best.space.chatter_hz(&best.x));
        let mut found = vec![Fitted::search(space, &self.fit, Care::Rough)?];
        with_base_given(&mut found, self.given, &self.fit);
        found.pop()
    }
}

/// Of each explanation the best search, best first.
fn best_of_each(found: &mut Vec<Fitted>) {
    found.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    let mut seen = BTreeSet::new();
    found.retain(|fitted| seen.insert(fitted.space.hypothesis.name()));
}

/// Whether a search has changed any number of the base by more than the estimates of real actuators differ.
fn has_moved(free: &Model, given: &Model) -> bool {
    const FAR: f64 = 0.12;
    let pairs = free.base.values().into_iter().zip(given.base.values());
    pairs.into_iter().any(|(free, given)| (free / given).abs().ln().abs() > FAR)
}
