//! Forms of a lead: the same effect beside several bases, fitted to the fit records.

use super::{
    fitted::Fitted,
    given_effects::delay_s,
    hypothesis::{DELAY, Hypothesis},
    plain_fit::PlainFit,
    selection::StructureSelection,
    space::Space,
    wide,
};
use actuator_fmu::{
    effects::find,
    parameters::{Base, Model},
};

/// Iterations of the refit of a lead.
pub const LEAD_ITERATIONS: usize = 12;

impl StructureSelection<'_> {
    /// A lead beside its own free base, refitted to the fit records, and its forms in order of preference: beside its own free base and beside the
    /// given one; beside its own free base without levels, as the FMU is stepped, and with one that all records share; and its effect in the given
    /// model as it is. None where its own base diverges; other forms that do are left out.
    pub fn forms_of_lead(&self, lead: &PlainFit) -> Option<(PlainFit, Vec<Fitted>)> {
        let (own, mut forms) = self.lead_on_fitted_records(lead)?;
        let stepped = PlainFit::search_from(own.space.clone().without_levels(), &own.x, &self.fit, LEAD_ITERATIONS);
        let unchanged = self.in_given_model(&own).and_then(|space| PlainFit::at_start(space, &self.fit));
        let others = [stepped, self.with_common_level(&own), unchanged];
        forms.extend(others.into_iter().flatten().filter_map(|form| self.by_likelihood(form)));
        Some((own, forms))
    }

    /// A lead beside a base halfway between its own free base and the given one, in the logarithms of its parameters and in its delay. An actuator
    /// changes between sessions: a base fitted to some of them may be further from that of another session than the given one.
    pub fn halfway_to_given(&self, own: &PlainFit) -> Option<Fitted> {
        let (given, found) = (self.given.base.values(), own.model.base.values());
        let mean = |place: usize| found[place].signum() * (given[place] * found[place]).sqrt();
        let base = Base::from_values(std::array::from_fn(mean)).ok()?;
        let delay_s = 0.5 * (delay_s(self.given) + delay_s(&own.model));
        let effects = own.model.effects.with(find(DELAY)?, &[delay_s]).ok()?;
        let start = Model { base, effects, ..own.model.clone() };
        let hypothesis = Hypothesis { base_free: false, wide: false, ..own.space.hypothesis.clone() };
        let space = Space::new(hypothesis, &start, &self.given.base, 0.0);
        self.by_likelihood(PlainFit::search(space, &self.fit, LEAD_ITERATIONS)?)
    }

    /// The base of a lead without its effect, with the effects of the given model and the delay of the lead.
    pub fn without_effect(&self, lead: &Fitted) -> Option<Fitted> {
        let effects = self.given.effects.with(find(DELAY)?, &[delay_s(&lead.model)]).ok()?;
        let without = Model { effects, ..lead.model.clone() };
        self.by_likelihood(PlainFit::as_it_is(&without, &self.fit)?)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{measured_noise::MeasuredNoise, three_records::three_records_of},
        progress::Work,
        signal::record::Record,
    };
    use actuator_fmu::{effects::Effects, parameters::table};

    /// Play whose own base is that of the actuator, with one and a half times the bandwidth of the given one.
    #[test]
    fn a_lead_halfway_to_the_given_base_has_its_effect_fitted_there() {
        let given = Model::from_set(&table()[0]);
        let [k, p, omega, zeta] = given.base.values();
        let play = find("backlash").unwrap();
        let base = Base::from_values([k, p, 1.5 * omega, zeta]).unwrap();
        let truth = Model { base, effects: Effects::default().with(play, &[0.4]).unwrap(), ..given.clone() };
        let records = three_records_of(&truth, 3.0, 6.0);
        let (fit, check) = records.split_at(2);
        let noise = MeasuredNoise::of(&records.iter().collect::<Vec<&Record>>(), &[]);
        let work = Work::new(Vec::new(), None);
        let selection = StructureSelection::new(&given, fit, check, noise, None, &work);
        let hypothesis = Hypothesis { effects: vec![play.name], base_free: true, wide: true, ..Hypothesis::default() };
        let lead = PlainFit::search(Space::new(hypothesis, &truth, &given.base, 0.0), &selection.fit, 20).unwrap();
        let (own, _) = selection.forms_of_lead(&lead).unwrap();
        let halfway = selection.halfway_to_given(&own).unwrap();
        let without = selection.without_effect(&halfway).unwrap();
        assert!((halfway.model.base.omega() / (1.5_f64.sqrt() * omega) - 1.0).abs() < 0.02);
        assert_eq!((without.model.base, without.model.effects.active_values_of(play.name)), (halfway.model.base, None));
        // With the gap of the lead it would leave more.
        let unfitted = Model { effects: lead.model.effects.clone(), ..halfway.model.clone() };
        let unfitted = PlainFit::as_it_is(&unfitted, &selection.fit).unwrap().mean_square();
        assert!(halfway.rms().powi(2) < unfitted, "{} {unfitted}", halfway.rms());
    }
}
