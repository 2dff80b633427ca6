//! The variables of the FMU: one list, from which value references, checks and XML are derived.
//!
//! The value reference of a variable is its index in [`variables`]. Units are those for positions in deg; for an FMU in another position
//! unit, [`PositionUnit::derived`](crate::parameters::PositionUnit::derived) gives their names and [`units`](super::units) defines them.

use std::sync::OnceLock;

pub use fmi_export::{Causality, Enumeration, Type as Kind, Variability};

use crate::{
    actuator::Failure,
    effects::{CHAIN, Effects},
    operator::StateVariable,
    parameters::{Base, LoadCase, Order, Stage, Surface},
};

use super::settings::Source;

/// Enumerations of the selectors.
pub static ENUMERATIONS: [Enumeration; 6] = [
    Enumeration { name: "Surface", description: "control surface", items: Surface::NAMES },
    Enumeration { name: "Stage", description: "stage of the wind-tunnel test (wear)", items: Stage::NAMES },
    Enumeration { name: "LoadCase", description: "aerodynamic load case", items: LoadCase::NAMES },
    Enumeration { name: "Order", description: "order of the transfer function", items: Order::NAMES },
    Enumeration { name: "Failure", description: "failure of the drive", items: Failure::NAMES },
    Enumeration { name: "Source", description: "where the parameters come from", items: Source::NAMES },
];

/// Quantity of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // described by the variables themselves
pub enum Slot {
    Command,
    Load,
    Failure,
    Position,
    Deflection,
    Rate,
    Saturated,
    Surface,
    Stage,
    LoadCase,
    SetNumber,
    Order,
    Source,
    /// Index into [`Base::PARAMETERS`].
    Custom(usize),
    /// Index into [`Base::PARAMETERS`].
    Active(usize),
    InitialPosition,
    /// Index into [`Effects::parameters`].
    Effect(usize),
    /// Continuous state.
    State(usize),
    /// Derivative of a continuous state.
    Slope(usize),
}

/// One variable.
pub type Variable = fmi_export::Variable<Slot>;

/// The list of variables.
pub type Variables = fmi_export::Variables<Slot>;

/// All variables, in the order of their value references.
#[must_use]
pub fn variables() -> &'static Variables {
    static VARIABLES: OnceLock<Variables> = OnceLock::new();
    VARIABLES.get_or_init(|| Variables::new(list()))
}

/// Number of the last tabulated set.
pub const LAST_SET_NUMBER: i32 = 17;

