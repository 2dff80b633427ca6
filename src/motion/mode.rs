//! The mode of the drive: a branch of the servo characteristic and a mode of motion, with the conditions under which they hold.

use serde::{Deserialize, Serialize};

use crate::series::Range;

/// One linear branch of the servo characteristic: ω² (gain × error + offset) while low <= error <= high.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct ServoBranch {
    pub gain: f64,
    pub offset: f64,
    pub low: f64,
    pub high: f64,
    pub saturated: bool,
}

/// Mode of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) enum MotionMode {
    /// Free, with friction opposing this direction (1 or -1).
    Free(f64),
    /// At a rate limit, with this rate [deg/s].
    RateLimited(f64),
    /// At rest, held by friction.
    Sticking,
    /// At the upper (1) or lower (-1) stop.
    AtStop(f64),
    /// At rest, by a failure.
    Stuck,
}

impl MotionMode {
    /// The rate held in a mode other than a free one [deg/s].
    pub fn held_rate(self) -> f64 {
        if let Self::RateLimited(rate) = self { rate } else { 0.0 }
    }

    pub fn is_at_limit(self) -> bool {
        matches!(self, Self::RateLimited(_) | Self::AtStop(_))
    }
}

/// Mode of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DriveMode {
    pub(super) branch: ServoBranch,
    pub(super) motion: MotionMode,
}

impl DriveMode {
    /// A limit of rate, acceleration or position is active.
    #[must_use]
    pub fn is_saturated(&self) -> bool {
        self.motion.is_at_limit() || self.branch.saturated
    }
}

/// Conditions under which a mode of the drive holds.
pub(super) struct ModeConditions {
    /// Servo error: target less position [deg].
    pub error: Range,
    /// [deg]
    pub position: Range,
    /// Sum of all forces but friction [deg/s²].
    pub force: Range,
    /// [deg/s]
    pub rate: Range,
}
