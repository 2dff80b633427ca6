//! THE SIGNAL CHAIN: what a linear servo leaves out, in the order in which the signal meets it.
//!
//! Every effect is exactly nothing at its neutral parameters. From the list [`CHAIN`] come the variables of the FMU, the keys
//! of model files, the listing of `actuator effects` and the laws under test. A new effect is one file in `effects/`
//! and one word in the list; the order of the list is physics.

mod values;

use crate::{
    motion::LoopTerms,
    operator::{CommandOperator, OutputOperator, Remembered},
};
pub use values::Effects;

/// Declares the files and lists their effects in the same order.
macro_rules! chain {
    ($($name:ident),+ $(,)?) => {
        $(mod $name;)+

        /// All effects, from the command to the measurement.
        pub static CHAIN: &[&Effect] = &[$(&$name::EFFECT),+];
    };
}

chain![
    delay,
    command_limit,
    command_rate_limit,
    command_dead_zone,
    command_backlash,
    asymmetric_gain,
    gain_drift,
    dead_zone,
    amplitude_gain,
    hinge_load,
    coulomb_friction,
    acceleration_limit,
    rate_limit,
    position_limit,
    backlash,
    structural_mode,
    sensor_lag,
    sensor_bias,
    chatter,
    quantisation,
];

/// One effect: everything about it that is not its memory.
#[derive(Debug)]
pub struct Effect {
    /// Name in the FMU, in model files and on the command line.
    pub name: &'static str,
    /// Effects that data may not tell apart.
    pub family: Family,
    /// What it does, in one sentence.
    pub summary: &'static str,
    /// Its parameters, in order.
    pub parameters: &'static [Parameter],
    /// Where in the chain it acts, and how.
    pub act: Act,
    /// Numbers it remembers.
    pub memory: usize,
    /// What its parameters must satisfy together, beyond their ranges.
    pub constraint: Option<Constraint>,
    /// Parameters and their greatest plausible values: with greater ones it is another effect in disguise.
    pub plausible: &'static [(&'static str, f64)],
    /// Starting values for fitting it, from what a record shows; several where one may lead astray.
    pub guess: fn(&Observed) -> Vec<Vec<f64>>,
}

/// A condition on all parameters of an effect, with its words.
#[derive(Debug)]
pub struct Constraint {
    /// True where the values are possible together.
    pub holds: fn(&[f64]) -> bool,
    /// The condition in words.
    pub words: &'static str,
}

/// Families, for honest naming where data cannot tell the members apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Motion that gets lost at a reversal.
    Play,
    /// A bound on something.
    Limit,
    /// Something that comes later.
    Lag,
    /// A gain that is not constant.
    Gain,
    /// Something the sensor adds.
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
    /// Name behind that of the effect.
    pub name: &'static str,
    /// Unit; positions are in deg.
    pub unit: &'static str,
    /// Value at which the effect is nothing.
    pub neutral: f64,
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
    /// Size of a usual value, for solvers that scale.
    pub nominal: f64,
    /// Whether the neutral value of this parameter is what makes the effect nothing.
    pub decides: bool,
    /// What it is.
    pub meaning: &'static str,
}

/// Where an effect acts, and how.
pub enum Act {
    /// The command comes later: parameter 0 is the time [s].
    Delay,
    /// On the command, ahead of the servo.
    Command(&'static dyn CommandOperator),
    /// On the gain: relative change per second.
    GainDrift(fn(&[f64]) -> f64),
    /// On the equation of motion.
    Loop(fn(&[f64], &mut LoopTerms)),
    /// On the motion of the surface, behind the drive.
    Surface(&'static dyn OutputOperator),
    /// On the measurement, with dynamics.
    Sensor(&'static dyn OutputOperator),
    /// On the measurement, at once: value from parameters, time since the start [s] and value; and its own slope.
    Reading {
        /// Measured value.
        value: fn(&[f64], f64, f64) -> f64,
        /// What it adds to the slope of the value, from parameters and time.
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
    /// True where it may wait for something, where a solver integrates.
    #[must_use]
    pub const fn watches(&self) -> bool {
        matches!(self, Self::Command(_) | Self::Surface(_) | Self::Sensor(_))
    }

    /// True where its memory is integrated by a solver.
    #[must_use]
    pub const fn is_integrated(&self) -> bool {
        matches!(self, Self::Surface(_) | Self::Sensor(_))
    }
}

/// What records show of a motion and of what a linear model leaves unexplained; the ground of first guesses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observed {
    /// Greatest |command| [deg].
    pub command_peak: f64,
    /// Least and greatest position [deg].
    pub position_range: (f64, f64),
    /// Greatest |rate| [deg/s].
    pub rate_peak: f64,
    /// Greatest |acceleration| by the drive, ω² (x - δ) [deg/s²].
    pub acceleration_peak: f64,
    /// Root mean square of measured less simulated position [deg].
    pub residual_rms: f64,
    /// Mean of the same [deg].
    pub residual_mean: f64,
    /// Frequency at which the residual is strongest [Hz].
    pub residual_frequency_hz: f64,
    /// Smallest step between different values of position [deg].
    pub position_step: f64,
    /// Duration [s].
    pub duration_s: f64,
    /// Time between samples [s].
    pub sample_time_s: f64,
}

/// Greatest value of a limit: none. What the contract of the FMU calls neutral.
pub const UNLIMITED: f64 = 1e9;

/// Smallest value of a limit that must be above zero.
pub const LEAST: f64 = 1e-9;

impl Effect {
    /// What it remembers of the motion, with its index.
    pub fn remembered(&self) -> impl Iterator<Item = (usize, Remembered)> {
        let operator = match &self.act {
            Act::Surface(operator) | Act::Sensor(operator) => Some(*operator),
            _ => None,
        };
        (0..self.memory).filter_map(move |index| Some((index, operator?.remembered(index))))
    }

    /// True where these parameters make the effect nothing.
    #[must_use]
    pub fn is_neutral(&self, values: &[f64]) -> bool {
        self.parameters.iter().zip(values).all(|(parameter, value)| !parameter.decides || *value == parameter.neutral)
    }
}

/// Numbers that all effects remember together.
pub const MEMORY: usize = {
    let (mut sum, mut index) = (0, 0);
    while index < CHAIN.len() {
        sum += CHAIN[index].memory;
        index += 1;
    }
    sum
};

/// Numbers that effects on the motion remember: the last of all. A solver integrates them.
pub const INTEGRATED: usize = {
    let (mut sum, mut index) = (0, 0);
    while index < CHAIN.len() {
        if CHAIN[index].act.is_integrated() {
            sum += CHAIN[index].memory;
        }
        index += 1;
    }
    sum
};

/// Effects that may wait for something.
pub const WATCHING: usize = {
    let (mut sum, mut index) = (0, 0);
    while index < CHAIN.len() {
        sum += CHAIN[index].act.watches() as usize;
        index += 1;
    }
    sum
};

/// The effect of a name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Effect> {
    CHAIN.iter().copied().find(|effect| effect.name == name)
}
