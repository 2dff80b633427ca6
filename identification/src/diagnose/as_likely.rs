//! What is compared before the verdict: an adequate explanation with one that is searched further, and with simpler ones; lags that lead with others.

use super::{
    evidence::RIVAL_BIC_RANGE, fitted::Fitted, hypothesis::LAGS, search::REFINEMENT_BIC_RANGE,
    selection::StructureSelection,
};

impl StructureSelection<'_> {
    /// A delay, lag or shifted base, or the likeliest of these after those that ended early have been searched further: they are confused most.
    pub fn likeliest_of_lags(&self, found: Fitted, base: &Fitted, candidates: &mut Vec<Fitted>) -> Fitted {
        if !is_lag_or_base(&found) {
            return found;
        }
        let may_be_likelier =
            |other: &&Fitted| is_lag_or_base(other) && !other.converged && other.bic < found.bic + REFINEMENT_BIC_RANGE;
        let early: Vec<Fitted> = candidates.iter().filter(may_be_likelier).cloned().collect();
        let refined: Vec<Fitted> = early.into_iter().map(|other| self.refined(other)).collect();
        let is_better = |other: &&Fitted| {
            other.bic < found.bic && self.is_significant(other, base) && self.is_adequate(Some(other), base)
        };
        let best = refined.iter().filter(is_better).min_by(|one, other| one.bic.total_cmp(&other.bic)).cloned();
        candidates.extend(refined);
        match best {
            Some(best) => {
                candidates.push(found);
                best
            }
            None => found,
        }
    }

    /// An adequate explanation, or another adequate one with fewer parameters that leaves no more on the fit and on the check records: it is less likely
    /// only because the noise beside it is whitened in another way.
    pub fn simpler_that_leaves_no_more(&self, found: Fitted, base: &Fitted, candidates: &[Fitted]) -> Fitted {
        let has_terms = |fitted: &Fitted| fitted.space.terms().next().is_some();
        if has_terms(&found) {
            return found;
        }
        let Some(left) = found.on(&self.check).map(|there| there.rms()) else { return found };
        let is_simpler = |other: &&Fitted| {
            !has_terms(other)
                && other.space.parameters() < found.space.parameters()
                && other.rms() <= found.rms()
                && other.on(&self.check).is_some_and(|there| there.rms() <= left)
                && self.is_significant(other, base)
                && self.is_adequate(Some(other), base)
        };
        let simpler = candidates.iter().filter(is_simpler).min_by(|one, other| one.bic.total_cmp(&other.bic));
        simpler.cloned().unwrap_or(found)
    }

    /// Delays, lags and shifted bases among the candidates that are as likely as one that leads, and predict the check records as well.
    pub fn lags_as_likely(&self, lead: &Fitted, candidates: &[Fitted]) -> Vec<String> {
        let is_as_likely = |other: &&Fitted| {
            is_lag_or_base(other)
                && other.space.hypothesis.effects != lead.space.hypothesis.effects
                && other.bic < lead.bic + RIVAL_BIC_RANGE
                && self.matches_on_hold_out(other, lead)
        };
        candidates.iter().filter(is_as_likely).map(|other| other.space.hypothesis.name()).collect()
    }
}

/// Whether it is a delay, a lag or a shifted base alone.
pub fn is_lag_or_base(fitted: &Fitted) -> bool {
    let hypothesis = &fitted.space.hypothesis;
    match hypothesis.effects.as_slice() {
        [] => hypothesis.base_free,
        [only] => LAGS.contains(only),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{
            fitted::SearchEffort,
            hypothesis::{Hypothesis, SENSOR_LAG},
            measured_noise::MeasuredNoise,
            space::{STRUCTURAL_MODE, Space},
            three_records::three_records_of,
        },
        progress::Work,
        signal::record::Record,
    };
    use actuator_fmu::{
        effects::{Effects, find},
        parameters::{Base, Model, table},
    };

    fn with(given: &Model, effect: &str, values: &[f64]) -> Model {
        Model { effects: Effects::default().with(find(effect).unwrap(), values).unwrap(), ..given.clone() }
    }

    /// What is made of a selection on records of an actuator.
    fn selected<T>(given: &Model, truth: &Model, of: impl Fn(&StructureSelection<'_>) -> T) -> T {
        let records = three_records_of(truth, 3.0, 6.0);
        let (fit, check) = records.split_at(2);
        let noise = MeasuredNoise::of(&records.iter().collect::<Vec<&Record>>(), &[]);
        let work = Work::new(Vec::new(), None);
        of(&StructureSelection::new(given, fit, check, noise, None, &work))
    }

    fn beside_free_base(effect: &'static str, start: &Model, given: &Model) -> Space {
        let hypothesis = Hypothesis { effects: vec![effect], base_free: true, ..Hypothesis::default() };
        Space::new(hypothesis, start, &given.base, 0.0)
    }

    #[test]
    fn a_lag_of_the_sensor_whose_search_ended_early_replaces_a_shifted_base() {
        // A pole as slow as the lag: one of both does not imitate the two.
        let fast = Model::from_set(&table()[0]);
        let [k, _, omega, zeta] = fast.base.values();
        let given = Model { base: Base::from_values([k, 300.0, omega, zeta]).unwrap(), ..fast };
        let found = selected(&given, &with(&given, SENSOR_LAG, &[0.003]), |selection| {
            let base = selection.fit(Hypothesis::default(), &given).unwrap();
            let free = Hypothesis { base_free: true, pole_free: true, ..Hypothesis::default() };
            let shifted = selection.fit(free, &given).unwrap();
            let start = beside_free_base(SENSOR_LAG, &with(&given, SENSOR_LAG, &[0.002]), &given);
            let early = Fitted { converged: false, ..Fitted::at_start(start, &selection.fit).unwrap() };
            let early = Fitted { bic: shifted.bic + 0.9 * REFINEMENT_BIC_RANGE, ..early };
            selection.likeliest_of_lags(shifted, &base, &mut vec![early])
        });
        let lag = found.model.effects.active_values_of(SENSOR_LAG).map_or(0.0, |values| values[0]);
        assert!((lag / 0.003 - 1.0).abs() < 0.05, "{lag}");
    }

    #[test]
    fn a_delay_replaces_a_mode_that_leaves_more_with_more_parameters() {
        let given = Model::from_set(&table()[0]);
        let chosen = |truth: &Model| {
            selected(&given, truth, |selection| {
                let base = selection.fit(Hypothesis::default(), &given).unwrap();
                let fitted = |effect: &'static str, values: &[f64]| {
                    let space = beside_free_base(effect, &with(&given, effect, values), &given);
                    Fitted::search(space, &selection.fit, SearchEffort::Full).unwrap()
                };
                let mode = fitted(STRUCTURAL_MODE, &[8.0, 0.03, 0.05]);
                let delay = fitted("delay", &[0.005]);
                selection.simpler_that_leaves_no_more(mode, &base, &[delay]).space.hypothesis.effects
            })
        };
        assert_eq!(chosen(&with(&given, "delay", &[0.01])), ["delay"]);
        assert_eq!(chosen(&with(&given, STRUCTURAL_MODE, &[8.0, 0.03, 0.2])), [STRUCTURAL_MODE]);
    }
}
