//! Leave one record out: each explanation is refitted to all records but one and judged on that one, over all records.
//!
//! The division into fit and check records is arbitrary, and how good an explanation is should not depend on it. For each explanation the mean square
//! on every unseen record is compared with those of the free base alone and of the linear model; the excess is what there is to explain.

use super::{
    given_effects::delay_s,
    held::left_in_given,
    judgement::Judgement,
    late,
    linear_rival::{left_beside_linear, left_by_linear},
    plain_fit::PlainFit,
    predictable::{ADEQUATE_SHARE, predictable},
    rivals::Rivals,
    shown_alone::{DividedBase, where_shown_alone},
    steady_rate::{ACCELERATION_LIMIT, limits_rate},
    trace::Trace,
    unseen::{Judged, excess, sample_counts, strengths_by_record, unseen},
    wide::{Wide, effect_of},
};
use crate::{
    parallel,
    signal::record::{rms, without_mean},
    sorting::sort_by_number,
};
use actuator_fmu::parameters::Model;

/// Number of explanations that are judged.
const JUDGED: usize = 6;
/// Excess of the free base, or of the linear model, over its sum of squares, at least, for shares of it to be defined.
const LEAST_EXCESS_SHARE: f64 = 0.2;
/// E_free over E_near, at least, for an effect to be the largest part.
const LEAST_REMAINING_SHARE: f64 = 0.5;
/// s of an effect whose residual is not predictable, at most: a larger excess is not noise.
const LEFT_WHERE_ALL_IS_NOISE: f64 = 0.5;

