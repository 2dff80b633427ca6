//! Sets compared by the origin of their differences: wear, load, order.

use serde::Serialize;

use super::{
    condition::Condition,
    difference::{Difference, LIMITS, Limits},
    set::Set,
    statement::Statement,
};
use actuator_fmu::parameters::{LoadCase, Model, Order, SetName, Stage, Surface};

/// Differences between sets, by origin.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Origin of the sets.
    pub source: String,
    /// The sets.
    pub sets: Vec<Set>,
    /// The limits.
    pub limits: Limits,
    /// Same surface and load case, a later stage against an earlier one.
    pub wear: Vec<Difference>,
    /// Same surface and stage, loaded against unloaded.
    pub load: Vec<Difference>,
    /// Third order against second order with the same k, ω and ζ: the effect of omitting the pole. Third-order sets only.
    pub order: Vec<Difference>,
    /// Every other set against the first, if a condition is unknown.
    pub against_first: Vec<Difference>,
    /// Statements of the report; for its own tables only.
    pub statements: Vec<Statement>,
}

impl Comparison {
    /// Unit of gains and magnitudes if all sets have the same position unit; otherwise they are ratios with unit 1.
    #[must_use]
    pub fn gain_unit(&self) -> &'static str {
        let mut units = self.sets.iter().map(|set| set.model.unit());
        let first = units.next().unwrap_or_default();
        if units.all(|unit| unit == first) { first.of_gain() } else { "1" }
    }

    /// Any sets. If each has a condition and no two have the same, wear and load are compared; otherwise all against the first.
    #[must_use]
    pub fn of(source: impl Into<String>, sets: Vec<Set>) -> Self {
        let mut comparison = Self {
            source: source.into(),
            limits: LIMITS,
            wear: Vec::new(),
            load: Vec::new(),
            order: sets.iter().filter(|set| set.model.order == Order::Third).map(order).collect(),
            against_first: Vec::new(),
            statements: Vec::new(),
            sets,
        };
        let conditions: Vec<Option<&Condition>> = comparison.sets.iter().map(|set| set.condition.as_ref()).collect();
        let distinct =
            conditions.iter().enumerate().all(|(index, one)| one.is_some() && !conditions[..index].contains(one));
        if distinct && comparison.sets.len() > 1 {
            comparison.wear = comparison.wear();
            comparison.load = comparison.load();
        }
        if comparison.wear.is_empty()
            && comparison.load.is_empty()
            && let Some((first, others)) = comparison.sets.split_first()
        {
            comparison.against_first = others.iter().map(|other| Difference::between(first, other)).collect();
        }
        comparison
    }

    /// The set for one of the report's conditions.
    #[must_use]
    pub fn set(&self, surface: Surface, stage: Stage, load_case: LoadCase) -> Option<&Set> {
        self.find(&SetName { surface, stage, load_case }.into())
    }

    /// The set for a condition.
    #[must_use]
    pub fn find(&self, condition: &Condition) -> Option<&Set> {
        self.sets.iter().find(|set| set.condition.as_ref() == Some(condition))
    }

    /// Surfaces, each once: the report's in its order, then others in order of occurrence.
    #[must_use]
    pub fn surfaces(&self) -> Vec<&str> {
        self.words(|condition| &condition.surface, Surface::NAMES)
    }

    /// Stages, each once: the report's in its order, then others in order of occurrence.
    #[must_use]
    pub fn stages(&self) -> Vec<&str> {
        self.words(|condition| &condition.stage, Stage::NAMES)
    }

    fn words(&self, of: fn(&Condition) -> &String, known: &[&str]) -> Vec<&str> {
        let mut words: Vec<&str> = Vec::new();
        for word in self.sets.iter().filter_map(|set| set.condition.as_ref()).map(|condition| of(condition).as_str()) {
            if !words.contains(&word) {
                words.push(word);
            }
        }
        // The sort is stable: others keep their order.
        words.sort_by_key(|word| known.iter().position(|name| name == word).unwrap_or(known.len()));
        words
    }

    fn at(&self, surface: &str, stage: &str, load_case: LoadCase) -> Option<&Set> {
        self.find(&Condition { surface: surface.into(), stage: stage.into(), load_case })
    }

    fn wear(&self) -> Vec<Difference> {
        let mut found = Vec::new();
        for surface in self.surfaces() {
            for &load_case in LoadCase::ALL {
                let stages: Vec<&Set> =
                    self.stages().into_iter().filter_map(|stage| self.at(surface, stage, load_case)).collect();
                for (index, later) in stages.iter().enumerate() {
                    found.extend(stages[..index].iter().map(|earlier| Difference::between(earlier, later)));
                }
            }
        }
        found
    }

    fn load(&self) -> Vec<Difference> {
        let stages = self.stages();
        let pairs = self.surfaces().into_iter().flat_map(|surface| stages.iter().map(move |stage| (surface, *stage)));
        pairs
            .filter_map(|(surface, stage)| {
                let unloaded = self.at(surface, stage, LoadCase::Unloaded)?;
                let loaded = self.at(surface, stage, LoadCase::Loaded)?;
                Some(Difference::between(unloaded, loaded))
            })
            .collect()
    }
}

fn order(set: &Set) -> Difference {
    let second = Set { model: Model { order: Order::Second, ..set.model.clone() }, ..set.clone() };
    Difference::between(set, &Set { label: format!("{}, second order", set.label), ..second })
}
