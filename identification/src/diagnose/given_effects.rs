//! Effects that a given model has, whose strength may have changed.

use super::hypothesis::{DELAY, MeasurementTerm};
use actuator_fmu::{
    effects::{Effect, Effects},
    parameters::Model,
};

/// Effects of a model whose strength may have changed.
pub fn changeable(model: &Model) -> impl Iterator<Item = &'static Effect> + '_ {
    let active = model.effects.active().map(|(effect, _)| effect);
    active.filter(|effect| effect.name != "quantisation" && MeasurementTerm::of(effect.name).is_none())
}

/// Effects, some of them with their strengths in a given model.
pub fn with_strengths_of(given: &Model, some: impl Iterator<Item = &'static Effect>, effects: Effects) -> Effects {
    some.fold(effects, |effects, effect| {
        let values = given.effects.values_of(effect.name).unwrap_or_default();
        effects.with(effect, values).unwrap_or(effects)
    })
}

/// Delay of a model [s].
pub fn delay_s(model: &Model) -> f64 {
    model.effects.active_values_of(DELAY).map_or(0.0, |values| values[0])
}
