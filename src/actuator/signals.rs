//! Inputs and outputs.

use serde::{Deserialize, Serialize};

use crate::transition::Ramp;

/// A failure of the drive.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Failure {
    /// None.
    #[default]
    None,
    /// The drive exerts no force: the surface floats under its damping and loads.
    Passive,
    /// The position is fixed.
    Stuck,
    /// The drive moves to the upper stop, within its limits.
    HardoverPositive,
    /// The drive moves to the lower stop, within its limits.
    HardoverNegative,
}

impl Failure {
    /// All of them, in their order.
    pub const ALL: &'static [Self] =
        &[Self::None, Self::Passive, Self::Stuck, Self::HardoverPositive, Self::HardoverNegative];
    /// Their names.
    pub const NAMES: &'static [&'static str] = &["none", "passive", "stuck", "hardover_positive", "hardover_negative"];
}

/// Inputs during a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// Command \[deg\].
    pub command: Ramp,
    /// Hinge load \[deg\].
    pub load: Ramp,
    /// Failure.
    pub failure: Failure,
}

impl Inputs {
    /// True without load and failure.
    #[must_use]
    #[inline]
    pub fn is_unloaded(&self) -> bool {
        self.load == Ramp::default() && self.failure == Failure::None
    }

    /// The inputs a time [s] later.
    #[must_use]
    #[inline]
    pub(super) fn after(self, time: f64) -> Self {
        let later = |ramp: Ramp| Ramp { value: ramp.at(time), ..ramp };
        Self { command: later(self.command), load: later(self.load), ..self }
    }

    /// A command without load or failure.
    #[must_use]
    pub fn command(command: Ramp) -> Self {
        Self { command, ..Self::default() }
    }
}

/// Outputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// Measured position \[deg\].
    pub position: f64,
    /// Deflection of the surface \[deg\].
    pub deflection: f64,
    /// Rate of the drive [deg/s].
    pub rate: f64,
    /// A limit of rate, acceleration or position is active.
    pub saturated: bool,
}
