//! `ModelStructure`: outputs, derivatives and initial unknowns, and what they depend on.

use serde::Serialize;

use actuator_fmu::{
    effects::{Act, CHAIN, Effects},
    fmu::variables::{Causality, Kind as Type, Slot, Variable, variables},
};

#[derive(Serialize)]
pub(super) struct ModelStructure {
    #[serde(rename = "Outputs")]
    outputs: Unknowns,
    #[serde(rename = "Derivatives")]
    derivatives: Unknowns,
    #[serde(rename = "InitialUnknowns")]
    initial_unknowns: Unknowns,
}

#[derive(Serialize)]
struct Unknowns {
    #[serde(rename = "Unknown")]
    all: Vec<Unknown>,
}

#[derive(Serialize)]
struct Unknown {
    #[serde(rename = "@index")]
    index: usize,
    /// Left out: everything.
    #[serde(rename = "@dependencies", skip_serializing_if = "Option::is_none")]
    dependencies: Option<String>,
}

/// Indices, counted from 1, of the variables that hold these quantities.
fn indices(wanted: impl Fn(Slot) -> bool) -> String {
    let numbers: Vec<String> = variables()
        .iter()
        .zip(1..)
        .filter(|(variable, _)| wanted(variable.slot))
        .map(|(_, index)| index.to_string())
        .collect();
    numbers.join(" ")
}

/// Parameters of effects that act on the measurement at once.
fn is_reading(slot: Slot) -> bool {
    let Slot::Effect(index) = slot else { return false };
    Effects::parameters().nth(index).is_some_and(|(effect, _)| matches!(effect.act, Act::Reading { .. }))
}

/// What the effects behind the drive remember is numbered after the states of the drive.
fn behind(state: usize) -> bool {
    state >= DRIVE_STATES
}

const TARGET: usize = 0;
const POSITION: usize = 1;
const RATE: usize = 2;
const DRIVE_STATES: usize = 3;

/// What is zero at rest.
fn is_rate(slot: Slot) -> bool {
    let unit_is_that_of_a_rate = |kind: &Type| matches!(kind, Type::Real { unit: "deg/s", .. });
    variables().iter().any(|variable| variable.slot == slot && unit_is_that_of_a_rate(&variable.kind))
}

/// States of effects ahead of the sensor.
fn is_of_surface(state: usize) -> bool {
    let sizes = CHAIN.iter().filter(|effect| matches!(effect.act, Act::Surface(_))).map(|effect| effect.memory);
    behind(state) && state < DRIVE_STATES + sizes.sum::<usize>()
}

/// On the states, and on the inputs by way of the last step of co-simulation: those are the partial derivatives that an instance gives.
fn output_dependencies(slot: Slot) -> String {
    indices(|other| match (slot, other) {
        (Slot::Position, Slot::State(state)) => state == POSITION || behind(state),
        (Slot::Deflection, Slot::State(state)) => state == POSITION || is_of_surface(state),
        (Slot::Rate, Slot::State(state)) => state == RATE,
        (Slot::Position | Slot::Deflection | Slot::Rate, Slot::Command | Slot::Load) => true,
        _ => false,
    })
}

/// Every effect behind the drive has the drive and those ahead of it for an input.
fn derivative_dependencies(slot: Slot) -> String {
    let Slot::Slope(of) = slot else { return String::new() };
    indices(|other| match (of, other) {
        (TARGET, Slot::State(state)) => state == TARGET,
        (POSITION, Slot::State(state)) => state == RATE,
        (RATE, Slot::State(state)) => state < DRIVE_STATES,
        (TARGET | RATE, Slot::Command) | (RATE, Slot::Load) => true,
        (of, Slot::State(state)) => behind(of) && (POSITION..=of).contains(&state),
        _ => false,
    })
}

/// What depends on what.
pub(super) fn structure() -> ModelStructure {
    let unknowns = |wanted: fn(&Variable) -> bool, dependencies: &dyn Fn(Slot) -> Option<String>| Unknowns {
        all: variables()
            .iter()
            .zip(1..)
            .filter(|(variable, _)| wanted(variable))
            .map(|(variable, index)| Unknown { index, dependencies: dependencies(variable.slot) })
            .collect(),
    };
    let selectors =
        |slot| matches!(slot, Slot::Surface | Slot::Stage | Slot::LoadCase | Slot::SetNumber | Slot::Source);
    ModelStructure {
        outputs: unknowns(|variable| variable.causality == Causality::Output, &|slot| Some(output_dependencies(slot))),
        derivatives: unknowns(|variable| matches!(variable.slot, Slot::Slope(_)), &|slot| {
            Some(derivative_dependencies(slot))
        }),
        initial_unknowns: unknowns(
            |variable| {
                matches!(variable.causality, Causality::Output | Causality::CalculatedParameter | Causality::Local)
            },
            &|slot| match slot {
                Slot::Active(index) => Some(indices(|other| selectors(other) || other == Slot::Custom(index))),
                Slot::Rate | Slot::Saturated => Some(String::new()),
                Slot::State(_) if is_rate(slot) => Some(String::new()),
                // What is read off at rest.
                Slot::Position => Some(indices(|other| other == Slot::InitialPosition || is_reading(other))),
                // Any effect may act on the forces at the start, and any parameter selects them.
                Slot::Slope(_) => None,
                _ => Some(indices(|other| other == Slot::InitialPosition)),
            },
        ),
    }
}
