//! Export targets, and the content of an exported file.

use actuator_fmu::parameters::{Model, Order};

/// Export targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A file of a flight control system (`<system>`).
    Jsbsim,
    /// A model in MJCF with one joint and one actuator.
    Mujoco,
    /// C99 without dependencies but libm.
    C,
    /// A Modelica model.
    Modelica,
}

impl Target {
    /// Name in texts.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Jsbsim => "JSBSim",
            Self::Mujoco => "MuJoCo",
            Self::C => "C",
            Self::Modelica => "Modelica",
        }
    }

    /// Extension of its files.
    #[must_use]
    pub fn ending(self) -> &'static str {
        match self {
            Self::Jsbsim | Self::Mujoco => "xml",
            Self::C => "c",
            Self::Modelica => "mo",
        }
    }

    /// Default file name for a model: two targets write XML.
    #[must_use]
    pub fn file_name(self, stem: &str) -> String {
        let target = match self {
            Self::Jsbsim => "-jsbsim",
            Self::Mujoco => "-mujoco",
            Self::C | Self::Modelica => "",
        };
        format!("{stem}{target}.{}", self.ending())
    }

    /// Integration step stated in the text [s]: a millisecond is a usual frame of JSBSim; four steps per frame keep MuJoCo's joint exact to
    /// 1e-6; C integrates limits and friction with ten microseconds, everything else exactly.
    #[must_use]
    pub fn step_s(self) -> Option<f64> {
        match self {
            Self::Jsbsim => Some(1e-3),
            Self::Mujoco => Some(2.5e-4),
            Self::C => Some(1e-5),
            Self::Modelica => None,
        }
    }
}

/// Identifier for C, Modelica and XML from the name of a model: letters, digits and underscores, starting with a letter.
pub fn identifier(name: &str) -> String {
    let letters = name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' });
    let name: String = letters.collect();
    if name.starts_with(|first: char| first.is_ascii_alphabetic()) { name } else { format!("actuator_{name}") }
}

/// The parts of a model that a target writes.
pub struct Source<'a> {
    /// The model.
    pub model: &'a Model,
    /// Its name, as an identifier.
    pub name: String,
    /// Approximated or omitted effects.
    pub notes: Vec<String>,
}

impl Source<'_> {
    /// A parameter of an effect; its neutral value if the effect is inactive.
    pub fn parameter(&self, effect: &str, index: usize) -> Option<f64> {
        self.model.effects.active_values_of(effect).map(|values| values[index])
    }

    /// p if a step can resolve the pole: p h up to `most`. A faster one is omitted, with a note.
    pub fn pole(&mut self, step_s: f64, most: f64) -> Option<f64> {
        let p = self.model.base.p();
        match self.model.order {
            Order::Second => None,
            Order::Third if p * step_s <= most => Some(p),
            Order::Third => {
                let lag = 1e3 / p;
                self.notes.push(format!(
                    "the pole p = {p} 1/s, a lag of {lag:.3e} ms, is left out: too fast for steps of {step_s} s"
                ));
                None
            }
        }
    }
}
