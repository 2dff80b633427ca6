//! The drive for ODE solvers: modes are selected at events and constant between them, so that the right-hand side is smooth; event
//! indicators change sign where a mode ends.

use super::{
    forcing::{DriveOperation, InstantaneousForcing},
    loop_terms::{DriveState, LoopTerms},
    mode::{DriveMode, ModeConditions, MotionMode},
};

/// Look-ahead of mode selection [s]: a solver may stop exactly at the end of a branch, where only the derivatives determine the next mode.
/// It is nine orders of magnitude shorter than 1/ω.
const LOOK_AHEAD_S: f64 = 1e-12;

/// Minimum look-ahead of a moving quantity in roundings, so that slow motion is treated like fast motion.
const LOOK_AHEAD_ROUNDINGS: f64 = 8.0 * f64::EPSILON;

/// The change of a quantity over the look-ahead, from its rate and the magnitude of the terms of which it is the difference.
fn change_ahead(rate: f64, magnitude: f64) -> f64 {
    let change = rate * LOOK_AHEAD_S;
    if rate == 0.0 { 0.0 } else { rate.signum() * change.abs().max(LOOK_AHEAD_ROUNDINGS * magnitude) }
}

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
            drive.rate = self.conditions(&branch, motion).rate.nearest(drive.rate);
        }
        let into_stop =
            drive.position >= self.max && drive.rate > 0.0 || drive.position <= self.min && drive.rate < 0.0;
        if into_stop || forcing.operation == DriveOperation::Stuck {
            drive.rate = 0.0;
        }
        let InstantaneousForcing { target, load, slopes, .. } = forcing;
        let magnitude = target.abs().max(drive.position.abs()).max(load.abs());
        let error = target - drive.position + change_ahead(slopes[0] - drive.rate, magnitude);
        let next = DriveState { position: drive.position + drive.rate * LOOK_AHEAD_S, ..drive };
        let branch = self.servo_branch(error, forcing.operation);
        let load = load + change_ahead(slopes[1], magnitude);
        let force = self.instantaneous_force(&branch, next.position + error, load, &next);
        (drive, DriveMode { branch, motion: self.motion_mode(&drive, force, forcing.operation) })
    }

    /// Derivatives of position [deg/s] and rate [deg/s²].
    #[must_use]
    pub fn derivatives(&self, mode: DriveMode, from: DriveState, forcing: InstantaneousForcing) -> [f64; 2] {
        match mode.motion {
            MotionMode::Free(direction) => {
                let force = self.instantaneous_force(&mode.branch, forcing.target, forcing.load, &from);
                [from.rate, force - direction * self.omega2 * self.friction]
            }
            MotionMode::RateLimited(rate) => [rate, 0.0],
            MotionMode::Sticking | MotionMode::AtStop(_) | MotionMode::Stuck => [0.0, 0.0],
        }
    }

    /// Event indicators: distances from the ends of the conditions of this mode \[deg\], negative if a condition no longer holds, positive at
    /// the start of the mode.
    #[must_use]
    pub fn event_indicators(
        &self,
        mode: DriveMode,
        from: DriveState,
        forcing: InstantaneousForcing,
    ) -> [f64; Self::EVENT_INDICATORS] {
        let ModeConditions { error, position, force, rate } = self.conditions(&mode.branch, mode.motion);
        let sum_of_forces = self.instantaneous_force(&mode.branch, forcing.target, forcing.load, &from);
        let [a, b] = error.distances(forcing.target - from.position, 1.0);
        let [c, d] = position.distances(from.position, 1.0);
        let [e, f] = force.distances(sum_of_forces, self.omega2);
        let [g, h] = rate.distances(from.rate, self.omega2.sqrt());
        [a, b, c, d, e, f, g, h]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSITION_DEG: f64 = 10.0;

    /// Motion mode of a drive at rest whose force equals its friction, for a target moving at this rate [deg/s].
    fn at_breakaway(slope: f64) -> MotionMode {
        let terms = LoopTerms { friction: 0.25, ..LoopTerms::linear(128.0, 0.5) };
        let from = DriveState { position: POSITION_DEG, rate: 0.0 };
        let target = POSITION_DEG + terms.friction * slope.signum();
        let forcing =
            InstantaneousForcing { target, load: 0.0, slopes: [slope, 0.0], operation: DriveOperation::Active };
        terms.select_mode(None, from, forcing).1.motion
    }

    /// A solver that stopped at the end of a mode must not get the same mode again, however slow the motion: at 10 deg, 1e-12 s at less
    /// than 1e-3 deg/s are below rounding.
    #[test]
    fn slow_motion_leaves_a_mode_as_fast_motion_does() {
        for slope in [1e3, 1.0, 1e-3, 1e-4, 1e-6, 1e-12] {
            assert_eq!(at_breakaway(slope), MotionMode::Free(1.0), "{slope} deg/s");
            assert_eq!(at_breakaway(-slope), MotionMode::Free(-1.0), "{} deg/s", -slope);
        }
    }

    #[test]
    fn slow_motion_enters_a_branch_as_fast_motion_does() {
        let terms = LoopTerms { dead_zone: 0.25, ..LoopTerms::linear(128.0, 0.5) };
        for rate in [1e3, 1.0, 1e-3, 1e-4, 1e-6, 1e-12] {
            // The drive moves away from a fixed target, and out of the dead zone; then back into it.
            for (rate, gain) in [(rate, 1.0), (-rate, 0.0)] {
                let from = DriveState { position: POSITION_DEG + terms.dead_zone, rate };
                let forcing = InstantaneousForcing {
                    target: POSITION_DEG,
                    load: 0.0,
                    slopes: [0.0; 2],
                    operation: DriveOperation::Active,
                };
                assert_eq!(terms.select_mode(None, from, forcing).1.branch.gain, gain, "{rate} deg/s");
            }
        }
    }
}
