//! The terms of the equation of motion and the state of the drive.

/// Ratio of destabilizing cubic to linear spring force above which the motion is declared divergent: the deflection is then more than
/// 100 times the largest one at which an equilibrium exists.
const DIVERGENCE_RATIO: f64 = 1e4;

/// Coefficients of the equation of motion: [`LoopTerms::linear`] and the changes made by effects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopTerms {
    /// ω² [1/s²]
    pub omega2: f64,
    /// 2ζω [1/s]
    pub damping: f64,
    /// Half width of the dead zone of the error \[deg\].
    pub dead_zone: f64,
    /// Maximum acceleration by the drive [deg/s²].
    pub acceleration: f64,
    /// Cubic over linear stiffness [1/deg²].
    pub cubic: f64,
    /// Load stiffness over the actuator's own.
    pub stiffness: f64,
    /// Steady load \[deg\].
    pub bias: f64,
    /// Friction over ω² \[deg\].
    pub friction: f64,
    /// Maximum rate upward [deg/s].
    pub up: f64,
    /// Maximum rate downward [deg/s].
    pub down: f64,
    /// Minimum position \[deg\].
    pub min: f64,
    /// Maximum position \[deg\].
    pub max: f64,
}

impl LoopTerms {
    /// The loop of eq. (1) without effects.
    #[must_use]
    pub fn linear(omega: f64, zeta: f64) -> Self {
        let none = f64::INFINITY;
        Self {
            omega2: omega * omega,
            damping: 2.0 * zeta * omega,
            dead_zone: 0.0,
            acceleration: none,
            cubic: 0.0,
            stiffness: 0.0,
            bias: 0.0,
            friction: 0.0,
            up: none,
            down: none,
            min: -none,
            max: none,
        }
    }

    /// Natural frequency of the loop [1/s], at positions up to this \[deg\].
    #[must_use]
    pub fn natural_frequency(&self, position: f64) -> f64 {
        let stiffness = 1.0 + self.stiffness.max(0.0) + 3.0 * self.cubic.abs() * position * position;
        (self.omega2 * stiffness).sqrt()
    }

    /// Largest magnitude of the poles of the loop [1/s], at positions up to this \[deg\].
    #[must_use]
    pub fn pole(&self, position: f64) -> f64 {
        let (omega, half) = (self.natural_frequency(position), 0.5 * self.damping);
        if half > omega { half + (half * half - omega * omega).sqrt() } else { omega }
    }

    /// True if the mode of the motion may change.
    #[must_use]
    pub fn has_events(&self) -> bool {
        let limits = [self.acceleration, self.up, self.down, self.max, -self.min];
        self.dead_zone > 0.0 || self.friction > 0.0 || limits.iter().any(|limit| *limit < f64::INFINITY)
    }

    /// True if the softening cubic spring exceeds the linear one so far that the motion diverges.
    #[must_use]
    pub fn diverges(&self, position: f64) -> bool {
        self.cubic * position * position < -DIVERGENCE_RATIO
    }

    /// The state clamped to the limits, after a change of parameters or a rounding error at an event.
    #[must_use]
    pub fn clamped_to_limits(&self, drive: DriveState) -> DriveState {
        let DriveState { position, rate } = drive;
        let rate = rate.clamp(-self.down, self.up);
        if position > self.max {
            DriveState { position: self.max, rate: rate.min(0.0) }
        } else if position < self.min {
            DriveState { position: self.min, rate: rate.max(0.0) }
        } else {
            DriveState { position, rate }
        }
    }
}

/// Position and rate of the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveState {
    /// δ \[deg\]
    pub position: f64,
    /// δ̇ [deg/s]
    pub rate: f64,
}
