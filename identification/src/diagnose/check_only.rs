//! A difference that shows only in a record that was held back for the check: what would close it there.
//!
//! The fitted records cannot tell such an effect, and the check record may not choose what is named. It is searched by itself beside the
//! explanation of the fitted records, and said as a suspicion with its size.

use rayon::prelude::*;

use super::{
    diagnosis::Lead,
    fitted::Fitted,
    hypothesis::{Hypothesis, MeasurementTerm, family},
    plain_fit::{PlainFit, mean_square},
    screening::observe,
    selection::StructureSelection,
    space::Space,
    trace::Trace,
    wide::implausible,
};
use actuator_fmu::effects::{CHAIN, Effect};

/// Share of the difference's excess over the noise that a suspicion must take.
const LEAST_SHARE: f64 = 0.5;

/// Mean square on a check record over the largest of a fitted one.
const CLEARLY_MORE: f64 = 1.5;

const ITERATIONS: usize = 12;

impl StructureSelection<'_> {
    /// The suspicion for each check record on which the explanation of the fitted records leaves clearly more than on any of these.
    pub fn suspicions(&self, explanation: &Fitted) -> Vec<Lead> {
        let fitted = self.fit.len();
        let on_fitted = explanation.residuals.iter().map(|residual| mean_square(residual)).fold(0.0, f64::max);
        let of_record = |(index, trace): (usize, &Trace<'_>)| {
            let noise = self.noise.records.get(fitted + index).map_or(0.0, |noise| noise.rms * noise.rms);
            suspicion(explanation, trace, noise)
                .filter(|(without, _)| *without > CLEARLY_MORE * on_fitted)
                .map(|(_, lead)| lead)
        };
        self.check.iter().enumerate().filter_map(of_record).collect()
    }
}

/// The mean square left without it, and the suspicion.
fn suspicion(explanation: &Fitted, trace: &Trace<'_>, noise: f64) -> Option<(f64, Lead)> {
    let alone = [trace.clone()];
    let hypothesis = Hypothesis { wide: true, ..Hypothesis::default() };
    let space = Space::new(hypothesis.clone(), &explanation.model, explanation.space.given(), 0.0);
    let without = PlainFit::at(space, Vec::new(), &alone)?;
    let excess = without.mean_square() - noise;
    let observed = observe(&explanation.model, &without.residuals, &alone);
    let admissible = |effect: &&&Effect| {
        let is_active = explanation.model.effects.active_values_of(effect.name).is_some();
        !is_active && effect.name != "quantisation" && MeasurementTerm::of(effect.name).is_none()
    };
    let fit_one = |effect: &&'static Effect| -> Option<PlainFit> {
        let hypothesis = Hypothesis { effects: vec![effect.name], ..hypothesis.clone() };
        let starts = (effect.start_values)(&observed).into_iter().filter_map(|values| {
            let mut model = explanation.model.clone();
            model.effects = model.effects.with(effect, &values).ok()?;
            let space = Space::new(hypothesis.clone(), &model, explanation.space.given(), 0.0);
            PlainFit::at(space.clone(), space.start(), &alone)
        });
        let best = starts.min_by(|a, b| a.mean_square().total_cmp(&b.mean_square()))?;
        PlainFit::search_from(best.space.clone(), &best.x, &alone, ITERATIONS)
    };
    let effects: Vec<&'static Effect> = CHAIN.iter().filter(admissible).copied().collect();
    let fits: Vec<PlainFit> = effects.par_iter().filter_map(fit_one).collect();
    let best = fits
        .into_iter()
        .filter(|fit| implausible(fit).is_none())
        .min_by(|a, b| a.mean_square().total_cmp(&b.mean_square()))?;
    let share = 1.0 - (best.mean_square() - noise) / excess.max(f64::MIN_POSITIVE);
    if excess <= 0.0 || share < LEAST_SHARE {
        return None;
    }
    let name = best.space.hypothesis.effects[0];
    let effect = effects.iter().find(|effect| effect.name == name)?;
    let parameters = effect.parameters.iter().map(|parameter| parameter.name);
    let lead = Lead {
        name,
        family: family(name),
        share: Some(share),
        nonlinear_share: None,
        check_rms: Some(best.mean_square().sqrt()),
        parameters: parameters.zip(best.model.effects.values_of(name)?.iter().copied()).collect(),
        why_not: format!(
            "it shows only in the check record {}: record another one like it and fit it",
            trace.record.source().display()
        ),
    };
    Some((without.mean_square(), lead))
}
