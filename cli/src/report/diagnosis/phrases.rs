//! Verdicts, findings and parameters in words.

use super::super::page::Tone;
use actuator_fmu::effects::UNLIMITED;
use identification::{
    diagnose::{Finding, ParameterEstimate, Verdict},
    digits::with_unit,
};

/// Maximum value in the given model, relative to the new one, that counts as 0.
const NOTHING_BESIDE: f64 = 1e-9;

/// A verdict in words.
pub(in crate::report) fn words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NothingMissing => "nothing missing",
        Verdict::Named => "named",
        Verdict::Leading => "leading",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Unexplained => "unexplained",
    }
}

/// A share in percent, without a sign before 0.
pub(super) fn percent(share: f64) -> String {
    format!("{:.0} %", (100.0 * share).round() + 0.0)
}

/// Tone of a verdict: a name is settled, a lead or a tie is open.
pub(in crate::report) fn tone(verdict: Verdict) -> Tone {
    match verdict {
        Verdict::NothingMissing | Verdict::Named => Tone::Good,
        Verdict::Ambiguous | Verdict::Leading => Tone::Open,
        Verdict::Unexplained => Tone::Bad,
    }
}

/// Whether the records determine this parameter: a side of a limit that they hardly reach may be anywhere.
pub(super) fn is_met(finding: &Finding, parameter: &ParameterEstimate) -> bool {
    finding.family != "limit" || parameter.std_error.is_none_or(|error| error < parameter.value.abs())
}

/// Whether a parameter has an effect at this value: of a limit one side may have none.
pub(super) fn is_acting(value: f64) -> bool {
    value.abs() < UNLIMITED
}

/// A parameter in plain words. Files and JSON keep its name.
pub(in crate::report) fn plain(parameter: &str) -> &str {
    if parameter == "gap" { "backlash width" } else { parameter }
}

/// A finding in words: name and parameters, with their values in the given model where these have changed.
pub(super) fn spoken(finding: &Finding) -> String {
    if finding.parameters.iter().all(|parameter| parameter.was.is_none()) {
        let of = |parameter: &ParameterEstimate| (parameter.name, parameter.value, parameter.unit);
        return effect(finding.name, finding.parameters.iter().map(of));
    }
    let changed: Vec<String> = finding.parameters.iter().filter_map(changed).collect();
    format!("{} ({})", finding.name, changed.join(", "))
}

/// A parameter with its value in the given model; `None` if it acts in neither.
fn changed(parameter: &ParameterEstimate) -> Option<String> {
    let words = |value: f64| {
        if is_acting(value) { with_unit(value, 4, parameter.unit) } else { "none".to_owned() }
    };
    let was = before(parameter).unwrap_or(UNLIMITED);
    acts_or_did(parameter).then(|| format!("{} {}, was {}", parameter.name, words(parameter.value), words(was)))
}

/// The value of a parameter in the given model, 0 if it is negligible relative to the new one: fits end with delays of 1e-17 s.
pub(super) fn before(parameter: &ParameterEstimate) -> Option<f64> {
    parameter.was.map(|was| if was.abs() < NOTHING_BESIDE * parameter.value.abs() { 0.0 } else { was })
}

/// Whether a parameter acts, or did in the given model.
pub(super) fn acts_or_did(parameter: &ParameterEstimate) -> bool {
    is_acting(parameter.value) || parameter.was.is_some_and(is_acting)
}

/// First word of a sentence with a name: an effect is missing, or one of the given model has changed its strength.
pub(super) fn introduction(findings: &[Finding]) -> &'static str {
    let is_changed = |finding: &Finding| finding.parameters.iter().any(|parameter| parameter.was.is_some());
    match findings.iter().filter(|finding| is_changed(finding)).count() {
        0 => "Missing",
        count if count == findings.len() => "Changed",
        _ => "Missing or changed",
    }
}

/// An effect with its parameters: name, value, unit.
pub(in crate::report) fn effect<'a>(name: &str, parameters: impl Iterator<Item = (&'a str, f64, &'a str)>) -> String {
    let acting = parameters.filter(|(_, value, _)| is_acting(*value));
    let parameters: Vec<String> =
        acting.map(|(name, value, unit)| format!("{name} {}", with_unit(value, 4, unit))).collect();
    format!("{name} ({})", parameters.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_side_of_a_limit_that_does_not_act_is_not_said() {
        let said =
            |min: f64, max: f64| effect("position_limit", [("min", min, "deg"), ("max", max, "deg")].into_iter());
        assert_eq!(said(-3.0, 1e9), "position_limit (min -3.000 deg)");
        assert_eq!(said(-1e9, 4.0), "position_limit (max 4.000 deg)");
        assert_eq!(said(-3.0, 4.0), "position_limit (min -3.000 deg, max 4.000 deg)");
    }

    #[test]
    fn only_a_side_of_a_limit_is_called_undetermined_and_only_where_its_error_is_as_large_as_itself() {
        let of = |family: &'static str, value: f64, std_error: Option<f64>| {
            let (name, unit) = ("up", "deg/s");
            let up =
                ParameterEstimate { name, value, was: None, std_error, unit, at_bound: false, of_records: Vec::new() };
            let (name, parameters) = ("rate_limit", vec![up]);
            let found = Finding { name, family, parameters, delta_bic: 20.0, alternatives: Vec::new() };
            is_met(&found, &found.parameters[0])
        };
        assert!(of("limit", 144.0, Some(3.0)) && of("limit", -144.0, Some(3.0)) && of("limit", 144.0, None));
        assert!(!of("limit", 144.0, Some(7.6e6)) && !of("limit", -144.0, Some(144.0)));
        // A drift of nothing is a number.
        assert!(of("sensor", 0.0, Some(0.1)));
    }

    #[test]
    fn what_was_nothing_beside_the_value_found_is_said_to_be_nothing() {
        let said = |was: f64| {
            let (name, unit) = ("time", "s");
            let was = Some(was);
            let time = ParameterEstimate {
                name,
                value: 0.03,
                was,
                std_error: None,
                unit,
                at_bound: false,
                of_records: Vec::new(),
            };
            changed(&time).unwrap()
        };
        assert_eq!(said(1.128e-16), "time 0.03000 s, was 0 s");
        assert_eq!(said(1e-6), "time 0.03000 s, was 1.000e-6 s");
    }
}
