//! A delay beside the given base, and beside a free base.
//!
//! A free base includes a delay, since any linear system of higher order appears delayed to one of third order. A new delay is distinguished from
//! that by the given base, which has not changed: with the delay alone its residual is smaller than that of any other base near it. Where the given
//! base is not that of the actuator (fitted to delayed records, or inaccurate), a delay is identified by its residual beside a free base: far smaller
//! than that of any base without it. If the given model already has a delay, as fitted ones do, the increase is judged.

use super::{
    given_effects::delay_s,
    hypothesis::{DELAY, Hypothesis},
    plain_fit::PlainFit,
    space::Space,
    trace::Trace,
    unseen::{Judged, LEAST_BOOTSTRAP, bootstrap, excess, of_records, sample_counts, unseen},
    wide::implausible,
};
use actuator_fmu::{
    effects::{Effect, find},
    parameters::{Base, Model, Order},
};

/// Start values of the delay, in time constants 1/ω. A search ends at the nearest minimum: an oscillation delayed by a period looks on time.
const STARTS: [f64; 6] = [0.03, 0.1, 0.3, 0.8, 1.6, 3.2];
const ITERATIONS: usize = 20;
/// Factor within which k, ω and ζ of the near base are searched, and start values of its pole, as multiples of ω: a fast pole gives no hint of where
/// a slow one would be.
const NEAR: f64 = 2.0;
const POLE_STARTS: [f64; 2] = [3.0, 15.0];

/// d: share of the given model's excess that the delay may leave.
const GREATEST_REMAINING_SHARE: f64 = 0.5;
/// Excess of the near base minus that of the delay, at least, as a share of the given model's; or excess of the near base over that of the delay. One
/// of them suffices: the near base has four free parameters instead of one.
const LEAST_MARGIN: f64 = 0.1;
const LEAST_RATIO: f64 = 2.0;
/// Increase of the sum of squares on any record, at most, as a share of the total decrease.
const GREATEST_RISE: f64 = 0.02;
/// d below which the delay explains all but what the structure of the base leaves beside any explanation: the near base, with four free parameters
/// instead of one, may then be as good.
const LEFT_BY_STRUCTURE: f64 = 0.05;
/// Excess of the near base over that of the delay, at least: far less if the base is what has changed.
const LEAST_LEFT_BY_RIVAL: f64 = 0.7;
/// Or the near base explains at most this share of the given model's excess more than the delay does.
const NO_MORE_THAN_DELAY: f64 = 0.005;
/// Excess over the variance of the noise below which a fit leaves noise. The near base must not leave noise where the delay leaves more.
const LEFT_BESIDE_NOISE: f64 = 0.1;
/// Largest over smallest delay of the records, where the near base is as good: the lag of a changed base differs with the motion.
const GREATEST_RATIO_BESIDE_RIVAL: f64 = 1.3;
/// d below which the difference is a lag, of the delay or of the base, where the near base is as good.
const LEFT_BY_LAG: f64 = 0.15;
/// The same where the near base leaves less than the second share of the given model's excess: a delay explains less of a pole, such as that of a
/// slower sensor.
const LEFT_BESIDE_BASE: f64 = 0.25;
const LEFT_BY_BASE: f64 = 0.1;
/// Excess of the given model over its sum of squares, at least.
const LEAST_EXCESS_SHARE: f64 = 0.2;
/// Largest over smallest delay of the records.
const GREATEST_RATIO: f64 = 1.5;

/// Excess of a delay beside a free base over that of any base without a delay, at most.
pub const GREATEST_REMAINING_SHARE_OF_OWN_BASE: f64 = 0.2;
/// Delay over the lag of the free base beside it, at least. Poles beyond the third order, which filters, valves and couplings have at a few times the
/// bandwidth, appear as a delay of up to 0.4 of that lag.
const LEAST_OF_LAG: f64 = 0.6;
/// Factor in ω and ζ within which a model of an actuator of third order is accurate.
const FAR: f64 = 1.5;
/// Start values of a base without a delay, as multiples of ω of one with a delay, and the largest start value of its pole, as a multiple of ω.
const SLOWER: [f64; 3] = [1.0, 0.6, 0.35];
const FASTEST_POLE_START: f64 = 6.0;

