//! Pairs of sets by surface, stage and load case, and their differences.

use super::order_statistics::greatest;
use crate::compare::{
    comparison::Comparison,
    condition::Condition,
    difference::{Difference, LIMITS},
    set::Set,
};
use actuator_fmu::parameters::{LoadCase, Stage, Surface};

/// Wear of one surface without load: unaffected by load, and by interaction of load and stage.
pub fn unloaded_wear(tables: &Comparison, surface: Surface) -> Vec<&Difference> {
    tables.wear.iter().filter(|pair| of_surface(pair, surface) && in_load_case(pair, LoadCase::Unloaded)).collect()
}

pub fn of_surface(pair: &Difference, surface: Surface) -> bool {
    pair.conditions.as_ref().is_some_and(|[from, _]| from.is_of(surface))
}

pub fn at_stage(pair: &Difference, stage: Stage) -> bool {
    pair.conditions.as_ref().is_some_and(|[from, _]| from.is_at(stage))
}

pub fn in_load_case(pair: &Difference, load_case: LoadCase) -> bool {
    pair.conditions.as_ref().is_some_and(|[from, _]| from.load_case == load_case)
}

/// Sets of a load case.
pub fn of_load_case(tables: &Comparison, load_case: LoadCase) -> impl Iterator<Item = &Set> + Clone {
    tables
        .sets
        .iter()
        .filter(move |set| set.condition.as_ref().is_some_and(|condition| condition.load_case == load_case))
}

/// Each loaded set with the unloaded one of its surface and stage.
pub fn loaded_with_unloaded(tables: &Comparison) -> Vec<(&Set, &Set)> {
    let pair = |loaded: &Set| {
        let condition = loaded.condition.clone()?;
        tables.find(&Condition { load_case: LoadCase::Unloaded, ..condition })
    };
    of_load_case(tables, LoadCase::Loaded).filter_map(|loaded| Some((loaded, pair(loaded)?))).collect()
}

/// Maximum phase difference of some pairs in the data's band [deg].
pub fn worst_phase<'a>(pairs: impl IntoIterator<Item = &'a Difference>) -> f64 {
    greatest(pairs.into_iter().map(|pair| pair.data_band.phase_deg.max))
}

/// Pairs that exceed a limit in the data's band.
pub fn beyond_limits(pairs: &[Difference]) -> Vec<&Difference> {
    pairs.iter().filter(|pair| !pair.data_band.within_limits).collect()
}

/// "te-early-unloaded to te-late-unloaded 7.82 deg" etc.: the pairs that exceed a limit, with their differences.
pub fn listed(pairs: &[&Difference]) -> String {
    let each = pairs.iter().map(|pair| {
        let (magnitude, phase) = (pair.data_band.magnitude.max, pair.data_band.phase_deg.max);
        let mut values = Vec::new();
        if magnitude > LIMITS.magnitude {
            values.push(format!("{magnitude:.3}"));
        }
        if phase > LIMITS.phase_deg {
            values.push(format!("{phase:.2} deg"));
        }
        format!("{} to {} {}", pair.from, stage_and_load(pair), values.join(" and "))
    });
    each.collect::<Vec<_>>().join("; ")
}

/// The difference of the second set: its stage, or that it is loaded.
pub fn stage_and_load(pair: &Difference) -> &str {
    match &pair.conditions {
        Some([from, to]) if from.load_case != to.load_case => to.load_case.name(),
        Some([_, to]) => &to.stage,
        None => &pair.to,
    }
}
