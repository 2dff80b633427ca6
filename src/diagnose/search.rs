//! The search for an explanation: what earns its place, one effect after another, and wider where that leads nowhere.

use super::{
    BEAM, CHECK_GAIN, MARGIN, MOST_EFFECTS, Study, WIDE_BEAM, adequacy,
    adequacy::Misfit,
    candidates::{restart, with_any_one_more, with_base_given, with_one_more, with_one_more_term},
    fitted::{Care, Fitted},
    space::{Hypothesis, Space},
    trace::Trace,
    verdict,
};
use crate::effects::find;

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

    /// Whether records that it was not fitted to confirm an effect. Records on which both predict the same can confirm nothing:
    /// then they must not contradict, and the fitted records have to speak all the louder.
    pub(super) fn gains_on_check(&self, richer: &Fitted, poorer: &Fitted) -> bool {
        const LOUD: f64 = 3.0 * MARGIN;
        // The bases of the two were fitted apart, and differ by as much.
        const CONTRADICTED: f64 = 2.5 * CHECK_GAIN;
        let (Some(there), Some(without)) = (richer.on(&self.check), poorer.on(&self.check)) else { return false };
        let gain = there.chi_square_below(&without, &self.check).min(there.local_gain(&without));
        let silent =
            self.without_what_is_added(richer, poorer).is_some_and(|bare| there.distance(&bare) < 2.0 * CHECK_GAIN);
        gain > CHECK_GAIN || (silent && gain > -CONTRADICTED && richer.bic + LOUD < poorer.bic)
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
        let x = space.start();
        Fitted::at(space, x, &self.check)
    }

    pub(super) fn is_as_good_on_check(&self, rival: &Fitted, best: &Fitted) -> bool {
        match (rival.on(&self.check), best.on(&self.check)) {
            (Some(rival), Some(best)) => rival.chi_square_below(&best, &self.check) > -CHECK_GAIN,
            _ => false,
        }
    }

    /// More effects one at a time, then without those that the others have made needless.
    pub(super) fn grow(&self, best: Fitted, candidates: &mut Vec<Fitted>) -> Option<Fitted> {
        let mut best = self.refined(best);
        while best.space.hypothesis.effects.len() < MOST_EFFECTS {
            // What does not know the motion does not show in the misfit.
            let more = if self.misfit(&best)?.is_more_than_chance() {
                with_one_more(&best, self.given, &self.fit)
            } else {
                with_one_more_term(&best, self.given, &self.fit)
            };
            let Some(richer) = more.first().filter(|richer| self.gains(richer, &best)) else { break };
            best = self.refined(richer.clone());
            candidates.extend(more.into_iter().take(BEAM));
        }
        let best = self.without_needless(best, candidates);
        candidates.push(best.clone());
        Some(best)
    }

    /// Where one effect after another leads to no adequate explanation: pairs that begin with any of the best single ones, all of which
    /// are searched for in earnest.
    pub(super) fn search_wider(
        &self,
        bases: [&Fitted; 2],
        current: &Fitted,
        candidates: &mut Vec<Fitted>,
    ) -> Option<Fitted> {
        let mut starts: Vec<Fitted> =
            bases.into_iter().flat_map(|base| with_any_one_more(base, self.given, &self.fit)).collect();
        starts.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let mut seen = std::collections::BTreeSet::new();
        starts.retain(|start| seen.insert(verdict::name(start)));
        let enough = starts
            .iter()
            .find(|single| self.gains(single, current) && self.misfit(single).is_some_and(|misfit| misfit.is_noise()));
        if let Some(single) = enough.cloned() {
            candidates.extend(starts);
            return self.grow(single, candidates);
        }
        let pairs = starts.iter().take(WIDE_BEAM).flat_map(|start| {
            with_one_more(start, self.given, &self.fit).into_iter().take(BEAM).collect::<Vec<Fitted>>()
        });
        let mut pairs: Vec<Fitted> = pairs.collect();
        pairs.sort_by(|a, b| a.bic.total_cmp(&b.bic));
        let better = starts.iter().chain(&pairs).filter(|other| self.gains(other, current));
        let better = better.min_by(|a, b| a.bic.total_cmp(&b.bic)).cloned();
        candidates.extend(starts);
        candidates.extend(pairs);
        self.grow(better?, candidates)
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

    pub(super) fn refined(&self, fitted: Fitted) -> Fitted {
        let space = restart(&fitted);
        Fitted::search(space, &self.fit, Care::Fine).filter(|fine| fine.bic <= fitted.bic).unwrap_or(fitted)
    }

    pub(super) fn misfit(&self, fitted: &Fitted) -> Option<Misfit> {
        let checked = fitted.on(&self.check)?;
        Some(adequacy::misfit(fitted, &self.fit).or(adequacy::misfit(&checked, &self.check)))
    }

    /// A limit that acts is seen directly, whatever else is not known: the motion stops at it. It is named where it closes most of
    /// the gap, nothing of another family comes near, and unseen records do not contradict.
    pub(super) fn limit_that_shows<'b>(&self, base: &Fitted, candidates: &'b [Fitted]) -> Option<&'b Fitted> {
        // Of the variance of the gap.
        const MOST_OF_THE_GAP: f64 = 0.5;
        const NOTHING_NEAR: f64 = 0.5;
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
                && next < NOTHING_NEAR * own
                && !contradicted
                && self.fit.iter().map(acts).fold(0.0, f64::max) > LEAST_TIME
        })
    }
}

#[allow(clippy::cast_precision_loss)] // counts of samples
fn share(of: &[bool]) -> f64 {
    of.iter().filter(|yes| **yes).count() as f64 / of.len().max(1) as f64
}
