//! Detection limits: for each effect the strength from which on these records would have shown it.
//!
//! ```text
//! |d(s)|² / σ² = required,    d(s) the change of the position that a refitted base does not imitate
//! ```
//!
//! The change is simulated at strengths between one that clearly acts and none. The part that k, ω, ζ and the level of a record imitate is removed by
//! linear least squares.

use serde::Serialize;

use super::{
    evidence::REQUIRED_BIC_LEAD,
    fitted::Fitted,
    hypothesis::{Hypothesis, MeasurementTerm},
    jacobian::SimulationCache,
    output_error::OutputError,
    plain_fit::mean_square,
    screening::{changes, observe},
    sensitivities::Sensitivities,
    space::Space,
    trace::Trace,
};
use crate::{estimate::noise::Noise, parallel};
use actuator_fmu::effects::{CHAIN, Effect};

/// An effect and the strength from which on it would have been named.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Detectable {
    /// Effect.
    pub name: &'static str,
    /// Its deciding parameter.
    pub parameter: &'static str,
    /// Strength.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
}

/// Halvings of the interval, in the logarithm of the strength.
const HALVINGS: u32 = 7;

/// The detection limit of every effect that the fit records can show at all.
pub fn detectable(fitted: &Fitted, traces: &[Trace<'_>]) -> Vec<Detectable> {
    let free = Hypothesis { base_free: true, wide: true, ..Hypothesis::default() };
    let space = Space::new(free, &fitted.model, fitted.space.given(), 0.0);
    let white: Vec<Noise> = traces.iter().map(|_| Noise::white(1.0)).collect();
    let cache = SimulationCache::default();
    let problem = OutputError::new(&space, traces, &white, &cache);
    let x = space.start();
    let Some(simulated) = problem.simulated(&x) else { return Vec::new() };
    let sensitivities = Sensitivities::new(problem.sensitivities(&x, &simulated));
    let unmoved: Vec<Vec<f64>> = simulated.iter().map(|simulated| simulated.position.clone()).collect();
    let observed = observe(&fitted.model, &fitted.residuals, traces);
    #[allow(clippy::cast_precision_loss)] // a count of samples
    let samples = fitted.residuals.iter().map(Vec::len).sum::<usize>() as f64;
    // Coloured noise has fewer independent samples than white noise.
    let share = fitted.noise.iter().map(Noise::effective_share).fold(1.0, f64::min);
    let required = (2.0 * REQUIRED_BIC_LEAD + 2.0 * samples.ln()) / (samples * share);
    let noise = mean_square(&fitted.residuals.concat());
    let change = |effect: &'static Effect, values: &[f64]| -> Option<f64> {
        let mut model = fitted.model.clone();
        model.effects = model.effects.with(effect, values).ok()?;
        let moved: Option<Vec<Vec<f64>>> = traces.iter().map(|trace| trace.position(&model)).collect();
        let mut left = changes(&moved?, &unmoved);
        left.iter_mut().zip(traces).for_each(|(column, trace)| drop(column.drain(..trace.settling)));
        let left = sensitivities.step(None, &left).left;
        Some(mean_square(&left.concat()) / noise.max(f64::MIN_POSITIVE))
    };
    let one = |effect: &&'static Effect| -> Option<Detectable> {
        let (place, parameter) = effect.parameters.iter().enumerate().find(|(_, parameter)| parameter.decides)?;
        let ladder = (effect.start_values)(&observed);
        let strongest = ladder
            .iter()
            .filter_map(|values| Some((change(effect, values)?, values)))
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        if strongest.0 < required {
            return None;
        }
        // From the strength that is detected towards the neutral value: limits grow, all others shrink.
        let neutral_is_far = parameter.neutral.abs() > strongest.1[place].abs() * 1e3;
        let at = |severity: f64| -> Vec<f64> {
            let scale = |(parameter, value): (&actuator_fmu::effects::Parameter, &f64)| match parameter.decides {
                false => *value,
                true if neutral_is_far => value / severity,
                true => parameter.neutral + severity * (value - parameter.neutral),
            };
            effect.parameters.iter().zip(strongest.1).map(scale).collect()
        };
        let (mut seen, mut unseen) = (1.0_f64, 1e-3_f64);
        for _ in 0..HALVINGS {
            let middle = (seen * unseen).sqrt();
            if change(effect, &at(middle)).is_some_and(|change| change > required) {
                seen = middle
            } else {
                unseen = middle
            }
        }
        let unit = fitted.model.unit().derived(parameter.unit);
        Some(Detectable { name: effect.name, parameter: parameter.name, value: at(seen)[place], unit })
    };
    let admissible = |effect: &&&Effect| {
        effect.name != "quantisation"
            && MeasurementTerm::of(effect.name).is_none()
            && fitted.model.effects.active_values_of(effect.name).is_none()
    };
    let effects: Vec<&'static Effect> = CHAIN.iter().filter(admissible).copied().collect();
    parallel::map(&effects, one).into_iter().flatten().collect()
}
