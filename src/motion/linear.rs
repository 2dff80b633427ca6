//! The drive over a piece without a change of mode: which mode, and whether it holds, judged from both ends of the piece.

use super::{
    forcing::DriveOperation,
    loop_terms::{DriveState, LoopTerms},
    mode::{DriveMode, MotionMode},
};
use crate::series::Range;

/// Maximum product of the drive's natural frequency and the piece length for which the ends describe a piece: a quarter of a period.
pub const LONGEST_BETWEEN_ENDS: f64 = 1.5;

/// Minimum relative excess of the acceleration within a piece over that at its ends.
const LEAST_BEYOND: f64 = 0.25;

/// Inputs and motion of the drive at the start and at the end of a piece.
#[derive(Debug, Clone, Copy)]
pub struct Ends {
    /// Target of the servo \[deg\].
    pub target: [f64; 2],
    /// Maximum distance of the target from the straight line between its ends; `None` if it approaches its final value immediately or with
    /// monotonically decreasing rate.
    pub target_bend: Option<f64>,
    /// \[deg\]
    pub load: [f64; 2],
    /// Position and rate.
    pub drive: [DriveState; 2],
}

impl DriveMode {
    /// Gain and constant \[deg\] of the force ω² (gain × error + constant) in this mode; `None` if a limit, friction or a failure determines
    /// the rate.
    #[must_use]
    pub fn linear_force(&self, terms: &LoopTerms) -> Option<(f64, f64)> {
        let MotionMode::Free(direction) = self.motion else { return None };
        Some((self.branch.gain, self.branch.offset + terms.bias - direction * terms.friction))
    }

    /// The rate held in this mode [deg/s]; in a free mode, this one.
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

    /// Relative excess of the acceleration within a piece of this length \[s\] over that at its ends: that of the peak of cos(ω t) over its
    /// value half a piece away.
    #[must_use]
    pub fn acceleration_beyond_ends(&self, length: f64) -> f64 {
        let half = (0.5 * self.natural_frequency(0.0) * length).min(0.5 * LONGEST_BETWEEN_ENDS);
        (1.0 / half.cos() - 1.0).max(LEAST_BEYOND)
    }

    /// Ranges of position and rate during a piece of this length \[s\], if this mode holds throughout, judged from the ends with the excess
    /// acceleration `beyond`; `None` if it may not.
    ///
    /// The distance of a signal from its chord is at most h²/8 times its second derivative, or h/4 times the change of its first one. A
    /// linear function of a target that approaches its final value and of a line lies between three values: at the start, at the start with
    /// the final target, and at the end.
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

/// The range of these values, widened by `beyond`.
fn around<const N: usize>(values: [f64; N], beyond: f64) -> Range {
    // A plain comparison compiles to one instruction, unlike `f64::min`, which handles NaN.
    let low = values.iter().skip(1).fold(values[0], |low, value| if *value < low { *value } else { low });
    let high = values.iter().skip(1).fold(values[0], |high, value| if *value > high { *value } else { high });
    Range { low: low - beyond, high: high + beyond }
}
