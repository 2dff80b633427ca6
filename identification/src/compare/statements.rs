//! What the report says, checked against what its own tables say.
//!
//! Every sentence that a number can settle is here, in the report's order and in other words, with the number and a verdict.
//! Where a sentence uses a word such as "similar" or "about", the finding says what was taken for it. "Significant" is
//! what the report itself defines: more than 0.1 in magnitude or 3 deg in phase.

mod analysis;
mod application;
mod conclusion;
mod estimation;
mod introduction;

use serde::Serialize;

use super::{Comparison, Condition, Difference, LIMITS, Set};
use actuator_fmu::parameters::{Base, LoadCase, Stage, Surface};

/// How a statement stands against the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The tables bear it out.
    Agrees,
    /// The tables say otherwise, at least in part.
    Contradicted,
    /// The tables cannot settle it.
    CannotBeChecked,
}

impl Verdict {
    /// In words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Contradicted => "contradicted",
            Self::CannotBeChecked => "cannot be checked",
        }
    }
}

/// One statement of the report and how it stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Statement {
    /// A name for it.
    pub name: &'static str,
    /// Section of the report.
    pub section: &'static str,
    /// What it says, in other words.
    pub claim: &'static str,
    /// What the tables give.
    pub finding: String,
    /// The outcome.
    pub verdict: Verdict,
}

impl Statement {
    fn judged(section: &'static str, name: &'static str, claim: &'static str, holds: bool, finding: String) -> Self {
        let verdict = if holds { Verdict::Agrees } else { Verdict::Contradicted };
        Self { name, section, claim, finding, verdict }
    }

    fn unchecked(section: &'static str, name: &'static str, claim: &'static str, why: &'static str) -> Self {
        Self { name, section, claim, finding: why.into(), verdict: Verdict::CannotBeChecked }
    }
}

/// All statements, in the order of the report.
#[must_use]
pub(super) fn of(tables: &Comparison) -> Vec<Statement> {
    [
        introduction::statements,
        estimation::statements,
        application::statements,
        analysis::statements,
        conclusion::statements,
    ]
    .iter()
    .flat_map(|section| section(tables))
    .collect()
}

/// Position of the parameters in [`Base::PARAMETERS`].
const K: usize = 0;
const P: usize = 1;
const OMEGA: usize = 2;
const ZETA: usize = 3;

/// Values of one parameter in all sets.
fn values(tables: &Comparison, parameter: usize) -> Vec<f64> {
    tables.sets.iter().map(|set| set.model.base.values()[parameter]).collect()
}

fn least(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::INFINITY, f64::min)
}

fn greatest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_unstable_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        odd if odd % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// Greatest over least.
fn spread(values: &[f64]) -> f64 {
    greatest(values.iter().copied()) / least(values.iter().copied())
}

/// Wear of one surface without load: free of load, and of what load and stage do together.
fn unloaded_wear(tables: &Comparison, surface: Surface) -> Vec<&Difference> {
    tables.wear.iter().filter(|pair| of_surface(pair, surface) && in_load_case(pair, LoadCase::Unloaded)).collect()
}

fn of_surface(pair: &Difference, surface: Surface) -> bool {
    pair.conditions.as_ref().is_some_and(|[from, _]| from.is_of(surface))
}

fn at_stage(pair: &Difference, stage: Stage) -> bool {
    pair.conditions.as_ref().is_some_and(|[from, _]| from.is_at(stage))
}

fn in_load_case(pair: &Difference, load_case: LoadCase) -> bool {
    pair.conditions.as_ref().is_some_and(|[from, _]| from.load_case == load_case)
}

/// Sets of a load case.
fn of_load_case(tables: &Comparison, load_case: LoadCase) -> impl Iterator<Item = &Set> + Clone {
    tables
        .sets
        .iter()
        .filter(move |set| set.condition.as_ref().is_some_and(|condition| condition.load_case == load_case))
}

/// Each loaded set with the unloaded one of its surface and stage.
fn loaded_with_unloaded(tables: &Comparison) -> Vec<(&Set, &Set)> {
    let pair = |loaded: &Set| {
        let condition = loaded.condition.clone()?;
        tables.find(&Condition { load_case: LoadCase::Unloaded, ..condition })
    };
    of_load_case(tables, LoadCase::Loaded).filter_map(|loaded| Some((loaded, pair(loaded)?))).collect()
}

/// Greatest phase difference of some pairs in the data's band [deg].
fn worst_phase<'a>(pairs: impl IntoIterator<Item = &'a Difference>) -> f64 {
    greatest(pairs.into_iter().map(|pair| pair.data_band.phase_deg.max))
}

/// Those that pass a limit in the data's band.
fn beyond_limits(pairs: &[Difference]) -> Vec<&Difference> {
    pairs.iter().filter(|pair| !pair.data_band.within_limits).collect()
}

/// "te-early-unloaded to te-late-unloaded 7.82 deg" and so on: the pairs that pass a limit, and by how much.
fn listed(pairs: &[&Difference]) -> String {
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

/// What is different in the second set: its stage, or that it is loaded.
fn stage_and_load(pair: &Difference) -> &str {
    match &pair.conditions {
        Some([from, to]) if from.load_case != to.load_case => to.load_case.name(),
        Some([_, to]) => &to.stage,
        None => &pair.to,
    }
}

/// A base with another value of one parameter; the same base if that value is not allowed.
fn with(base: &Base, parameter: usize, value: f64) -> Base {
    let mut values = base.values();
    values[parameter] = value;
    Base::from_values(values).unwrap_or(*base)
}