fn list() -> Vec<Variable> {
    use {Causality::*, Variability::*};
    let angle = |range| Kind::Real { unit: "deg", range, nominal: Some(1.0) };
    let variable = |name: &str, description: &str, causality, variability, kind, slot| Variable {
        name: name.into(),
        description: description.into(),
        causality,
        variability,
        kind,
        slot,
    };
    let [surface, stage, load_case, order, failure, source] = &ENUMERATIONS;
    let rate = Kind::Real { unit: "deg/s", range: None, nominal: Some(100.0) };
    let set_number = Kind::Integer { min: 0, max: LAST_SET_NUMBER };
    let mut all = vec![
        variable("command", "actuator command", Input, Continuous, angle(None), Slot::Command),
        variable(
            "load",
            "external hinge load, as the static deflection it causes without hinge_load.stiffness; 0 = none",
            Input,
            Continuous,
            angle(None),
            Slot::Load,
        ),
        variable("failure", "injected failure", Input, Discrete, Kind::Enumeration(failure), Slot::Failure),
        variable(
            "position",
            "measured surface position, behind the sensor",
            Output,
            Continuous,
            angle(None),
            Slot::Position,
        ),
        variable(
            "deflection",
            "surface deflection itself, ahead of the sensor",
            Output,
            Continuous,
            angle(None),
            Slot::Deflection,
        ),
        variable("rate", "rate of the drive", Output, Continuous, rate, Slot::Rate),
        variable(
            "saturated",
            "a rate, acceleration or position limit is active, at any time within the last step",
            Output,
            Discrete,
            Kind::Boolean,
            Slot::Saturated,
        ),
        variable(
            "surface",
            "control surface of the tabulated set",
            Parameter,
            Fixed,
            Kind::Enumeration(surface),
            Slot::Surface,
        ),
        variable(
            "stage",
            "stage of the wind-tunnel test (wear) of the tabulated set",
            Parameter,
            Fixed,
            Kind::Enumeration(stage),
            Slot::Stage,
        ),
        variable(
            "load_case",
            "aerodynamic load case of the tabulated set",
            Parameter,
            Fixed,
            Kind::Enumeration(load_case),
            Slot::LoadCase,
        ),
        variable(
            "set_number",
            "tabulated set by number: 0 = surface, stage and load_case select; 1 to 9 = rows of table 1, 10 to 17 = rows of table 2 of NASA/TM-1998-208452, top to bottom without the N/A row",
            Parameter,
            Fixed,
            set_number,
            Slot::SetNumber,
        ),
        variable(
            "order",
            "order of the transfer function: second = eq. (6), third = eq. (1) of NASA/TM-1998-208452",
            Parameter,
            Fixed,
            Kind::Enumeration(order),
            Slot::Order,
        ),
        variable(
            "source",
            "table = the tabulated set, custom = the four custom values",
            Parameter,
            Fixed,
            Kind::Enumeration(source),
            Slot::Source,
        ),
    ];
    for (prefix, causality, slot) in [
        ("custom", Parameter, Slot::Custom as fn(usize) -> Slot),
        ("active", CalculatedParameter, Slot::Active as fn(usize) -> Slot),
    ] {
        for (index, parameter) in Base::PARAMETERS.iter().enumerate() {
            let use_of = if prefix == "custom" { "used when source = custom" } else { "in use" };
            let range = (prefix == "custom").then_some((parameter.min, parameter.max));
            let kind = Kind::Real { unit: parameter.unit, range, nominal: Some(parameter.nominal) };
            let name = format!("{prefix}.{}", parameter.name);
            let description = format!("{} {use_of}", parameter.meaning);
            all.push(variable(&name, &description, causality, Tunable, kind, slot(index)));
        }
    }
    all.push(variable(
        "initial_position",
        "position at which the actuator starts at rest",
        Parameter,
        Fixed,
        angle(None),
        Slot::InitialPosition,
    ));
    for (index, (effect, parameter)) in Effects::parameters().enumerate() {
        let kind = Kind::Real {
            unit: parameter.unit,
            range: Some((parameter.min, parameter.max)),
            nominal: Some(parameter.nominal),
        };
        let name = format!("{}.{}", effect.name, parameter.name);
        let description = format!("{} ({}: {})", parameter.meaning, effect.act.place(), effect.summary);
        all.push(variable(&name, &description, Parameter, Tunable, kind, Slot::Effect(index)));
    }
    for (index, ContinuousState { name, unit, nominal, meaning }) in continuous_states().enumerate() {
        let kind = Kind::Real { unit, range: None, nominal: Some(nominal) };
        all.push(variable(&name, &meaning, Local, Continuous, kind, Slot::State(index)));
    }
    for (index, ContinuousState { name, unit, .. }) in continuous_states().enumerate() {
        let kind = Kind::Real { unit: per_second(unit), range: None, nominal: None };
        let meaning = format!("derivative of {name}");
        all.push(variable(&format!("der({name})"), &meaning, Local, Continuous, kind, Slot::Slope(index)));
    }
    all
}

/// A continuous state.
struct ContinuousState {
    name: String,
    unit: &'static str,
    nominal: f64,
    meaning: String,
}

/// States of the drive, then those of the output effects.
fn continuous_states() -> impl Iterator<Item = ContinuousState> {
    let drive = [
        (
            "drive.target",
            "deg",
            1.0,
            "pole state x of eq. (1); with order = second it stands still, x is then k times the command",
        ),
        ("drive.position", "deg", 1.0, "position of the drive"),
        ("drive.rate", "deg/s", 100.0, "rate of the drive"),
    ];
    let drive = drive.into_iter().map(|(name, unit, nominal, meaning)| ContinuousState {
        name: name.into(),
        unit,
        nominal,
        meaning: meaning.into(),
    });
    let behind = CHAIN.iter().flat_map(|effect| effect.state_variables().map(move |(_, variable)| (effect, variable)));
    drive.chain(behind.map(|(effect, StateVariable { name, unit, nominal, meaning })| ContinuousState {
        name: format!("{}.{name}", effect.name),
        unit,
        nominal,
        meaning: format!("{meaning} ({}: {})", effect.act.place(), effect.summary),
    }))
}

fn per_second(unit: &str) -> &'static str {
    match unit {
        "deg" => "deg/s",
        "deg/s" => "deg/s2",
        _ => "1/s",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique() {
        for variable in variables() {
            assert_eq!(variables().iter().filter(|other| other.name == variable.name).count(), 1, "{}", variable.name);
        }
    }
}
