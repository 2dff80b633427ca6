//! The search for an explanation: what earns its place, one effect after another, and wider where that leads nowhere.

use super::{
    BEAM, CHECK_GAIN, MARGIN, MOST_EFFECTS, Study, WIDE_BEAM, adequacy,
    adequacy::Misfit,
    candidates::{restart, with_any_but, with_base_given, with_one_more, with_one_more_term, with_one_of_family},
    fitted::{Care, Fitted},
    space::{Hypothesis, Space},
    trace::Trace,
    verdict,
};
use actuator_fmu::{effects::find, parameters::Model};

/// Explanations searched for in earnest before they are passed over.
const PROMISING: usize = 3;

/// A lead in BIC that needs no confirmation.
const LOUD: f64 = 3.0 * MARGIN;

/// A rough search this far behind in BIC may still win when it is continued.
const DOUBT: f64 = 200.0;

impl Study<'_> {
    /// Whether an effect more is worth its price, here and on the check records.
    pub(super) fn gains(&self, richer: &Fitted, poorer: &Fitted) -> bool {
        #[allow(clippy::cast_precision_loss)] // counts
        let price = {
            let numbers = richer.space.parameters().saturating_sub(poorer.space.parameters()).max(1);
            // The factors of a term are free in each record, and a frequency was chosen among as many as there are samples.
            let terms = richer.space.terms().count().saturating_sub(poorer.space.terms().count());
            let free = numbers + 2 * terms * self.fit.len();
            free as f64 * (self.fit.iter().map(Trace::counted).sum::<usize>() as f64).ln()
        };
        richer.bic + MARGIN < poorer.bic
            && richer.local_gain(poorer) > MARGIN + price
            && self.gains_on_check(richer, poorer)
    }

    /// The first of some explanations, best first, that is worth its price. A rough search may end short of where it would have been worth
    /// it: the most promising ones are searched for in earnest before they are passed over.
    pub(super) fn earning(&self, richer: &[Fitted], poorer: &Fitted) -> Option<Fitted> {
        let promising = |place: usize, fitted: &Fitted| place < PROMISING && fitted.bic + MARGIN < poorer.bic;
        richer.iter().enumerate().find_map(|(place, fitted)| {
            if self.gains(fitted, poorer) {
                return Some(fitted.clone());
            }
            let refined = promising(place, fitted).then(|| self.refined(fitted.clone()))?;
            self.gains(&refined, poorer).then_some(refined)
        })
    }

    /// Whether records that it was not fitted to confirm an effect. Records on which both predict the same can confirm nothing:
    /// then they must not contradict, and the fitted records have to speak all the louder.
    pub(super) fn gains_on_check(&self, richer: &Fitted, poorer: &Fitted) -> bool {
        // The bases of the two were fitted apart, and differ by as much.
        const CONTRADICTED: f64 = 2.5 * CHECK_GAIN;
        let (Some(there), Some(without)) = (richer.on(&self.check), poorer.on(&self.check)) else { return false };
        let gain_over = |other: &Fitted| there.chi_square_below(other, &self.check).min(there.local_gain(other));
        let gain = gain_over(&without);
        if gain > CHECK_GAIN {
            return true;
        }
        // What was added hardly acts there, or does act and helps where all else is the same.
        let tolerable = self
            .without_what_is_added(richer, poorer)
            .is_some_and(|bare| there.distance(&bare) < 2.0 * CHECK_GAIN || gain_over(&bare) > CHECK_GAIN);
        tolerable && gain > -CONTRADICTED && richer.bic + LOUD < poorer.bic
    }

    /// Whether other numbers of the base leave noise where the given ones do not, though the check records do not show it by themselves.
    pub(super) fn mends(&self, free: &Fitted, given: &Fitted) -> Option<bool> {
        Some(free.bic + LOUD < given.bic && !self.misfit(given)?.is_noise() && self.misfit(free)?.is_noise())
    }

    /// On the check records: the richer explanation with what it has more than the poorer one made neutral, all else as it is; the poorer
    /// one itself where only numbers are freed.
    pub(super) fn without_what_is_added(&self, richer: &Fitted, poorer: &Fitted) -> Option<Fitted> {
        let (there, here) = (&richer.space.hypothesis.effects, &poorer.space.hypothesis.effects);
        let mut added = there.iter().filter(|effect| !here.contains(effect)).peekable();
        if added.peek().is_none() {
            return poorer.on(&self.check);
        }
        let mut model = richer.model.clone();
        for effect in added.filter_map(|name| find(name)) {
            model.effects = model.effects.without(effect);
        }
        let effects = there.iter().copied().filter(|effect| here.contains(effect)).collect();
        let hypothesis = Hypothesis { effects, base_free: false };
        let space = Space::new(hypothesis, &model, &self.given.base, richer.space.chatter_hz(&richer.x));
        Fitted::at_start(space, &self.check)
    }

    pub(super) fn is_as_good_on_check(&self, rival: &Fitted, best: &Fitted) -> bool {
        match (rival.on(&self.check), best.on(&self.check)) {
            (Some(rival), Some(best)) => rival.chi_square_below(&best, &self.check) > -CHECK_GAIN,
            _ => false,
        }
    }

    /// All explanations with one effect more, best first. A base that is far from the given one imitates what is missing: unless the best
    /// of them brings it back and leaves nothing, the truth may be nearer to where it was.
    pub(super) fn one_more(&self, current: &Fitted) -> Vec<Fitted> {
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
    pub(super) fn grow(&self, best: Fitted, candidates: &mut Vec<Fitted>) -> Option<Fitted> {
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
    pub(super) fn search_wider(&self, base: &Fitted, current: &Fitted, candidates: &mut Vec<Fitted>) -> Option<Fitted> {
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

    pub(super) fn without_needless(&self, mut best: Fitted, candidates: &mut Vec<Fitted>) -> Fitted {
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

    pub(super) fn without(&self, best: &Fitted, needless: &str) -> Option<Fitted> {
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

    /// Searched for in earnest; where that leaves a misfit, with the base free as well: the base given may have been better only than where
    /// a rough search with a free one was stuck.
    pub(super) fn refined(&self, fitted: Fitted) -> Fitted {
        let further = |fitted: Fitted, base_free: bool| {
            let fine = Fitted::search(restart(&fitted, base_free), &self.fit, Care::Fine);
            fine.filter(|fine| fine.bic <= fitted.bic).unwrap_or(fitted)
        };
        let base_free = fitted.space.hypothesis.base_free;
        let fine = further(fitted, base_free);
        if base_free || adequacy::misfit(&fine, &self.fit).is_noise() { fine } else { further(fine, true) }
    }

    /// On the fitted records, and on the others with what the fitted ones leave open of the numbers.
    pub(super) fn misfit(&self, fitted: &Fitted) -> Option<Misfit> {
        let mut there = adequacy::misfit(&fitted.on(&self.check)?, &self.check);
        if !there.is_noise()
            && let Some(reconciled) = fitted.reconciled_with(&self.check, &self.fit)
        {
            there = adequacy::misfit(&reconciled, &self.check);
        }
        Some(adequacy::misfit(fitted, &self.fit).or(there))
    }

    /// A limit that acts is seen directly, whatever else is not known: the motion stops at it. It is named where it closes most of
    /// the gap, nothing of another family comes near, and unseen records do not contradict.
    pub(super) fn limit_that_shows<'b>(&self, base: &Fitted, candidates: &'b [Fitted]) -> Option<&'b Fitted> {
        // Of the variance of the gap.
        const MOST_OF_THE_GAP: f64 = 0.5;
        // Of what the best explanation of another family leaves.
        const NOTHING_NEAR: f64 = 0.25;
        const CONTRADICTION: f64 = -0.1;
        const LEAST_TIME: f64 = 0.005;
        let closed = |fitted: &Fitted, base: &Fitted| 1.0 - (fitted.rms() / base.rms()).powi(2);
        let single = || candidates.iter().filter(|other| other.space.hypothesis.effects.len() == 1);
        let is_limit = |fitted: &&Fitted| verdict::family(fitted.space.hypothesis.effects[0]) == "limit";
        let next = single().filter(|other| !is_limit(other)).map(|other| closed(other, base)).fold(0.0, f64::max);
        let unseen = base.on(&self.check)?;
        single().filter(is_limit).find(|limit| {
            let acts = |trace: &Trace<'_>| trace.motion(&limit.model).map_or(0.0, |motion| share(&motion.saturated));
            let own = closed(limit, base);
            let contradicted = limit.on(&self.check).is_none_or(|checked| closed(&checked, &unseen) < CONTRADICTION);
            own > MOST_OF_THE_GAP
                && 1.0 - own < NOTHING_NEAR * (1.0 - next)
                && !contradicted
                && self.fit.iter().map(acts).fold(0.0, f64::max) > LEAST_TIME
        })
    }
}

#[allow(clippy::cast_precision_loss)] // counts of samples
fn share(of: &[bool]) -> f64 {
    of.iter().filter(|yes| **yes).count() as f64 / of.len().max(1) as f64
}

/// Of each explanation the best search, best first.
fn best_of_each(found: &mut Vec<Fitted>) {
    found.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    let mut seen = std::collections::BTreeSet::new();
    found.retain(|fitted| seen.insert(verdict::name(fitted)));
}

/// Whether a search has changed any number of the base by more than the estimates of real actuators differ.
fn has_moved(free: &Model, given: &Model) -> bool {
    const FAR: f64 = 0.12;
    let pairs = free.base.values().into_iter().zip(given.base.values());
    pairs.into_iter().any(|(free, given)| (free / given).abs().ln().abs() > FAR)
}
