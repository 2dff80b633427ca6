//! The drive for a solver that integrates: modes are selected at events and constant between them, so that the right-hand side is
//! smooth; event indicators change their sign where a mode ends.

use super::{
    forcing::{DriveOperation, InstantaneousForcing},
    loop_terms::{DriveState, LoopTerms},
    mode::{DriveMode, ModeConditions, MotionMode},
};
use crate::series::Range;

/// Modes are selected for the state this much later [s]: a solver may stop exactly at the end of a branch, where the derivatives
/// decide. At a rate of 1 deg/s it changes the position by some thousand roundings of 1 deg, and it is nine orders of magnitude
/// shorter than 1/ω.
const LOOK_AHEAD_S: f64 = 1e-12;

impl LoopTerms {
    /// Number of event indicators of the drive.
    pub const EVENT_INDICATORS: usize = 8;

    /// Selects the mode after an event and projects the state onto it: at a limit the state equals the limit exactly.
    #[must_use]
    pub fn select_mode(
        &self,
        before: Option<DriveMode>,
        from: DriveState,
        forcing: InstantaneousForcing,
    ) -> (DriveState, DriveMode) {
        let mut drive = self.clamped_to_limits(from);
        if let Some(DriveMode { branch, motion }) = before {
            let Range { low, high } = self.conditions(branch, motion).rate;
            drive.rate = drive.rate.clamp(low, high);
        }
        let into_stop =
            drive.position >= self.max && drive.rate > 0.0 || drive.position <= self.min && drive.rate < 0.0;
        if into_stop || forcing.operation == DriveOperation::Stuck {
            drive.rate = 0.0;
        }
        let next = DriveState { position: drive.position + drive.rate * LOOK_AHEAD_S, ..drive };
        let [target, load] = [forcing.target, forcing.load];
        let [target, load] = [target + forcing.slopes[0] * LOOK_AHEAD_S, load + forcing.slopes[1] * LOOK_AHEAD_S];
        let branch = self.servo_branch(target - next.position, forcing.operation);
        let force = self.instantaneous_force(branch, target, load, next);
        (drive, DriveMode { branch, motion: self.motion_mode(drive, force, forcing.operation) })
    }

    /// Derivatives of position [deg/s] and rate [deg/s²].
    #[must_use]
    pub fn derivatives(&self, mode: DriveMode, from: DriveState, forcing: InstantaneousForcing) -> [f64; 2] {
        match mode.motion {
            MotionMode::Free(direction) => {
                let force = self.instantaneous_force(mode.branch, forcing.target, forcing.load, from);
                [from.rate, force - direction * self.omega2 * self.friction]
            }
            MotionMode::RateLimited(rate) => [rate, 0.0],
            MotionMode::Sticking | MotionMode::AtStop(_) | MotionMode::Stuck => [0.0, 0.0],
        }
    }

    /// Event indicators: distances from the ends of the conditions of this mode, negative where one no longer holds.
    #[must_use]
    pub fn event_indicators(
        &self,
        mode: DriveMode,
        from: DriveState,
        forcing: InstantaneousForcing,
    ) -> [f64; Self::EVENT_INDICATORS] {
        let ModeConditions { error, position, force, rate } = self.conditions(mode.branch, mode.motion);
        let sum_of_forces = self.instantaneous_force(mode.branch, forcing.target, forcing.load, from);
        let [a, b] = error.distances(forcing.target - from.position);
        let [c, d] = position.distances(from.position);
        let [e, f] = force.distances(sum_of_forces);
        let [g, h] = rate.distances(from.rate);
        [a, b, c, d, e, f, g, h]
    }
}
