//! Friction and play with which the given model may have been fitted: its base then contains their lag.

use super::{
    hypothesis::Hypothesis,
    plain_fit::PlainFit,
    space::Space,
    trace::Trace,
    unseen::{Judged, excess, sample_counts, unseen},
    wide::effect_of,
};
use actuator_fmu::{effects::find, parameters::Model};

/// Excess of such an effect in the given model, its base held, over that of the given model, above which the note is given.
const LEFT_WHERE_HELD: f64 = 0.9;

/// Iterations of a fit of an effect in the given model.
const ITERATIONS: usize = 12;

/// Excess on unseen records of the effect of a fit in the given model, its base held, over that of the given model, both about the levels.
pub fn left_in_given(given: &Model, fit: &PlainFit, traces: &[Trace<'_>], noise: &[f64]) -> Option<f64> {
    let effect = find(effect_of(fit))?;
    let without = PlainFit::beside_levels(given, traces)?;
    let effects = given.effects.with(effect, fit.model.effects.values_of(effect.name)?).ok()?;
    let start = Model { effects, ..given.clone() };
    let hypothesis = Hypothesis { effects: vec![effect.name], wide: true, ..Hypothesis::default() };
    let space = Space::new(hypothesis, &start, &given.base, 0.0);
    let (left, _) = unseen(&PlainFit::search(space, traces, ITERATIONS)?, traces)?;
    let counts = sample_counts(&without);
    Some(excess(&left, noise, &counts) / excess(&without.mean_squares(), noise, &counts))
}

/// A note on a lead that explains nothing of the difference in the given model: it need not be new.
pub fn note(lead: &Judged) -> Option<String> {
    lead.left_in_given.filter(|left| *left > LEFT_WHERE_HELD)?;
    Some(format!(
        "{} explains hardly any of the difference in the given model (base held), which may be inaccurate or already contain its lag: it need not be \
         new. Healthy records (--reference) decide",
        lead.effect
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::three_records::three_records,
        signal::record::{rms, without_mean},
    };
    use actuator_fmu::{
        effects::Effects,
        parameters::{Order, table},
    };

    #[test]
    fn play_that_came_is_missing_in_the_model_of_before_and_not_in_one_that_was_fitted_with_it() {
        let healthy = Model { order: Order::Second, ..Model::from_set(&table()[0]) };
        let play = find("backlash").unwrap();
        let worn = Model { effects: Effects::default().with(play, &[1.0]).unwrap(), ..healthy.clone() };
        let records = three_records(&worn, 3.0);
        let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &healthy.base)).collect();
        let searched = |effects: Vec<&'static str>, start: &Model| {
            let hypothesis = Hypothesis { effects, base_free: true, wide: true, ..Hypothesis::default() };
            PlainFit::search(Space::new(hypothesis, start, &healthy.base, 0.0), &traces, 25).unwrap()
        };
        let variance = |trace: &Trace<'_>| rms(&without_mean(trace.record.position())).powi(2);
        let noise: Vec<f64> = traces.iter().map(|trace| variance(trace) * 1e-4).collect();
        let found = searched(vec![play.name], &worn);
        let left = |given: &Model| left_in_given(given, &found, &traces, &noise).unwrap();
        let fitted = searched(Vec::new(), &healthy).model;
        let [of_before, with_its_lag] = [left(&healthy), left(&fitted)];
        assert!(of_before < 0.05 && with_its_lag > 0.7, "{of_before} {with_its_lag}");
    }
}
