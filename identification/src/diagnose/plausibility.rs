//! Plausible parameters of an effect: physically, and as far as records can show them.

use actuator_fmu::effects::{Effect, Effects, Parameter};

/// Whether the frequencies of an effect lie below Nyquist's: records cannot show others.
pub fn is_sampled(effect: &Effect, values: &[f64], interval_s: f64) -> bool {
    let frequencies = effect.parameters.iter().zip(values).filter(|(parameter, _)| parameter.unit == "Hz");
    frequencies.into_iter().all(|(_, frequency_hz)| *frequency_hz < 0.5 / interval_s)
}

/// Whether fitted values are physically plausible for the effect.
pub fn is_plausible(effect: &Effect, effects: &Effects) -> bool {
    let Some(values) = effects.values_of(effect.name) else { return true };
    let within = |(parameter, value): (&Parameter, &f64)| {
        most_plausible(effect, parameter.name).is_none_or(|most| *value <= most)
    };
    effect.parameters.iter().zip(values).all(within)
}

/// Largest plausible value of a parameter, if it has one.
pub fn most_plausible(effect: &Effect, parameter: &str) -> Option<f64> {
    effect.plausible.iter().find(|(name, _)| *name == parameter).map(|(_, most)| *most)
}
