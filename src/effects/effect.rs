//! Description of an effect: names, parameters, place in the chain and action.

use crate::{
    motion::LoopTerms,
    operator::{CommandOperator, OutputOperator, StateVariable},
};

/// Description of an effect.
#[derive(Debug)]
pub struct Effect {
    /// Name in the FMU, in model files and on the command line.
    pub name: &'static str,
    /// Family of effects that may be indistinguishable from data.
    pub family: Family,
    /// What it does, in a few words.
    pub summary: &'static str,
    /// Its parameters, in order.
    pub parameters: &'static [Parameter],
    /// Place in the chain, and action.
    pub act: Act,
    /// Number of entries in the memory.
    pub memory: usize,
    /// Constraint on its parameters beyond their ranges.
    pub constraint: Option<Constraint>,
    /// Parameters with their largest plausible values in identification: beyond them the effect imitates another one.
    pub plausible: &'static [(&'static str, f64)],
    /// Start values for an estimation, from features of a record; several if the cost may have local minima.
    pub start_values: fn(&Observed) -> Vec<Vec<f64>>,
}

/// A constraint on all parameters of an effect.
#[derive(Debug)]
pub struct Constraint {
    /// True if the values satisfy it.
    pub holds: fn(&[f64]) -> bool,
    /// The constraint in words.
    pub words: &'static str,
}

/// Families of effects that may be indistinguishable from data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Motion lost at a reversal.
    Play,
    /// A bound on a signal.
    Limit,
    /// Delay or lag.
    Lag,
    /// A gain that is not constant.
    Gain,
    /// An error of the measurement.
    Sensor,
}

impl Family {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Play => "play",
            Self::Limit => "limit",
            Self::Lag => "lag",
            Self::Gain => "gain",
            Self::Sensor => "sensor",
        }
    }
}

/// One parameter of an effect.
#[derive(Debug)]
pub struct Parameter {
    /// Name after that of the effect.
    pub name: &'static str,
    /// Unit, with positions in deg; [`PositionUnit::derived`](crate::parameters::PositionUnit::derived) spells it for others.
    pub unit: &'static str,
    /// Value at which the effect is the identity.
    pub neutral: f64,
    /// Minimum.
    pub min: f64,
    /// Maximum.
    pub max: f64,
    /// Typical magnitude, for solvers that scale.
    pub nominal: f64,
    /// True if the neutral value of this parameter is necessary for the effect to be the identity.
    pub decides: bool,
    /// Meaning.
    pub meaning: &'static str,
}

/// Place of an effect, and its action.
pub enum Act {
    /// Transport delay of the command: parameter 0 is the time \[s\].
    Delay,
    /// On the command, ahead of the servo.
    Command(&'static dyn CommandOperator),
    /// On the gain: relative change per second.
    GainDrift(fn(&[f64]) -> f64),
    /// On the equation of motion.
    Loop(fn(&[f64], &mut LoopTerms)),
    /// On the position behind the drive.
    Surface(&'static dyn OutputOperator),
    /// On the measurement, with dynamics.
    Sensor(&'static dyn OutputOperator),
    /// On the measurement, static: value from parameters, time since the start \[s\] and value; derivative of its contribution.
    Reading {
        /// Measured value.
        value: fn(&[f64], f64, f64) -> f64,
        /// Derivative of its contribution, from parameters and time.
        slope: fn(&[f64], f64) -> f64,
    },
}

impl std::fmt::Debug for Act {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.place())
    }
}

impl Act {
    /// The place in words.
    #[must_use]
    pub fn place(&self) -> &'static str {
        match self {
            Self::Delay | Self::Command(_) | Self::GainDrift(_) => "command",
            Self::Loop(_) => "loop",
            Self::Surface(_) => "surface",
            Self::Sensor(_) | Self::Reading { .. } => "sensor",
        }
    }
}

impl Act {
    /// True if it may have event conditions for ODE solvers.
    #[must_use]
    pub const fn has_events(&self) -> bool {
        matches!(self, Self::Command(_) | Self::Surface(_) | Self::Sensor(_))
    }

    /// True if its memory is a continuous state for ODE solvers.
    #[must_use]
    pub const fn is_integrated(&self) -> bool {
        matches!(self, Self::Surface(_) | Self::Sensor(_))
    }
}

/// Features of a record and of the residual of a linear model, for start values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observed {
    /// Maximum |command| \[deg\].
    pub command_peak: f64,
    /// Minimum and maximum position \[deg\].
    pub position_range: (f64, f64),
    /// Maximum |rate| [deg/s].
    pub rate_peak: f64,
    /// Maximum |acceleration| by the drive, ω² (x - δ) [deg/s²].
    pub acceleration_peak: f64,
    /// Root mean square of measured minus simulated position \[deg\].
    pub residual_rms: f64,
    /// Mean of the same \[deg\].
    pub residual_mean: f64,
    /// Frequency of the maximum of the residual spectrum \[Hz\].
    pub residual_frequency_hz: f64,
    /// Smallest step between different values of position \[deg\].
    pub position_step: f64,
    /// Duration \[s\].
    pub duration_s: f64,
    /// Time between samples \[s\].
    pub sample_time_s: f64,
}

/// Neutral value of a limit: no limit.
pub const UNLIMITED: f64 = 1e9;

/// Minimum of a limit that must be positive.
pub const SMALLEST_LIMIT: f64 = 1e-9;

impl Effect {
    /// Its continuous states with their indices.
    pub fn state_variables(&self) -> impl Iterator<Item = (usize, StateVariable)> {
        let operator = match &self.act {
            Act::Surface(operator) | Act::Sensor(operator) => Some(*operator),
            _ => None,
        };
        (0..self.memory).filter_map(move |index| Some((index, operator?.state_variable(index))))
    }

    /// True if the effect is the identity with these parameters.
    #[must_use]
    pub fn is_neutral(&self, values: &[f64]) -> bool {
        self.parameters.iter().zip(values).all(|(parameter, value)| !parameter.decides || *value == parameter.neutral)
    }
}
