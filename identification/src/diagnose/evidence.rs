//! The evidence for an effect: its lead in BIC, its gain on records that were not fitted, and limits that visibly act.

use super::{
    fitted::Fitted,
    hypothesis::{Hypothesis, family},
    selection::Study,
    space::Space,
    trace::Trace,
};
use actuator_fmu::effects::find;

/// Lead in BIC that an effect must have over the model without it, and a name over its rivals. 10 is very strong evidence for one
/// comparison (A. E. Raftery, Sociol. Methodol. 25, 1995); there are some twenty.
pub const MARGIN: f64 = 14.0;

/// Rivals within this of the best explanation are named beside it.
pub const RIVAL: f64 = 12.0;

/// What an effect must gain on records that it was not fitted to: twice the logarithm of the likelihood ratio.
pub const CHECK_GAIN: f64 = 12.0;

/// A lead in BIC that needs no confirmation.
const LOUD: f64 = 3.0 * MARGIN;

impl Study<'_> {
    /// Whether an effect more is worth its price, here and on the check records.
    pub fn gains(&self, richer: &Fitted, poorer: &Fitted) -> bool {
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
    pub fn gains_on_check(&self, richer: &Fitted, poorer: &Fitted) -> bool {
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
    pub fn mends(&self, free: &Fitted, given: &Fitted) -> Option<bool> {
        Some(free.bic + LOUD < given.bic && !self.misfit(given)?.is_noise() && self.misfit(free)?.is_noise())
    }

    /// On the check records: the richer explanation with what it has more than the poorer one made neutral, all else as it is; the poorer
    /// one itself where only numbers are freed.
    pub fn without_what_is_added(&self, richer: &Fitted, poorer: &Fitted) -> Option<Fitted> {
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

    pub fn is_as_good_on_check(&self, rival: &Fitted, best: &Fitted) -> bool {
        match (rival.on(&self.check), best.on(&self.check)) {
            (Some(rival), Some(best)) => rival.chi_square_below(&best, &self.check) > -CHECK_GAIN,
            _ => false,
        }
    }

    /// A limit that acts is seen directly, whatever else is not known: the motion stops at it. It is named where it closes most of
    /// the gap, nothing of another family comes near, and unseen records do not contradict.
    pub fn limit_that_shows<'b>(&self, base: &Fitted, candidates: &'b [Fitted]) -> Option<&'b Fitted> {
        // Of the variance of the gap.
        const MOST_OF_THE_GAP: f64 = 0.5;
        // Of what the best explanation of another family leaves.
        const NOTHING_NEAR: f64 = 0.25;
        const CONTRADICTION: f64 = -0.1;
        const LEAST_TIME: f64 = 0.005;
        let closed = |fitted: &Fitted, base: &Fitted| 1.0 - (fitted.rms() / base.rms()).powi(2);
        let single = || candidates.iter().filter(|other| other.space.hypothesis.effects.len() == 1);
        let is_limit = |fitted: &&Fitted| family(fitted.space.hypothesis.effects[0]) == "limit";
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

/// Whether another explanation is as good, and not the same one with more in it.
pub fn is_rival(other: &Fitted, best: &Fitted, given: &Fitted) -> bool {
    let (here, there) = (&best.space.hypothesis, &other.space.hypothesis);
    let contains = |all: &[&str], some: &[&str]| some.iter().all(|effect| all.contains(effect));
    let same = here.effects.len() == there.effects.len() && contains(&here.effects, &there.effects);
    let richer = contains(&there.effects, &here.effects) && (there.base_free || !here.effects.is_empty());
    !same && !richer && other.bic < best.bic + RIVAL && other.bic < given.bic
}
