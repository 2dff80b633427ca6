//! Records that alone show a side of a limit.
//!
//! Where no other record reaches a limit, fits to the others do not determine it, and their residual on that record says nothing about the effect.
//! Such a record is divided: each half is judged by a fit to the other records and the other half. The residual of an effect on the halves is
//! compared with that of the base, divided alike. Where other records show the other side of the limit, the sides may also be taken as equal.

use std::slice::from_ref;

use super::{
    plain_fit::{PlainFit, mean_square},
    trace::Trace,
    unseen::{REFIT_ITERATIONS, blocks_of},
    wide::effect_of,
};
use actuator_fmu::{
    effects::{Effect, find},
    parameters::Model,
};

/// Sum of squares of what a side of a limit changes in all other records together, over that in one record, at most, where that record alone shows
/// it.
const SHOWN_BY_OTHERS: f64 = 0.05;
/// Sum of squares of what a side of a limit changes in a record over that of the residual, at least, for the record to show it.
const LEAST_CHANGE: f64 = 0.1;

/// A record that alone shows sides of a limit.
struct ShownAlone {
    record: usize,
    /// Places of their parameters.
    sides: Vec<usize>,
}

/// The free base, judged on unseen records, and on halves of those that alone show one of some effects.
pub struct DividedBase<'a> {
    /// Its mean square on each unseen record.
    left: &'a [f64],
    /// Its mean square on halves of records, where an effect needs it.
    of_halves: Vec<Option<f64>>,
}

impl<'a> DividedBase<'a> {
    /// `left` is the mean square of the base on each unseen record.
    pub fn new(base: &PlainFit, left: &'a [f64], effects: &[PlainFit], traces: &[Trace<'_>]) -> Self {
        let mut of_halves = vec![None; left.len()];
        let alone =
            effects.iter().flat_map(|fit| limit_of(fit).map_or_else(Vec::new, |limit| shown_alone(fit, limit, traces)));
        for ShownAlone { record, .. } in alone {
            if of_halves[record].is_none() {
                of_halves[record] = left_of_halves(base, None, record, traces);
            }
        }
        Self { left, of_halves }
    }
}

/// The effect of a fit, if it is a limit.
fn limit_of(fit: &PlainFit) -> Option<&'static Effect> {
    find(effect_of(fit)).filter(|effect| effect.family.name() == "limit")
}

/// Mean squares on unseen records, and sums of squares of their blocks, where records that alone show the effect are divided instead of left out, or
/// their side is set equal to the other one, which other records show.
pub fn where_shown_alone(
    fit: &PlainFit,
    base: &DividedBase<'_>,
    (mut left, mut blocks): (Vec<f64>, Vec<f64>),
    traces: &[Trace<'_>],
) -> (Vec<f64>, Vec<f64>) {
    let Some(limit) = limit_of(fit) else { return (left, blocks) };
    for alone in shown_alone(fit, limit, traces) {
        let record = alone.record;
        let sides = Some((limit, alone.sides.as_slice()));
        let halves = left_of_halves(fit, sides, record, traces).zip(base.of_halves[record]);
        let divided = halves.map(|(own, of_base)| base.left[record] * own / of_base);
        let alike = left_with_sides_alike(fit, limit, &alone, traces);
        let Some(least) = divided.into_iter().chain(alike).min_by(f64::total_cmp) else { continue };
        if least < left[record] {
            let factor = least / left[record];
            blocks[blocks_of(fit, record)].iter_mut().for_each(|square| *square *= factor);
            left[record] = least;
        }
    }
    (left, blocks)
}

/// Records that alone show a side of a limit.
fn shown_alone(fit: &PlainFit, limit: &'static Effect, traces: &[Trace<'_>]) -> Vec<ShownAlone> {
    let mut all: Vec<ShownAlone> = Vec::new();
    for side in (0..limit.parameters.len()).filter(|side| limit.parameters[*side].decides) {
        let Some(changes) = changes_by(fit, limit, side, traces) else { continue };
        let most = changes.iter().copied().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((record, most)) = most else { continue };
        let others = changes.iter().sum::<f64>() - most;
        let left: f64 = fit.residuals[record].iter().map(|value| value * value).sum();
        if most < LEAST_CHANGE * left || others > SHOWN_BY_OTHERS * most {
            continue;
        }
        match all.iter_mut().find(|alone| alone.record == record) {
            Some(alone) => alone.sides.push(side),
            None => all.push(ShownAlone { record, sides: vec![side] }),
        }
    }
    all
}

