//! Inputs of the drive: over a segment ([`Forcing`]), and at an instant ([`InstantaneousForcing`]).

use crate::series::Series;

/// How the drive operates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DriveOperation {
    /// It follows its target.
    Active,
    /// It exerts no force: the surface floats.
    Passive,
    /// Its position is fixed.
    Stuck,
}

/// Forcing over a segment.
#[derive(Debug, Clone, Copy)]
pub struct Forcing<'a> {
    /// Target of the servo.
    pub target: &'a Series,
    /// Load at the start and its change over the segment \[deg\].
    pub load: [f64; 2],
    /// How the drive operates.
    pub operation: DriveOperation,
}

/// Forcing at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InstantaneousForcing {
    /// Target of the servo \[deg\].
    pub target: f64,
    /// Load \[deg\].
    pub load: f64,
    /// Derivatives of target and load, 0 where unknown [deg/s].
    pub slopes: [f64; 2],
    /// How the drive operates.
    pub operation: DriveOperation,
}
