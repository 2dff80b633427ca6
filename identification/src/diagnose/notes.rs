//! What is said beside a verdict: the base of an explanation, levels of records, a slow residual, and why an effect comes after another.

use super::{
    evidence::pooled_deviation, fitted::Fitted, plain_fit::PlainFit, steady_level::level_and_deviation, trace::Trace,
    unseen::Judged,
};
use crate::digits::{significant, with_unit};
use actuator_fmu::parameters::Model;

/// Why an effect that could lead itself comes after the one that leads.
pub fn behind(own: &Judged, leading: &str, judged: &[&Judged]) -> String {
    let taken = |left: f64| 100.0 * (1.0 - left).clamp(0.0, 1.0);
    let Some(first) = judged.iter().find(|judged| judged.effect == leading) else {
        return format!("{leading} ranks first");
    };
    // Difference in g from which on it is the reason: shares refer to the excess of a base, which is not the same for all effects.
    const CLEARLY_MORE: f64 = 0.1;
    if first.part > own.part + CLEARLY_MORE {
        let [own, first] = [own, first].map(|judged| 100.0 * judged.part.clamp(0.0, 1.0));
        return format!("beyond a free base it explains {own:.0} % of the difference, {leading} {first:.0} %");
    }
    if first.remaining_share < own.remaining_share {
        return format!("{leading} explains more of the excess, {:.1} %", taken(first.remaining_share));
    }
    match [own, first].map(|judged| judged.nonlinear_share) {
        [Some(own), Some(first)] if first < own => format!(
            "{leading} explains more of the nonlinear part, {:.1} % instead of {:.1} %",
            taken(first),
            taken(own)
        ),
        _ => format!("{leading} ranks first and explains {:.0} % of the excess", taken(first.remaining_share)),
    }
}

/// Root mean square of the residual of an adequate model over that of its innovations, above which a note is given.
const STRONGLY_COLOURED: f64 = 3.0;

/// Effects that are fitted together with a wide base.
pub const BESIDE_WIDE_BASE: [&str; 2] = ["delay", "sensor_bias"];

/// Whether a model has the base of the given one, and the same values of these effects.
pub fn has_same_base(after: &Model, given: &Model, beside: &[&str]) -> bool {
    let is_same = |effect: &&str| after.effects.values_of(effect) == given.effects.values_of(effect);
    after.base == given.base && beside.iter().all(is_same)
}

/// A note on the base beside which an effect was found far from the given one.
pub fn beside_wide_base(after: &Model, beside: &[&str]) -> String {
    let [k, p, omega, zeta] = after.base.values().map(|value| significant(value, 4));
    let values_of = |effect: &str| after.effects.active_values_of(effect).filter(|_| beside.contains(&effect));
    let delay = values_of("delay");
    let delay = delay.map_or(String::new(), |values| format!(", a delay of {} s", significant(values[0], 3)));
    let bias = values_of("sensor_bias");
    let bias = bias.map_or(String::new(), |values| {
        format!(", a sensor bias of {} {}", significant(values[0], 3), after.unit().name())
    });
    format!("found beside a free base: k {k}, p {p} 1/s, omega {omega} rad/s, zeta {zeta}{delay}{bias}")
}

/// A note where the level of a record exceeds the rest of its residual: searches remove the level of each record, and no effect describes one that is
/// not the same in all.
pub fn level(model: &Model, trace: &Trace<'_>) -> Option<String> {
    let left = PlainFit::as_it_is(model, std::slice::from_ref(trace))?.residuals.concat();
    let [level, deviation] = level_and_deviation(&left);
    (level > deviation).then(|| {
        let (file, unit) = (trace.record.source().display(), model.unit().name());
        format!("{file} has a level of {}, which exceeds the rest of its residual", with_unit(level, 3, unit))
    })
}

/// A note where the residual of an adequate model far exceeds its innovations: it is no function of the motion, but not the noise of a fast sensor
/// either.
pub fn coloured(fitted: &Fitted) -> Option<String> {
    let left = pooled_deviation(&fitted.residuals);
    let squares: f64 = fitted.noise.iter().map(|noise| noise.innovation_rms.powi(2)).sum();
    #[allow(clippy::cast_precision_loss)] // a count of records
    let new = (squares / fitted.noise.len().max(1) as f64).sqrt();
    (left > STRONGLY_COLOURED * new).then(|| {
        let (left, new, unit) = (significant(left, 3), significant(new, 3), fitted.model.unit().name());
        format!(
            "the residual changes slowly: {left} {unit} rms, innovations {new} {unit} rms. It is slow sensor noise, or an unrecorded disturbance of the \
             actuator, such as a load or turbulence"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use actuator_fmu::{
        effects::find,
        parameters::{Base, table},
    };

    #[test]
    fn a_base_is_one_of_its_own_where_it_or_what_was_fitted_beside_it_is_not_the_given_one() {
        let given = Model::from_set(&table()[0]);
        let late = |seconds: f64| {
            let effects = given.effects.with(find("delay").unwrap(), &[seconds]).unwrap();
            Model { effects, ..given.clone() }
        };
        assert!(has_same_base(&given, &given, &BESIDE_WIDE_BASE));
        assert!(!has_same_base(&late(0.05), &given, &BESIDE_WIDE_BASE));
        // Where the delay is the effect that was found, its base is the given one.
        assert!(has_same_base(&late(0.05), &given, &["sensor_bias"]));
        let [k, p, omega, zeta] = given.base.values();
        let moved = Model { base: Base::from_values([1.01 * k, p, omega, zeta]).unwrap(), ..late(0.05) };
        assert!(!has_same_base(&moved, &given, &["sensor_bias"]));
        let note = beside_wide_base(&moved, &["sensor_bias"]);
        assert!(note.contains("omega") && !note.contains("delay"), "{note}");
        assert!(beside_wide_base(&moved, &BESIDE_WIDE_BASE).contains("a delay of 0.0500 s"));
    }
}