/// Mean square of a fit to the other records on one that alone shows a side of a limit, with that side set equal to the other one; none where there
/// is no other side, or this record alone shows that as well.
fn left_with_sides_alike(
    fit: &PlainFit,
    limit: &'static Effect,
    ShownAlone { record, sides }: &ShownAlone,
    traces: &[Trace<'_>],
) -> Option<f64> {
    let ([side], 2) = (sides.as_slice(), limit.parameters.len()) else { return None };
    let others = traces.iter().enumerate().filter(|(index, _)| index != record).map(|(_, trace)| trace.clone());
    let others: Vec<Trace<'_>> = others.collect();
    let taught = PlainFit::search_from(fit.space.clone(), &fit.x, &others, REFIT_ITERATIONS)?;
    let mut values = taught.model.effects.values_of(limit.name)?.to_vec();
    let of_other = values[1 - side];
    // Limits on both sides of zero have neutral values of both signs.
    values[*side] = of_other.abs().copysign(limit.parameters[*side].neutral);
    let effects = taught.model.effects.with(limit, &values).ok()?;
    let model = Model { effects, ..taught.model };
    Some(PlainFit::beside_levels(&model, from_ref(&traces[*record]))?.mean_square())
}

/// Sum of squares in each record of the change that a side of a limit makes.
fn changes_by(fit: &PlainFit, limit: &'static Effect, side: usize, traces: &[Trace<'_>]) -> Option<Vec<f64>> {
    let mut values = fit.model.effects.values_of(limit.name)?.to_vec();
    values[side] = limit.parameters[side].neutral;
    let without = Model { effects: fit.model.effects.with(limit, &values).ok()?, ..fit.model.clone() };
    let change = |trace: &Trace<'_>| {
        let (with, without) = (trace.position(&fit.model)?, trace.position(&without)?);
        Some(with.iter().zip(&without).map(|(with, without)| (with - without).powi(2)).sum())
    };
    traces.iter().map(change).collect()
}