/// The delay beside the given base, and the near base.
pub struct Late {
    /// The delay, judged; none where the difference is mainly noise.
    pub judged: Option<Judged>,
    /// The near base, without a delay beyond that of the given model.
    pub near: PlainFit,
    /// Its excess on unseen records, E_near.
    pub near_excess: f64,
    /// Whether the delay explains nearly all of the difference, alike in all records, and the near base is as good or explains nearly all of it as
    /// well.
    pub is_delay_or_base: bool,
}

/// Judges a delay beside the given base; `noise` is the mean square of each record's noise, `elsewhere_s` the delay of a free base.
pub fn judge(given: &Model, traces: &[Trace<'_>], noise: &[f64], elsewhere_s: Option<f64>) -> Option<Late> {
    let near = nearest_base(given, traces)?;
    let counts = sample_counts(&near);
    let (near_left, near_blocks) = unseen(&near, traces)?;
    let near_excess = excess(&near_left, noise, &counts);
    let mut is_delay_or_base = false;
    let judged = delayed(given, traces, elsewhere_s).and_then(|fit| {
        let given_left = PlainFit::beside_levels(given, traces)?.mean_squares();
        let whole = excess(&given_left, noise, &counts);
        let total: f64 = given_left.iter().zip(&counts).map(|(left, count)| left * count).sum();
        if whole < LEAST_EXCESS_SHARE * total {
            return None;
        }
        let (left, blocks) = unseen(&fit, traces)?;
        let own = excess(&left, noise, &counts);
        let remaining_share = own / whole;
        let of_records = of_records(&fit, DELAY, traces);
        let (least, greatest) = range_beyond(delay_s(given), &of_records);
        let rises = left.iter().zip(&given_left).zip(&counts).map(|((left, given), count)| count * (left - given));
        let grows = rises.fold(0.0, f64::max) > GREATEST_RISE * (whole - own);
        let noise_sum: f64 = noise.iter().zip(&counts).map(|(noise, count)| noise * count).sum();
        let is_noise = |excess: f64| excess < LEFT_BESIDE_NOISE * noise_sum;
        let explains_all = remaining_share < LEFT_BY_STRUCTURE
            && (is_noise(own) || !is_noise(near_excess))
            && (near_excess > LEAST_LEFT_BY_RIVAL * own || own - near_excess < NO_MORE_THAN_DELAY * whole)
            && greatest < GREATEST_RATIO_BESIDE_RIVAL * least;
        let is_base_as_near = near_excess < (own + LEAST_MARGIN * whole).min(LEAST_RATIO * own)
            || bootstrap(&near_blocks, &blocks) < LEAST_BOOTSTRAP;
        let is_base = near_excess < LEFT_BY_BASE * whole;
        is_delay_or_base = (is_base_as_near || is_base)
            && remaining_share < if is_base { LEFT_BESIDE_BASE } else { LEFT_BY_LAG }
            && greatest < GREATEST_RATIO * least;
        let why_not = if remaining_share > GREATEST_REMAINING_SHARE || grows {
            Some(format!("beside the given base {:.0} % of the excess remains", 100.0 * remaining_share))
        } else if !explains_all && is_base_as_near {
            Some("a base near the given one explains unseen records equally well".to_owned())
        } else if greatest > GREATEST_RATIO * least {
            Some(format!("{least:.4} s in one record and {greatest:.4} s in another"))
        } else {
            None
        };
        Some(judged_delay(fit, (left, blocks), remaining_share, of_records, why_not))
    });
    Some(Late { judged, near, near_excess, is_delay_or_base })
}

/// A delay beside a free base, `late`: identified where any base without a delay has several times its excess, and where it is no small part of the
/// lag of the base, since the poles of a rig beyond the third order appear as less. None where it is not identified.
pub fn beside_own_base(given: &Model, late: &PlainFit, traces: &[Trace<'_>], noise: &[f64]) -> Option<Judged> {
    let hypothesis = Hypothesis { effects: vec![DELAY], ..late.space.hypothesis.clone() };
    let space = Space::new(hypothesis, &late.model, &given.base, 0.0);
    let fit = PlainFit::at_start(space.clone(), traces)?;
    let counts = sample_counts(&fit);
    let (left, blocks) = unseen(&fit, traces)?;
    let (without_left, without_blocks) = unseen(&without_delay(given, late, traces)?, traces)?;
    let remaining_share = excess(&left, noise, &counts) / excess(&without_left, noise, &counts);
    let of_records = of_records(&fit, DELAY, traces);
    let (least, greatest) = range_beyond(delay_s(given), &of_records);
    let is_identified = remaining_share < GREATEST_REMAINING_SHARE_OF_OWN_BASE
        && is_no_small_part(&fit.model, given)
        && greatest < GREATEST_RATIO * least
        && bootstrap(&without_blocks, &blocks) > LEAST_BOOTSTRAP
        && implausible(&fit).is_none();
    is_identified.then(|| judged_delay(fit, (left, blocks), remaining_share, of_records, None))
}

/// Whether the delay of a model beyond that of the given one is no small part of the lag of its base.
pub fn is_no_small_part(found: &Model, given: &Model) -> bool {
    delay_s(found) - delay_s(given) > LEAST_OF_LAG * lag_s(found)
}

/// Whether a delay or lag is due to poles beyond the third order: its base is far from the given one, and it is no large part of the lag of that
/// base.
pub fn is_of_structure(lag: &Effect, found: &Model, given: &Model) -> bool {
    let of = |model: &Model| model.effects.active_values_of(lag.name).map_or(0.0, |values| values[0]);
    let late_s = of(found) - of(given);
    let moved = |number: fn(&Base) -> f64| (number(&found.base) / number(&given.base)).ln().abs() > FAR.ln();
    (moved(Base::omega) || moved(Base::zeta)) && late_s < LEAST_OF_LAG * lag_s(found)
}

/// Lag of a base in slow motion [s]: 1/p + 2 ζ/ω.
pub fn lag_s(model: &Model) -> f64 {
    let pole = if model.order == Order::Third { 1.0 / model.base.p() } else { 0.0 };
    pole + 2.0 * model.base.zeta() / model.base.omega()
}

/// A delay, which is linear, judged by its residual on unseen records and their blocks.
fn judged_delay(
    fit: PlainFit,
    (left, blocks): (Vec<f64>, Vec<f64>),
    remaining_share: f64,
    of_records: Vec<Vec<f64>>,
    why_not: Option<String>,
) -> Judged {
    Judged {
        fit,
        effect: DELAY,
        left,
        remaining_share,
        part: 1.0 - remaining_share,
        nonlinear_share: None,
        beside_linear: Vec::new(),
        beats_linear: false,
        of_records,
        blocks,
        left_in_given: None,
        why_not,
    }
}

/// The best base without a delay beyond that of the given model; it is slower than one with a delay.
fn without_delay(given: &Model, late: &PlainFit, traces: &[Trace<'_>]) -> Option<PlainFit> {
    let [k, p, omega, zeta] = late.model.base.values();
    let fits = SLOWER.iter().filter_map(|factor| {
        let base = Base::from_values([k, factor * p.min(FASTEST_POLE_START * omega), factor * omega, zeta]).ok()?;
        let start = Model { base, effects: given.effects.clone(), ..late.model.clone() };
        let hypothesis = Hypothesis { given_held: delay_s(given) > 0.0, ..late.space.hypothesis.clone() };
        let space = Space::new(hypothesis, &start, &given.base, 0.0);
        PlainFit::search(space, traces, ITERATIONS)
    });
    fits.min_by(|a, b| a.mean_square().total_cmp(&b.mean_square()))
}

/// Smallest and largest value of the records, minus that of the given model.
fn range_beyond(given: f64, of_records: &[Vec<f64>]) -> (f64, f64) {
    let each = of_records.iter().flatten().map(|value| value - given);
    each.fold((f64::INFINITY, 0.0), |(least, greatest): (f64, f64), value| (least.min(value), greatest.max(value)))
}

/// The best base near the given one, without a delay beyond that of the given model.
fn nearest_base(given: &Model, traces: &[Trace<'_>]) -> Option<PlainFit> {
    let [k, p, omega, zeta] = given.base.values();
    let starts = POLE_STARTS.iter().map(|ratio| ratio * omega).filter(|_| given.order == Order::Third).chain([p]);
    let fits = starts.filter_map(|pole| {
        let base = Base::from_values([k, pole, omega, zeta]).ok()?;
        let given_held = delay_s(given) > 0.0;
        let free = Hypothesis { base_free: true, wide: true, given_held, ..Hypothesis::default() };
        let space = Space::new(free, &Model { base, ..given.clone() }, &given.base, 0.0).near(&given.base, NEAR);
        PlainFit::search(space, traces, ITERATIONS)
    });
    fits.min_by(|a, b| a.mean_square().total_cmp(&b.mean_square()))
}

/// The best delay beside the given base, longer than that of the given model.
fn delayed(given: &Model, traces: &[Trace<'_>], elsewhere_s: Option<f64>) -> Option<PlainFit> {
    let delay = find(DELAY)?;
    let hypothesis = Hypothesis { effects: vec![delay.name], wide: true, ..Hypothesis::default() };
    let starts = STARTS.iter().map(|share| delay_s(given) + share / given.base.omega()).chain(elsewhere_s);
    let spaces = starts.filter_map(|start_s| {
        let effects = given.effects.with(delay, &[start_s]).ok()?;
        Some(Space::new(hypothesis.clone(), &Model { effects, ..given.clone() }, &given.base, 0.0))
    });
    PlainFit::search_from_nearest(spaces, traces, ITERATIONS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::three_records::three_records,
        signal::record::{Record, rms, without_mean},
    };
    use actuator_fmu::{effects::Effects, parameters::table};

    /// The record of a sensor behind some poles and a delay of some samples.
    fn behind(record: &Record, poles: &[f64], late_samples: usize) -> Record {
        let interval_s = record.time()[1] - record.time()[0];
        let mut position = record.position().to_vec();
        for pole in poles {
            let (kept, mut now) = ((-pole * interval_s).exp(), position[0]);
            position.iter_mut().for_each(|value| {
                now = kept * now + (1.0 - kept) * *value;
                *value = now;
            });
        }
        let late = (0..position.len()).map(|n| position[n.saturating_sub(late_samples)]).collect();
        Record::new(record.to_command(), late, record.unit(), record.interpolation(), "behind").unwrap()
    }

    #[test]
    fn poles_beyond_the_third_order_are_no_delay() {
        let base = Base::from_values([1.0, 70.0, 35.0, 0.7]).unwrap();
        let healthy = Model { order: Order::Third, base, effects: Effects::default(), ..Model::from_set(&table()[0]) };
        let records = three_records(&healthy, 3.0);
        let delay_s = |poles: &[f64], late_samples: usize| {
            let records: Vec<Record> = records.iter().map(|record| behind(record, poles, late_samples)).collect();
            let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &healthy.base)).collect();
            let noise: Vec<f64> =
                records.iter().map(|record| (0.01 * rms(&without_mean(record.position()))).powi(2)).collect();
            let free = Hypothesis { base_free: true, wide: true, ..Hypothesis::default() };
            let effects = healthy.effects.with(find("delay").unwrap(), &[0.02]).unwrap();
            let space = Space::new(free, &Model { effects, ..healthy.clone() }, &healthy.base, 0.0);
            let late = PlainFit::search(space, &traces, ITERATIONS).unwrap();
            let judged = beside_own_base(&healthy, &late, &traces, &noise)?;
            Some(judged.fit.model.effects.values_of("delay").unwrap()[0])
        };
        assert_eq!(delay_s(&[60.0, 100.0, 150.0, 200.0], 0), None);
        let found = delay_s(&[], 8).unwrap();
        assert!((found - 0.04).abs() < 1e-3, "{found}");
    }

    #[test]
    fn a_small_delay_beside_a_base_far_off_is_of_structure() {
        let given = Model::from_set(&table()[0]);
        let delay = find(DELAY).unwrap();
        let of_structure = |omega_factor: f64, share_of_lag: f64| {
            let [k, p, omega, zeta] = given.base.values();
            let base = Base::from_values([k, p, omega_factor * omega, zeta]).unwrap();
            let shifted = Model { base, ..given.clone() };
            let effects = shifted.effects.with(delay, &[share_of_lag * lag_s(&shifted)]).unwrap();
            is_of_structure(delay, &Model { effects, ..shifted }, &given)
        };
        assert!(of_structure(1.6, 0.2) && of_structure(0.6, 0.2));
        assert!(!of_structure(1.3, 0.2) && !of_structure(1.6, 0.7));
    }
}
