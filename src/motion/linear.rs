//! The drive over a piece that one mode holds through: which mode, and whether it holds as far as both ends of the piece tell.

use super::{
    forcing::DriveOperation,
    loop_terms::{DriveState, LoopTerms},
    mode::{DriveMode, MotionMode},
};
use crate::series::Range;

/// The greatest product of the drive's natural frequency and the length of a piece that its ends describe: a quarter of a period.
pub const LONGEST_BETWEEN_ENDS: f64 = 1.5;

/// Between the ends of a piece the acceleration goes beyond those at the ends by this share of them, or more.
const LEAST_BEYOND: f64 = 0.25;

/// What acts on the drive and how it moves, at the start and at the end of a piece.
#[derive(Debug, Clone, Copy)]
pub struct Ends {
    /// Target of the servo [deg].
    pub target: [f64; 2],
    /// How far the target may be from the straight line between its ends; none where it goes over to its end at once or less fast, and
    /// ever more slowly.
    pub target_bend: Option<f64>,
    /// [deg]
    pub load: [f64; 2],
    /// Position and rate.
    pub drive: [DriveState; 2],
}

impl DriveMode {
    /// Gain and constant [deg] of the force ω² (gain × error + constant) in this mode; none where a limit, friction or a failure holds the
    /// rate.
    #[must_use]
    pub fn linear_force(&self, terms: &LoopTerms) -> Option<(f64, f64)> {
        let MotionMode::Free(direction) = self.motion else { return None };
        Some((self.branch.gain, self.branch.offset + terms.bias - direction * terms.friction))
    }

    /// The rate that this mode holds [deg/s], or else this one.
    #[must_use]
    pub fn rate_or_held(&self, rate: f64) -> f64 {
        if matches!(self.motion, MotionMode::Free(_)) { rate } else { self.motion.held_rate() }
    }
}

impl LoopTerms {
    /// The mode of an active drive in this state.
    #[must_use]
    #[inline(always)]
    pub fn active_mode(&self, from: &DriveState, target: f64, load: f64) -> DriveMode {
        let branch = self.servo_branch(target - from.position, DriveOperation::Active);
        let force = self.instantaneous_force(&branch, target, load, from);
        DriveMode { branch, motion: self.motion_mode(from, force, DriveOperation::Active) }
    }

    /// By which share the acceleration goes beyond those at the ends of a piece of this length [s]: cos(ω t) beyond what it is half a piece away
    /// from its peak.
    #[must_use]
    pub fn acceleration_beyond_ends(&self, length: f64) -> f64 {
        let half = (0.5 * self.natural_frequency(0.0) * length).min(0.5 * LONGEST_BETWEEN_ENDS);
        (1.0 / half.cos() - 1.0).max(LEAST_BEYOND)
    }

    /// Where position and rate of the drive are during a piece of this length [s], if this mode holds all through it as far as its ends
    /// tell and as far as the acceleration goes beyond those at the ends; none where it may not.
    ///
    /// A signal is as far from the straight line between its ends as its bend allows: h²/8 of the second derivative, or h/4 of what the
    /// first one changes by. What is linear in a target that goes over to its end, and in a line, is between its values at the start, at the start
    /// with the target at its end, and at the end.
    #[must_use]
    pub fn reach(&self, mode: &DriveMode, ends: &Ends, length: f64, beyond: f64) -> Option<[Range; 2]> {
        let conditions = self.conditions(&mode.branch, mode.motion);
        let Ends { target: [target, next], target_bend, load, drive: [from, to] } = *ends;
        let jumped = if target_bend.is_none() { next } else { target };
        let points = [(target, load[0], from), (jumped, load[0], from), (next, load[1], to)];
        let of_target = target_bend.unwrap_or(0.0);
        let forces = points.map(|(target, load, drive)| self.instantaneous_force(&mode.branch, target, load, &drive));
        let forces = around(forces, self.omega2 * mode.branch.gain * of_target);
        let (mut bend, mut turn) = (0.0, 0.0);
        if let MotionMode::Free(direction) = mode.motion {
            let friction = direction * self.omega2 * self.friction;
            let largest = (forces.low - friction).abs().max((forces.high - friction).abs());
            bend = 0.125 * (1.0 + beyond) * largest * length * length;
            turn = 0.25 * (forces.high - forces.low + beyond * largest) * length;
        } else if !conditions.force.holds(forces) {
            return None;
        }
        let position = around([from.position, to.position], bend);
        let rate = around([from.rate, to.rate], turn);
        let errors = around(points.map(|(target, _, drive)| target - drive.position), of_target + bend);
        let holds =
            conditions.position.holds(position) && conditions.rate.holds(rate) && conditions.error.holds(errors);
        holds.then_some([position, rate])
    }
}

/// The range of these values, and so far beyond.
fn around<const N: usize>(values: [f64; N], beyond: f64) -> Range {
    // Of a comparison alone a processor makes one instruction, unlike of `f64::min`, which asks for what is no number.
    let low = values.iter().skip(1).fold(values[0], |low, value| if *value < low { *value } else { low });
    let high = values.iter().skip(1).fold(values[0], |high, value| if *value > high { *value } else { high });
    Range { low: low - beyond, high: high + beyond }
}
