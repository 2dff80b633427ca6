//! Which mode of the drive holds in a state, and under which conditions it continues to hold.

use super::{
    forcing::DriveOperation,
    loop_terms::{DriveState, LoopTerms},
    mode::{ModeConditions, MotionMode, ServoBranch},
};
use crate::series::Range;

impl LoopTerms {
    /// Branch of the servo characteristic at this error.
    #[inline(always)]
    pub(super) fn servo_branch(&self, error: f64, operation: DriveOperation) -> ServoBranch {
        let none = f64::INFINITY;
        let (dead, full) = (self.dead_zone, self.acceleration / self.omega2);
        let side = if error < 0.0 { -1.0 } else { 1.0 };
        let between = |low: f64, high: f64| if side > 0.0 { (low, high) } else { (-high, -low) };
        if operation != DriveOperation::Active {
            ServoBranch { gain: 0.0, offset: 0.0, low: -none, high: none, saturated: false }
        } else if error.abs() > dead + full {
            let (low, high) = between(dead + full, none);
            ServoBranch { gain: 0.0, offset: side * full, low, high, saturated: true }
        } else if dead > 0.0 && error.abs() <= dead {
            ServoBranch { gain: 0.0, offset: 0.0, low: -dead, high: dead, saturated: false }
        } else if dead > 0.0 {
            let (low, high) = between(dead, dead + full);
            ServoBranch { gain: 1.0, offset: -side * dead, low, high, saturated: false }
        } else {
            ServoBranch { gain: 1.0, offset: 0.0, low: -full, high: full, saturated: false }
        }
    }

    /// Sum of all forces but friction at an instant [deg/s²].
    #[inline(always)]
    pub(super) fn instantaneous_force(&self, branch: &ServoBranch, target: f64, load: f64, from: &DriveState) -> f64 {
        let (position, rate) = (from.position, from.rate);
        let drive = branch.gain * (target - position) + branch.offset;
        let load = self.bias + load - self.stiffness * position - self.cubic * position.powi(3);
        self.omega2 * (drive + load) - self.damping * rate
    }

    /// Mode of the motion at this state, under this sum of forces but friction.
    #[inline(always)]
    pub(super) fn motion_mode(&self, from: &DriveState, force: f64, operation: DriveOperation) -> MotionMode {
        let friction = self.omega2 * self.friction;
        let (position, rate) = (from.position, from.rate);
        if operation == DriveOperation::Stuck {
            MotionMode::Stuck
        } else if position >= self.max && rate >= 0.0 && force >= -friction {
            MotionMode::AtStop(1.0)
        } else if position <= self.min && rate <= 0.0 && force <= friction {
            MotionMode::AtStop(-1.0)
        } else if rate == 0.0 && friction > 0.0 && force.abs() <= friction {
            MotionMode::Sticking
        } else if rate >= self.up && force > friction {
            MotionMode::RateLimited(self.up)
        } else if rate <= -self.down && force < -friction {
            MotionMode::RateLimited(-self.down)
        } else {
            MotionMode::Free(if rate == 0.0 { force.signum() } else { rate.signum() })
        }
    }

    /// Conditions under which this branch and this mode of motion hold.
    #[inline(always)]
    pub(super) fn conditions(&self, branch: &ServoBranch, motion: MotionMode) -> ModeConditions {
        let friction = self.omega2 * self.friction;
        let stops = Range { low: self.min, high: self.max };
        let errors = Range { low: branch.low, high: branch.high };
        let conditions =
            |position: Range, force: Range, rate: Range| ModeConditions { error: errors, position, force, rate };
        match motion {
            MotionMode::Stuck => conditions(Range::ALL, Range::ALL, Range::ALL),
            MotionMode::RateLimited(rate) if rate > 0.0 => conditions(stops, Range::above(friction), Range::ALL),
            MotionMode::RateLimited(_) => conditions(stops, Range::below(-friction), Range::ALL),
            MotionMode::Sticking => conditions(Range::ALL, Range { low: -friction, high: friction }, Range::ALL),
            MotionMode::AtStop(side) if side > 0.0 => conditions(Range::ALL, Range::above(-friction), Range::ALL),
            MotionMode::AtStop(_) => conditions(Range::ALL, Range::below(friction), Range::ALL),
            MotionMode::Free(direction) => {
                // The sign of friction is that of the rate: a reversal ends the mode.
                let rate = if friction > 0.0 && direction > 0.0 {
                    Range { low: 0.0, high: self.up }
                } else if friction > 0.0 {
                    Range { low: -self.down, high: 0.0 }
                } else {
                    Range { low: -self.down, high: self.up }
                };
                conditions(stops, Range::ALL, rate)
            }
        }
    }
}
