//! Forms of a lead: the same effect beside several bases, fitted to the fit records.

use super::{
    fitted::Fitted, hypothesis::Hypothesis, plain_fit::PlainFit, selection::StructureSelection, space::Space, wide,
};
use actuator_fmu::{effects::find, parameters::Model};

/// Iterations of the refit of a lead.
pub const LEAD_ITERATIONS: usize = 12;

impl StructureSelection<'_> {
    /// The forms of a lead in order of preference: beside its own free base and beside the given one; beside its own free base without levels, as the
    /// FMU is stepped, and with one that all records share; and its effect in the given model as it is. None where its own base diverges; other forms
    /// that do are left out.
    pub fn forms_of_lead(&self, lead: &PlainFit) -> Option<Vec<Fitted>> {
        let (own, mut forms) = self.lead_on_fitted_records(lead)?;
        let stepped = PlainFit::search_from(own.space.clone().without_levels(), &own.x, &self.fit, LEAD_ITERATIONS);
        let unchanged = self.in_given_model(&own).and_then(|space| PlainFit::at_start(space, &self.fit));
        let others = [stepped, self.with_common_level(&own), unchanged];
        forms.extend(others.into_iter().flatten().filter_map(|form| self.by_likelihood(form)));
        Some(forms)
    }

    /// A lead beside its own free base with a bias of the sensor that all records share, unless the given model has one: a base of another structure
    /// may hold the position away from its command.
    #[allow(clippy::cast_precision_loss)] // a count of samples
    fn with_common_level(&self, own: &PlainFit) -> Option<PlainFit> {
        let bias = find("sensor_bias").filter(|bias| self.given.effects.active_values_of(bias.name).is_none())?;
        let left = PlainFit::as_it_is(&own.model, &self.fit)?.residuals.concat();
        let offset = left.iter().sum::<f64>() / left.len().max(1) as f64;
        let start = Model { effects: own.model.effects.with(bias, &[offset, 0.0]).ok()?, ..own.model.clone() };
        let space = Space::new(own.space.hypothesis.clone(), &start, &self.given.base, 0.0).without_levels();
        PlainFit::search_from(space.clone(), &space.start(), &self.fit, LEAD_ITERATIONS)
    }

    /// A fit of all records refitted to the fit records, so that the check records stay unseen; and its forms beside its own base and beside the
    /// given one, those that do not diverge, the one with the better fit first. None where the former diverges.
    pub fn lead_on_fitted_records(&self, lead: &PlainFit) -> Option<(PlainFit, Vec<Fitted>)> {
        let own = PlainFit::search_from(lead.space.clone(), &lead.x, &self.fit, LEAD_ITERATIONS)?;
        let beside_given =
            self.in_given_model(&own).and_then(|space| PlainFit::search(space, &self.fit, LEAD_ITERATIONS));
        // Twice the negative log-likelihood with a variance in each record, so that a quiet record counts as much as a loud one; without levels, as
        // the FMU is evaluated.
        let deviance = |fit: &PlainFit| {
            let left = PlainFit::as_it_is(&fit.model, &self.fit)?.mean_squares();
            Some(left.iter().map(|square| square.max(f64::MIN_POSITIVE).ln()).sum::<f64>())
        };
        let deviances = beside_given.as_ref().and_then(deviance).zip(deviance(&own));
        let mut forms = vec![self.by_likelihood(own.clone())];
        forms.push(beside_given.and_then(|fit| self.by_likelihood(fit)));
        if deviances.is_some_and(|(beside_given, own)| beside_given < own) {
            forms.reverse();
        }
        Some((own, forms.into_iter().flatten().collect()))
    }

    /// The effect of an explanation in the given model, its parameters free.
    fn in_given_model(&self, lead: &PlainFit) -> Option<Space> {
        let hypothesis = Hypothesis { base_free: false, ..lead.space.hypothesis.clone() };
        let effect = find(wide::effect_of(lead))?;
        let values = lead.model.effects.values_of(effect.name)?;
        let start = Model { effects: self.given.effects.with(effect, values).ok()?, ..self.given.clone() };
        Some(Space::new(hypothesis, &start, &self.given.base, 0.0))
    }

    /// A form of a lead found on parts of these records, refitted to the whole ones.
    pub fn refitted_lead(&self, form: &Fitted) -> Option<Fitted> {
        self.by_likelihood(PlainFit::search_from(form.space.clone(), &form.x, &self.fit, LEAD_ITERATIONS)?)
    }

    /// A plain fit as it is, with the noise of the records estimated.
    pub fn by_likelihood(&self, fit: PlainFit) -> Option<Fitted> {
        let fitted = Fitted::at(fit.space, fit.x, &self.fit)?;
        Some(Fitted { converged: fit.converged, ..fitted })
    }
}
