//! What outputs, derivatives and initial unknowns depend on.

use actuator_fmu::{
    effects::{Act, CHAIN, Effects},
    fmu::variables::{Kind as Type, Slot, variables},
};

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

/// Outputs depend on the states, and on the inputs by way of the last step of co-simulation: those are the partial derivatives that an
/// instance gives. Every effect behind the drive has the drive and those ahead of it for an input.
pub(super) fn depends(unknown: Slot, known: Slot) -> bool {
    match (unknown, known) {
        (Slot::Position, Slot::State(state)) => state == POSITION || behind(state),
        (Slot::Deflection, Slot::State(state)) => state == POSITION || is_of_surface(state),
        (Slot::Rate, Slot::State(state)) => state == RATE,
        (Slot::Position | Slot::Deflection | Slot::Rate, Slot::Command | Slot::Load) => true,
        (Slot::Slope(TARGET), Slot::State(state)) => state == TARGET,
        (Slot::Slope(POSITION), Slot::State(state)) => state == RATE,
        (Slot::Slope(RATE), Slot::State(state)) => state < DRIVE_STATES,
        (Slot::Slope(TARGET | RATE), Slot::Command) | (Slot::Slope(RATE), Slot::Load) => true,
        (Slot::Slope(of), Slot::State(state)) => behind(of) && (POSITION..=of).contains(&state),
        _ => false,
    }
}

/// In initialization mode, of all but derivatives.
pub(super) fn depends_initially(unknown: Slot, known: Slot) -> bool {
    let is_selector = matches!(known, Slot::Surface | Slot::Stage | Slot::LoadCase | Slot::SetNumber | Slot::Source);
    match unknown {
        Slot::Active(index) => is_selector || known == Slot::Custom(index),
        Slot::Rate | Slot::Saturated => false,
        Slot::State(_) if is_rate(unknown) => false,
        // What is read off at rest.
        Slot::Position => known == Slot::InitialPosition || is_reading(known),
        _ => known == Slot::InitialPosition,
    }
}
