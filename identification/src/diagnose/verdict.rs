//! Findings: effects of a hypothesis with parameters, standard errors and alternatives.

use std::collections::BTreeSet;

use super::{
    diagnosis::{Finding, ParameterEstimate},
    fitted::Fitted,
    hypothesis::{PARAMETER_SHIFT, family},
    space::ParameterIndex,
    trace::Trace,
};
use actuator_fmu::{
    effects::Effects,
    parameters::{Base, Model, PositionUnit},
};

/// The findings of a hypothesis.
pub fn findings(
    best: &Fitted,
    given: &Fitted,
    rivals: &[Fitted],
    candidates: &[Fitted],
    traces: &[Trace<'_>],
) -> Vec<Finding> {
    let covariance = best.covariance(traces);
    let of_terms = best.term_errors(covariance.as_ref(), traces);
    let position = best.model.unit();
    let estimate = |name: &'static str, unit: &'static str, value: f64, place: ParameterIndex| {
        let at_bound = best.space.slope(&best.x, place).is_some_and(|(place, _)| best.at_bound[place]);
        let std_error = best.std_error(covariance.as_ref(), place);
        ParameterEstimate { name, value, was: None, std_error, unit, at_bound, of_records: Vec::new() }
    };
    let effects = &best.space.hypothesis.effects;
    let distinct = |names: Vec<String>| names.into_iter().collect::<BTreeSet<String>>().into_iter().collect();
    if effects.is_empty() {
        let values = best.model.base.values();
        let free = |place: &usize| best.space.slope(&best.x, ParameterIndex::Base(*place)).is_some();
        let parameters = (0..values.len()).filter(free).map(|place| {
            let parameter = &Base::PARAMETERS[place];
            estimate(parameter.name, position.derived(parameter.unit), values[place], ParameterIndex::Base(place))
        });
        return vec![Finding {
            name: PARAMETER_SHIFT,
            family: family(PARAMETER_SHIFT),
            parameters: parameters.collect(),
            delta_bic: given.bic - best.bic,
            alternatives: distinct(rivals.iter().map(|rival| rival.space.hypothesis.name()).collect()),
        }];
    }
    let one = |effect: &&'static str| {
        let values = best.model.effects.values();
        // An effect of the given model is free beside a free base.
        let was_given = given.model.effects.active_values_of(effect).is_some();
        let parameters = Effects::parameters().enumerate().filter(|(_, (of, _))| of.name == *effect).map(
            |(index, (_, parameter))| {
                let (unit, place) = (position.derived(parameter.unit), ParameterIndex::Effect(index));
                let mut found = estimate(parameter.name, unit, values[index], place);
                let of_term =
                    of_terms.iter().find(|error| error.effect == *effect && error.parameter == parameter.name);
                found.std_error = found.std_error.or(of_term.map(|error| error.std_error));
                found.was = was_given.then(|| given.model.effects.values()[index]);
                found
            },
        );
        let others: Vec<&str> = effects.iter().copied().filter(|other| other != effect).collect();
        let alternatives = distinct(rivals.iter().filter_map(|rival| instead(rival, effects, &others)).collect());
        // Where the base is not refitted, the comparison is with the given base.
        let base_free = best.space.hypothesis.base_free;
        let without = candidates
            .iter()
            .filter(|other| {
                let left = &other.space.hypothesis.effects;
                left.len() == others.len()
                    && others.iter().all(|name| left.contains(name))
                    && (base_free || !other.space.hypothesis.base_free)
                    && !(was_given && other.space.hypothesis.base_free)
            })
            .map(|other| other.bic)
            .fold(f64::INFINITY, f64::min);
        let without = if without.is_finite() { without } else { given.bic };
        Finding {
            name: effect,
            family: family(effect),
            parameters: parameters.collect(),
            delta_bic: without - best.bic,
            alternatives,
        }
    };
    effects.iter().map(one).collect()
}

/// What a rival has in place of one effect, if all others are the same; all its effects if it shares none.
fn instead(rival: &Fitted, found: &[&str], others: &[&str]) -> Option<String> {
    let effects = &rival.space.hypothesis.effects;
    let added: Vec<&str> = effects.iter().copied().filter(|effect| !found.contains(effect)).collect();
    if others.iter().all(|other| effects.contains(other)) {
        return Some(if added.is_empty() { rival.space.hypothesis.name() } else { added.join(" + ") });
    }
    let shares_nothing = !effects.iter().any(|effect| found.contains(effect));
    shares_nothing.then(|| rival.space.hypothesis.name())
}

/// Quantisation of the values.
pub fn quantisation(step: f64, traces: &[Trace<'_>]) -> Finding {
    #[allow(clippy::cast_precision_loss)] // a count of samples
    let samples = traces.iter().map(Trace::evaluated_samples).sum::<usize>() as f64;
    // Every value is a multiple of the step to a thousandth of it: the probability of each by chance is 2 in 1000.
    let delta_bic = -2.0 * samples * 2e-3_f64.ln();
    let unit = traces.first().map_or_else(PositionUnit::default, |trace| trace.record.unit()).name();
    let step = ParameterEstimate {
        name: "step",
        value: step,
        was: None,
        std_error: Some(0.0),
        unit,
        at_bound: false,
        of_records: Vec::new(),
    };
    Finding {
        name: "quantisation",
        family: family("quantisation"),
        parameters: vec![step],
        delta_bic,
        alternatives: Vec::new(),
    }
}

/// Writes the standard errors into the model.
pub fn set_errors(model: &mut Model, best: &Fitted, findings: &[Finding], traces: &[Trace<'_>]) {
    let covariance = best.covariance(traces);
    model.std_errors = std::array::from_fn(|place| best.std_error(covariance.as_ref(), ParameterIndex::Base(place)));
    for finding in findings {
        for parameter in &finding.parameters {
            if let Ok(index) = Effects::index(finding.name, parameter.name) {
                model.effect_std_errors[index] = parameter.std_error;
            }
        }
    }
}
