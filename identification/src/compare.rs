//! How much actuators differ in what matters to a control law: wear and load, for the tabulated sets or for fitted ones.
//!
//! Two responses H_a and H_b differ by |H_b| - |H_a| in magnitude and by the angle of H_b conj(H_a) in phase: an angle of the
//! quotient, never a difference of two unwrapped phases. The report (NASA/TM-1998-208452) calls more than 0.1 and more
//! than 3 deg unacceptable, a tenth of usual gain and phase margins, and looks at 0.5 to 12 Hz, its data, and at 3 to 5 Hz,
//! where the wing's modes lie.
//!
//! [`Comparison::of_tables`] also checks what the report says against what its tables say: [`statements`].

mod condition;
mod difference;
pub mod experiment;
pub mod statements;
pub mod tunnel;

use nalgebra::Complex;
use serde::{Serialize, Serializer, ser::SerializeStruct};

use crate::frequency::response;
use actuator_fmu::parameters::{Base, LoadCase, Model, Order, SOURCE, SetName, Stage, Surface, table};
pub use condition::Condition;
pub use difference::{AEROELASTIC_BAND_HZ, Difference, Extreme, InBand, LIMITS, Limits, POINTS_PER_HZ};
pub use statements::{Statement, Verdict};

/// A model and what it is called; its condition where it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Set {
    /// Set name or file.
    pub label: String,
    /// Surface, stage and load case.
    pub condition: Option<Condition>,
    /// The dynamics.
    pub model: Model,
    /// Delay between command and actuator [s].
    pub delay_s: f64,
    /// Covariance of ln |k|, ln ω, ln ζ, the lag 1/p [s] and the delay [s], where they were estimated.
    pub covariance: Option<[[f64; 5]; 5]>,
}

impl Set {
    /// A model of which neither condition nor covariance is known.
    #[must_use]
    pub fn new(label: impl Into<String>, model: Model) -> Self {
        Self { label: label.into(), condition: None, model, delay_s: 0.0, covariance: None }
    }
}

impl Set {
    /// Its response at a frequency [Hz], delay included.
    #[must_use]
    pub fn response(&self, frequency_hz: f64) -> Complex<f64> {
        let lag = Complex::from_polar(1.0, -std::f64::consts::TAU * frequency_hz * self.delay_s);
        response(&self.model.base, self.model.order, frequency_hz) * lag
    }
}

impl Serialize for Set {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Set", 7)?;
        fields.serialize_field("label", &self.label)?;
        fields.serialize_field("order", self.model.order.short())?;
        for (parameter, value) in Base::PARAMETERS.iter().zip(self.model.base.values()) {
            fields.serialize_field(parameter.name, &value)?;
        }
        fields.serialize_field("delay_s", &self.delay_s)?;
        fields.end()
    }
}

/// Differences between sets, by what makes them differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Where the sets come from.
    pub source: String,
    /// What is compared.
    pub sets: Vec<Set>,
    /// What is allowed.
    pub limits: Limits,
    /// Same surface and load case, a later stage against an earlier one.
    pub wear: Vec<Difference>,
    /// Same surface and stage, loaded against unloaded.
    pub load: Vec<Difference>,
    /// Third order against second order with the same k, ω and ζ: what leaving out the pole does. Third-order sets only.
    pub order: Vec<Difference>,
    /// Every other set against the first, where a condition is not known.
    pub against_first: Vec<Difference>,
    /// What the report says; for its own tables only.
    pub statements: Vec<Statement>,
}

impl Comparison {
    /// Tables 1 and 2 of the report.
    #[must_use]
    pub fn of_tables() -> Self {
        let sets = table()
            .iter()
            .map(|set| Set {
                label: set.name.to_string(),
                condition: Some(set.name.into()),
                ..Set::new("", Model::from_set(set))
            })
            .collect();
        let mut comparison = Self::of(SOURCE, sets);
        comparison.statements = statements::of(&comparison);
        comparison
    }

    /// Any sets. Where each has a condition and no two have the same, wear and load are compared; otherwise all against the
    /// first.
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

    /// The set of one of the report's conditions.
    #[must_use]
    pub fn set(&self, surface: Surface, stage: Stage, load_case: LoadCase) -> Option<&Set> {
        self.find(&SetName { surface, stage, load_case }.into())
    }

    /// The set of a condition.
    #[must_use]
    pub fn find(&self, condition: &Condition) -> Option<&Set> {
        self.sets.iter().find(|set| set.condition.as_ref() == Some(condition))
    }

    /// Surfaces, each once: the report's in its order, then others as they come.
    #[must_use]
    pub fn surfaces(&self) -> Vec<&str> {
        self.words(|condition| &condition.surface, Surface::NAMES)
    }

    /// Stages, each once: the report's in its order, then others as they come.
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