/// Mean square on both halves of a record together, each with a fit to the other records and the other half. A side that the fitted records do not
/// show is unknown, and set to neutral.
fn left_of_halves(
    fit: &PlainFit,
    sides: Option<(&'static Effect, &[usize])>,
    record: usize,
    traces: &[Trace<'_>],
) -> Option<f64> {
    let whole = traces[record].record;
    let halves = [0..whole.len() / 2, whole.len() / 2..whole.len()];
    let evaluated = fit.residuals.get(record)?.len();
    let second = evaluated - (whole.len() - whole.len() / 2).min(evaluated);
    let judged = [second..evaluated, 0..second];
    let mut left = Vec::with_capacity(evaluated);
    for (taught, judged) in halves.into_iter().zip(judged) {
        let half = whole.stretch(taught).ok()?;
        let others = traces.iter().enumerate().filter(|(index, _)| *index != record).map(|(_, trace)| trace.clone());
        let mut seen: Vec<Trace<'_>> = others.collect();
        seen.push(Trace::coarse(&half, fit.space.given()));
        let taught = PlainFit::search_from(fit.space.clone(), &fit.x, &seen, REFIT_ITERATIONS)?;
        let mut effects = taught.model.effects.clone();
        for (limit, side) in sides.into_iter().flat_map(|(limit, sides)| sides.iter().map(move |side| (limit, *side))) {
            let there: f64 = changes_by(&taught, limit, side, &seen)?.iter().sum();
            let everywhere: f64 = changes_by(&taught, limit, side, traces)?.iter().sum();
            if there < SHOWN_BY_OTHERS * everywhere {
                let mut values = effects.values_of(limit.name)?.to_vec();
                values[side] = limit.parameters[side].neutral;
                effects = effects.with(limit, &values).ok()?;
            }
        }
        let model = Model { effects, ..taught.model };
        let on_whole = PlainFit::beside_levels(&model, from_ref(&traces[record]))?;
        left.extend_from_slice(on_whole.residuals[0].get(judged)?);
    }
    Some(mean_square(&left))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        diagnose::{hypothesis::Hypothesis, space::Space, unseen::unseen},
        signal::{Command, Interpolation, record::Record},
    };
    use actuator_fmu::{
        effects::Effects,
        parameters::{PositionUnit, table},
    };
    use std::f64::consts::TAU;

    /// For a step up, a step down, and motion that reaches no limit: mean squares of the base, and of the limit if fits to the others determined it
    /// no better than the base.
    fn left_of_steps(rates: [f64; 2]) -> [Vec<f64>; 2] {
        let limit = find("command_rate_limit").unwrap();
        let effects = Effects::default().with(limit, &rates).unwrap();
        let truth = Model { effects, ..Model::from_set(&table()[0]) };
        let base = truth.base;
        let record = |of: &dyn Fn(f64) -> f64| {
            let time: Vec<f64> = (0..800).map(|n| f64::from(n) / 100.0).collect();
            let command = Command { command: time.iter().map(|t| of(*t)).collect(), time };
            let (unit, held) = (PositionUnit::default(), Interpolation::Held);
            let still = vec![0.0; command.time.len()];
            let still = Record::new(command.clone(), still, unit, held, "record").unwrap();
            let position = Trace::new(&still, &base).position(&truth).unwrap();
            Record::new(command, position, unit, held, "record").unwrap()
        };
        let step = |sign: f64| move |t: f64| if t < 1.0 { 0.0 } else { sign * (11.0 - t).min(10.0) };
        let records = [record(&step(1.0)), record(&step(-1.0)), record(&|t| 2.0 * (0.5 * TAU * t).sin())];
        let traces: Vec<Trace<'_>> = records.iter().map(|record| Trace::new(record, &base)).collect();
        let fit = |effects: Vec<&'static str>, model: &Model| {
            let hypothesis = Hypothesis { effects, base_free: true, wide: true, ..Hypothesis::default() };
            PlainFit::search(Space::new(hypothesis, model, &base, 0.0), &traces, 25).unwrap()
        };
        let without = fit(Vec::new(), &Model { effects: Effects::default(), ..truth.clone() });
        let limited = fit(vec![limit.name], &truth);
        let (of_base, _) = unseen(&without, &traces).unwrap();
        let (_, blocks) = unseen(&limited, &traces).unwrap();
        let divided = DividedBase::new(&without, &of_base, from_ref(&limited), &traces);
        let (own, _) = where_shown_alone(&limited, &divided, (of_base.clone(), blocks), &traces);
        [of_base, own]
    }

    #[test]
    fn a_side_that_one_record_alone_shows_is_known_from_the_other_where_they_are_alike() {
        let [of_base, of_limit] = left_of_steps([40.0, 40.0]);
        assert!((0..2).all(|step| of_limit[step] < 1e-3 * of_base[step]), "{of_base:?} {of_limit:?}");
        // A record that does not show the limit is judged as it was.
        assert!(of_limit[2] == of_base[2]);
        let [of_base, of_limit] = left_of_steps([40.0, 20.0]);
        assert!((0..2).all(|step| of_limit[step] > 0.1 * of_base[step]), "{of_base:?} {of_limit:?}");
    }
}
