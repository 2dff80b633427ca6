//! Dependencies of outputs, derivatives and initial unknowns.

use actuator_fmu::{
    effects::{Act, CHAIN, Effects},
    fmu::variables::{Kind as Type, Slot, variables},
};

/// Parameters of effects with a direct influence on the measurement.
fn is_reading(slot: Slot) -> bool {
    let Slot::Effect(index) = slot else { return false };
    Effects::parameters().nth(index).is_some_and(|(effect, _)| matches!(effect.act, Act::Reading { .. }))
}

/// States of the effects behind the drive are numbered after those of the drive.
fn behind(state: usize) -> bool {
    state >= DRIVE_STATES
}

const TARGET: usize = 0;
const POSITION: usize = 1;
const RATE: usize = 2;
const DRIVE_STATES: usize = 3;

/// Quantities that are zero at rest.
fn is_rate(slot: Slot) -> bool {
    let unit_is_that_of_a_rate = |kind: &Type| matches!(kind, Type::Real { unit: "deg/s", .. });
    variables().iter().any(|variable| variable.slot == slot && unit_is_that_of_a_rate(&variable.kind))
}

/// States of effects ahead of the sensor.
fn is_of_surface(state: usize) -> bool {
    let sizes = CHAIN.iter().filter(|effect| matches!(effect.act, Act::Surface(_))).map(|effect| effect.memory);
    behind(state) && state < DRIVE_STATES + sizes.sum::<usize>()
}

/// Outputs depend on the states, and on the inputs by way of the last step of co-simulation: these are the partial derivatives that an
/// instance provides. Every effect behind the drive has the drive and the effects ahead of it as inputs.
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

/// In initialization mode, for all but derivatives.
pub(super) fn depends_initially(unknown: Slot, known: Slot) -> bool {
    let is_selector = matches!(known, Slot::Surface | Slot::Stage | Slot::LoadCase | Slot::SetNumber | Slot::Source);
    match unknown {
        Slot::Active(index) => is_selector || known == Slot::Custom(index),
        Slot::Rate | Slot::Saturated => false,
        Slot::State(_) if is_rate(unknown) => false,
        // Values determined by the rest position.
        Slot::Position => known == Slot::InitialPosition || is_reading(known),
        _ => known == Slot::InitialPosition,
    }
}
