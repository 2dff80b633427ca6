//! Whether records tell an effect's numbers: those that its base can take over are any.

use super::{
    fitted::Fitted, hypothesis::MeasurementTerm, selection::StructureSelection, space::ParameterIndex, trace::Trace,
};
use actuator_fmu::effects::Effects;

/// Standard errors by which a number of an effect differs from none at least.
const LEAST_DEVIATIONS: f64 = 2.3;

impl StructureSelection<'_> {
    /// Whether the records to fit tell each effect that an explanation adds to the given model.
    pub fn are_identified(&self, found: &Fitted) -> bool {
        let mut added = found.space.hypothesis.effects.iter();
        added.all(|effect| {
            MeasurementTerm::of(effect).is_some() || self.is_given(effect) || is_identified(found, effect, &self.fit)
        })
    }
}

/// Whether a number of an effect differs from none by more than chance. Of what a free base imitates, as a stiffness of the load, each number is any: its
/// error is as large.
fn is_identified(found: &Fitted, name: &str, traces: &[Trace<'_>]) -> bool {
    let Some(covariance) = found.covariance(traces) else { return true };
    let values = found.model.effects.values();
    let mut parameters = Effects::parameters().enumerate().filter(|(_, (effect, _))| effect.name == name);
    parameters.any(|(index, (_, parameter))| {
        let error = found.std_error(Some(&covariance), ParameterIndex::Effect(index));
        error.is_some_and(|error| (values[index] - parameter.neutral).abs() > LEAST_DEVIATIONS * error)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{hypothesis::Hypothesis, space::Space, three_records::three_records_of},
        signal::record::Record,
    };
    use actuator_fmu::{
        effects::find,
        parameters::{Base, Model, Order, table},
    };

    /// k, ω² and ζ of a stiffer load are those of another base: 1 + s is taken from k and added to ω².
    #[test]
    fn a_stiffness_beside_a_free_base_is_any_and_beside_the_given_one_it_is_told() {
        let [k, p, omega, zeta] = table()[0].base.values();
        let base = Base::from_values([k, p, omega, zeta]).unwrap();
        let given = Model { order: Order::Second, base, ..Model::from_set(&table()[0]) };
        let effects = given.effects.with(find("hinge_load").unwrap(), &[0.0, 0.2]).unwrap();
        let loaded = Model { effects, ..given.clone() };
        let records: Vec<Record> = three_records_of(&loaded, 3.0, 6.0);
        let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &given.base)).collect();
        let told = |base_free: bool| {
            let hypothesis = Hypothesis { effects: vec!["hinge_load"], base_free, ..Hypothesis::default() };
            let at = Fitted::at_start(Space::new(hypothesis, &loaded, &given.base, 0.0), &traces).unwrap();
            is_identified(&at, "hinge_load", &traces)
        };
        assert!(told(false) && !told(true));
    }
}
