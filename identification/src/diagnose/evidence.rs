//! The evidence for an effect: BIC difference and hold-out gain; and whether another hypothesis is as good.

use super::{
    fitted::Fitted, given_effects::changeable, hypothesis::Hypothesis, selection::StructureSelection, space::Space,
    trace::Trace,
};
use crate::inspect::deviation;
use actuator_fmu::effects::find;

/// BIC difference by which an effect must be better than the model without it, and a name better than its rivals. 10 is very strong evidence for one
/// comparison (A. E. Raftery, Sociol. Methodol. 25, 1995); there are some twenty.
pub const REQUIRED_BIC_LEAD: f64 = 14.0;

/// Rivals within this BIC of the best hypothesis are listed with it.
pub const RIVAL_BIC_RANGE: f64 = 12.0;

/// Required hold-out gain of an effect: twice the log-likelihood ratio on the check records.
pub const REQUIRED_HOLD_OUT_GAIN: f64 = 12.0;

/// Factor between p and the given p above which a pole counts as moved.
pub const MOVED_POLE: f64 = 1.5;

/// BIC difference that needs no confirmation by the check records.
const CONCLUSIVE_BIC_LEAD: f64 = 3.0 * REQUIRED_BIC_LEAD;

/// Rms about the levels with a lead over that without it, below which the fit records show it clearly.
const CLEAR_FALL: f64 = 0.8;

impl StructureSelection<'_> {
    /// Whether an effect is significant, on the fit and on the check records.
    pub fn is_significant(&self, richer: &Fitted, poorer: &Fitted) -> bool {
        #[allow(clippy::cast_precision_loss)] // counts
        let penalty = {
            let numbers = richer.space.parameters().saturating_sub(poorer.space.parameters()).max(1);
            // The factors of a term are free in each record, and a frequency was chosen among as many as there are samples.
            let terms = richer.space.terms().count().saturating_sub(poorer.space.terms().count());
            let free = numbers + 2 * terms * self.fit.len();
            free as f64 * (self.fit.iter().map(Trace::evaluated_samples).sum::<usize>() as f64).ln()
        };
        richer.bic + REQUIRED_BIC_LEAD < poorer.bic
            && richer.whittle_gain(poorer) > REQUIRED_BIC_LEAD + penalty
            && self.is_confirmed_on_hold_out(richer, poorer)
    }

    /// Whether the check records confirm an effect. Where both hypotheses predict them alike, they cannot confirm it: they must then not contradict
    /// it, and the BIC difference on the fit records must be conclusive.
    pub fn is_confirmed_on_hold_out(&self, richer: &Fitted, poorer: &Fitted) -> bool {
        // The bases of the two were fitted separately and may differ by as much.
        const TOLERATED_LOSS: f64 = 2.5 * REQUIRED_HOLD_OUT_GAIN;
        let (Some(there), Some(without)) = (richer.on(&self.check), poorer.on(&self.check)) else { return false };
        let gain_over = |other: &Fitted| there.log_likelihood_gain(other, &self.check).min(there.whittle_gain(other));
        let gain = gain_over(&without);
        if gain > REQUIRED_HOLD_OUT_GAIN {
            return true;
        }
        // The added effect hardly acts there, or it improves the prediction with all else equal.
        let tolerable = self.without_added_effects(richer, poorer).is_some_and(|bare| {
            there.expected_gain(&bare) < 2.0 * REQUIRED_HOLD_OUT_GAIN || gain_over(&bare) > REQUIRED_HOLD_OUT_GAIN
        });
        tolerable && gain > -TOLERATED_LOSS && richer.bic + CONCLUSIVE_BIC_LEAD < poorer.bic
    }

    /// Whether a shift of the base alone makes the model adequate, though the check records do not confirm it by themselves.
    pub fn base_shift_suffices(&self, free: &Fitted, given: &Fitted) -> Option<bool> {
        Some(
            free.bic + CONCLUSIVE_BIC_LEAD < given.bic
                && !self.misfit(given)?.is_noise()
                && self.misfit(free)?.is_noise(),
        )
    }

    /// The richer hypothesis on the check records, with the effects that the poorer one lacks set to neutral and all else unchanged; the poorer one
    /// itself where only parameters are freed.
    pub fn without_added_effects(&self, richer: &Fitted, poorer: &Fitted) -> Option<Fitted> {
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
        let hypothesis = Hypothesis { effects, ..Hypothesis::default() };
        let space = Space::new(hypothesis, &model, &self.given.base, richer.space.chatter_hz(&richer.x));
        Fitted::at_start(space, &self.check)
    }

    /// Whether a rival predicts the check records as well.
    pub fn matches_on_hold_out(&self, rival: &Fitted, best: &Fitted) -> bool {
        match (rival.on(&self.check), best.on(&self.check)) {
            (Some(rival), Some(best)) => rival.log_likelihood_gain(&best, &self.check) > -REQUIRED_HOLD_OUT_GAIN,
            _ => false,
        }
    }
}

/// Whether another hypothesis is as good, and not the same one with more effects.
pub fn is_rival(other: &Fitted, best: &Fitted, given: &Fitted) -> bool {
    let (here, there) = (&best.space.hypothesis, &other.space.hypothesis);
    let contains = |all: &[&str], some: &[&str]| some.iter().all(|effect| all.contains(effect));
    let same = here.effects.len() == there.effects.len() && contains(&here.effects, &there.effects);
    // Effects of the given model are free beside a free base.
    let of_given = changeable(&given.model).map(|effect| effect.name).filter(|_| there.base_free);
    let free_there: Vec<&str> = there.effects.iter().copied().chain(of_given).collect();
    let richer = contains(&free_there, &here.effects)
        && (there.base_free || !here.effects.is_empty())
        && !is_lag_of_moved_pole(other, best, given);
    !same && !richer && other.bic < best.bic + RIVAL_BIC_RANGE && other.bic < given.bic
}

/// Whether the other hypothesis has a lag in place of a pole that the best one has moved far, with no more parameters: the motion does not
/// distinguish them.
fn is_lag_of_moved_pole(other: &Fitted, best: &Fitted, given: &Fitted) -> bool {
    let pole = |fitted: &Fitted| fitted.model.base.p().ln();
    best.space.hypothesis.pole_free
        && other.space.hypothesis.lag().is_some()
        && (pole(best) - pole(given)).abs() > MOVED_POLE.ln()
        && other.space.parameters() <= best.space.parameters()
}

/// Whether a lead clearly reduces the residual of the fit records about the levels.
pub fn shows_clearly(lead: &Fitted, without: &Fitted) -> bool {
    pooled_deviation(&lead.residuals) < CLEAR_FALL * pooled_deviation(&without.residuals)
}

/// Root mean square of several columns together, each about its own mean.
#[allow(clippy::cast_precision_loss)] // counts of samples
pub fn pooled_deviation(columns: &[Vec<f64>]) -> f64 {
    let count: usize = columns.iter().map(Vec::len).sum();
    let sum: f64 = columns.iter().map(|column| column.len() as f64 * deviation(column).powi(2)).sum();
    (sum / count.max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::pooled_deviation;

    #[test]
    fn a_level_of_each_record_is_no_deviation() {
        let about = |level: f64| [1.0, -1.0, 1.0, -1.0].map(|value| value + level).to_vec();
        assert!((pooled_deviation(&[about(3.0), about(-7.0)]) - 1.0).abs() < 1e-12);
        // Longer records count for more.
        assert!((pooled_deviation(&[about(5.0), vec![2.0; 12]]) - 0.5).abs() < 1e-12);
    }
}