/// Judges the candidates of a wide search; `noise` is the mean square of each record's noise.
pub fn judge(given: &Model, wide: &Wide, traces: &[Trace<'_>], noise: &[f64]) -> Option<Judgement> {
    let (base_left, base_blocks) = unseen(&wide.base, traces)?;
    let (as_given, about_levels) = (PlainFit::as_it_is(given, traces), PlainFit::beside_levels(given, traces));
    let omega = wide.base.model.base.omega();
    let linear_left = left_by_linear(traces, omega);
    let counts = sample_counts(&wide.base);
    let excess = |left: &[f64]| excess(left, noise, &counts);
    let whole = excess(&base_left);
    let total: f64 = base_left.iter().zip(&counts).map(|(left, count)| left * count).sum();
    let has_excess = whole > LEAST_EXCESS_SHARE * total;
    let linear_excess = excess(&linear_left);
    let linear_total: f64 = linear_left.iter().zip(&counts).map(|(left, count)| left * count).sum();
    let beside_linear = |fit: &PlainFit| {
        (linear_excess > LEAST_EXCESS_SHARE * linear_total).then(|| left_beside_linear(fit, traces, omega))?
    };
    let share_beside_base = beside_linear(&wide.base).map(|left| excess(&left) / linear_excess);
    let best = &wide.candidates[..wide.candidates.len().min(JUDGED)];
    let given_excess = as_given.as_ref().map_or(0.0, |given| excess(&given.mean_squares()));
    let divided_base = DividedBase::new(&wide.base, &base_left, best, traces);
    let mut judged: Vec<Judged> = parallel::map(best, |fit| {
        let (left, blocks) = where_shown_alone(fit, &divided_base, unseen(fit, traces)?, traces);
        let remaining_share = if has_excess { excess(&left) / whole } else { 1.0 };
        let of_records = strengths_by_record(fit, effect_of(fit), traces);
        let beside_linear = beside_linear(fit);
        Some(Judged {
            effect: effect_of(fit),
            fit: fit.clone(),
            remaining_share,
            part: (whole - excess(&left)) / given_excess,
            left,
            nonlinear_share: beside_linear.as_ref().map(|beside| excess(beside) / linear_excess),
            beside_linear: beside_linear.unwrap_or_default(),
            beats_linear: false,
            of_records,
            blocks,
            left_in_given: None,
            why_not: None,
        })
    })
    .into_iter()
    .flatten()
    .collect();
    sort_by_number(&mut judged, |one| one.remaining_share);
    let rivals = Rivals {
        base_left: &base_left,
        base_blocks: &base_blocks,
        linear_left: &linear_left,
        share_beside_base,
        counts: &counts,
        noise,
        given_excess,
        given_excess_about_levels: about_levels.as_ref().map_or(0.0, |given| excess(&given.mean_squares())),
        motion: traces.iter().zip(&counts).map(|(trace, count)| count * variance(trace)).sum(),
    };
    judged.iter_mut().for_each(|judged| judged.beats_linear = rivals.beats_linear(judged));
    let asked: Vec<bool> = (0..judged.len()).map(|place| rivals.is_told_by_given(place, &judged)).collect();
    for (judged, _) in judged.iter_mut().zip(asked).filter(|(_, is_asked)| *is_asked) {
        judged.left_in_given = left_in_given(given, &judged.fit, traces, noise);
    }
    let reasons: Vec<Option<String>> = (0..judged.len()).map(|place| rivals.why_not(place, &judged)).collect();
    judged.iter_mut().zip(reasons).for_each(|(judged, why_not)| judged.why_not = why_not);
    let elsewhere_s = Some(delay_s(&wide.base.model)).filter(|elsewhere_s| *elsewhere_s > 0.0);
    let late = late::judge(given, traces, noise, elsewhere_s)?;
    if whole < LEAST_REMAINING_SHARE * late.near_excess {
        let reason = "most of the difference is linear: a delay, or another order of the base";
        // Beside its own free base it may explain the whole difference.
        let leaves_noise = |judged: &Judged| {
            let share = || predictable(&judged.fit.model, &judged.fit.residuals, traces).share;
            judged.remaining_share < LEFT_WHERE_ALL_IS_NOISE && share() < ADEQUATE_SHARE
        };
        for judged in judged.iter_mut().filter(|judged| judged.why_not.is_none()) {
            let holds = rivals.takes_nearly_all(judged) || leaves_noise(judged);
            judged.why_not = (!holds).then(|| reason.to_owned());
        }
    }
    let of_acceleration = judged.iter().find(|judged| judged.effect == ACCELERATION_LIMIT);
    let limits_rate = of_acceleration.is_some_and(|judged| limits_rate(&judged.fit.model, traces));
    let base_predictable = predictable(&wide.base.model, &wide.base.residuals, traces);
    // A base near the given one leaves no less than a free one.
    let may_be_late = whole < late::GREATEST_REMAINING_SHARE_OF_OWN_BASE * late.near_excess;
    let base_as_late = late.is_delay_or_base.then_some(late.near);
    let delay = match late.judged {
        Some(delay) if delay.why_not.is_none() => Some(delay),
        beside_given if may_be_late => late::beside_own_base(given, &wide.base, traces, noise).or(beside_given),
        beside_given => beside_given,
    };
    Some(Judgement {
        base: wide.base.clone(),
        base_left,
        linear_left,
        judged,
        base_predictable,
        limits_rate,
        given_delay_s: delay_s(given),
        delay,
        base_as_late,
    })
}

/// Variance of the position of a record.
fn variance(trace: &Trace<'_>) -> f64 {
    rms(&without_mean(trace.record.position())).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::{
        judgement::tests::{judged, some_fit},
        rivals::is_play_and_no_friction,
    };

    /// A result for two records on which the base leaves 1 and an effect this share.
    fn said<T>(remaining_share: f64, given_excess: f64, of: impl Fn(&Rivals<'_>, &Judged) -> T) -> T {
        let rivals = Rivals {
            base_left: &[1.0; 2],
            base_blocks: &[],
            linear_left: &[1.0; 2],
            share_beside_base: None,
            counts: &[1.0; 2],
            noise: &[0.0; 2],
            given_excess,
            given_excess_about_levels: given_excess,
            motion: 1e3,
        };
        of(&rivals, &judged("asymmetric_gain", remaining_share, &some_fit()))
    }

    #[test]
    fn what_takes_nearly_all_that_a_base_leaves_need_not_be_much_of_the_difference() {
        let takes = |remaining_share: f64, given_excess: f64| {
            said(remaining_share, given_excess, |rivals, own| rivals.takes_nearly_all(own))
        };
        assert!(takes(0.01, 20.0) && takes(0.01, 3.0));
        assert!(!takes(0.01, 200.0) && !takes(0.2, 3.0));
    }

    #[test]
    fn play_is_no_friction_where_friction_leaves_more_of_what_it_takes_nearly_all_of() {
        let fit = some_fit();
        let is_play = |effect: &'static str, remaining_share: f64, by_friction: f64| {
            let others = [("coulomb_friction", by_friction), ("rate_limit", remaining_share)];
            let others = others.map(|(effect, remaining_share)| judged(effect, remaining_share, &fit));
            is_play_and_no_friction(&judged(effect, remaining_share, &fit), &others)
        };
        assert!(is_play("command_backlash", 0.04, 0.06) && is_play("backlash", -0.01, 0.06));
        assert!(!is_play("command_backlash", 0.04, 0.045) && !is_play("backlash", 0.12, 0.3));
        assert!(!is_play("dead_zone", 0.04, 0.06) && !is_play("coulomb_friction", 0.04, 0.06));
    }

    #[test]
    fn what_takes_a_small_part_must_leave_next_to_nothing_of_what_a_base_does() {
        let is_small = |remaining_share: f64, given_excess: f64| {
            said(remaining_share, given_excess, |rivals, own| rivals.small_part(own).is_some())
        };
        assert!(is_small(0.3, 40.0));
        assert!(!is_small(0.3, 10.0) && !is_small(0.04, 40.0));
    }

    #[test]
    fn strengths_of_single_records_do_not_speak_against_one_that_takes_all_that_no_linear_system_does() {
        let why_not = |nonlinear: f64| {
            said(0.5, 4.0, |rivals, own| {
                let (share, of_records) = (Some(nonlinear), vec![vec![0.3, 2.0]]);
                let own = Judged {
                    effect: "backlash",
                    nonlinear_share: share,
                    beside_linear: vec![nonlinear; 2],
                    of_records,
                    ..own.clone()
                };
                rivals.why_not(0, &[own])
            })
        };
        assert_eq!(why_not(0.04), None);
        assert_eq!(why_not(0.06).as_deref(), Some("gap 0.300 deg in one record and 2.00 deg in another"));
    }

    #[test]
    fn hysteresis_of_which_a_base_takes_most_must_be_all_that_is_nonlinear_or_a_large_part_about_the_levels() {
        let is_small = |nonlinear: f64, given_excess: f64, about_levels: f64| {
            said(0.5, given_excess, |rivals, own| {
                let own = Judged { nonlinear_share: Some(nonlinear), ..own.clone() };
                Rivals { given_excess_about_levels: about_levels, ..*rivals }.small_hysteresis(&own).is_some()
            })
        };
        assert!(!is_small(0.04, 40.0, 40.0));
        assert!(is_small(0.06, 40.0, 40.0) && is_small(0.04, 60.0, 60.0));
        assert!(!is_small(0.2, 40.0, 3.0));
        assert!(is_small(0.3, 40.0, 3.0) && is_small(0.2, 40.0, 5.0));
    }
}
