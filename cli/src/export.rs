//! A model for simulators that take no FMU: as text in their own language, with what they cannot express refused by name.

mod c;
mod jsbsim;
pub mod measure;
mod modelica;
mod mujoco;

use std::fmt::Write as _;

use actuator_fmu::{
    error::{Error, Result},
    parameters::{Model, Order},
};

/// What a model can be exported to.
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

/// An exported model.
#[derive(Debug, Clone)]
pub struct Export {
    /// The text behind its head.
    body: String,
    /// What carries over only nearly, or is left out.
    pub notes: Vec<String>,
}

impl Target {
    /// As it is called in texts.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Jsbsim => "JSBSim",
            Self::Mujoco => "MuJoCo",
            Self::C => "C",
            Self::Modelica => "Modelica",
        }
    }

    /// Ending of its files.
    #[must_use]
    pub fn ending(self) -> &'static str {
        match self {
            Self::Jsbsim | Self::Mujoco => "xml",
            Self::C => "c",
            Self::Modelica => "mo",
        }
    }

    /// Step of integration where the text states one [s]: a millisecond is a usual frame of JSBSim; four steps in it keep MuJoCo's joint exact
    /// to 1e-6; C integrates limits and friction with ten microseconds, everything else exactly.
    #[must_use]
    pub fn step_s(self) -> Option<f64> {
        match self {
            Self::Jsbsim => Some(1e-3),
            Self::Mujoco => Some(2.5e-4),
            Self::C => Some(1e-5),
            Self::Modelica => None,
        }
    }

    /// Effects that it can express.
    #[must_use]
    pub fn effects(self) -> &'static [&'static str] {
        match self {
            Self::Jsbsim => &jsbsim::EFFECTS,
            Self::Mujoco => &mujoco::EFFECTS,
            Self::C => &c::EFFECTS,
            Self::Modelica => &modelica::EFFECTS,
        }
    }
}

/// Names of C, Modelica and XML that follow from that of a model: letters, digits and underscores, a letter first.
fn identifier(name: &str) -> String {
    let letters = name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' });
    let name: String = letters.collect();
    if name.starts_with(|first: char| first.is_ascii_alphabetic()) { name } else { format!("actuator_{name}") }
}

/// What a target writes of a model.
struct Source<'a> {
    model: &'a Model,
    name: String,
    notes: Vec<String>,
}

impl Source<'_> {
    /// A parameter of an effect; its neutral value where the effect does not act.
    fn parameter(&self, effect: &str, index: usize) -> Option<f64> {
        self.model.effects.active().find(|(active, _)| active.name == effect).map(|(_, values)| values[index])
    }

    /// p where the model has a pole that a step can follow: p h up to `most`. A faster one is left out, with a note.
    fn pole(&mut self, step_s: f64, most: f64) -> Option<f64> {
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

/// A model in the language of a target.
///
/// # Errors
/// Effects that the target cannot express.
pub fn export(model: &Model, name: &str, target: Target) -> Result<Export> {
    let active: Vec<&str> = model.effects.active().map(|(effect, _)| effect.name).collect();
    let unknown: Vec<&str> = active.into_iter().filter(|name| !target.effects().contains(name)).collect();
    if !unknown.is_empty() {
        let allowed = format!("those that {} can express: {}", target.name(), target.effects().join(", "));
        return Err(Error::new("effects of the model", unknown.join(", "), allowed)
            .remedy("remove them from the model file, or use its FMU, which has them all"));
    }
    let mut source = Source { model, name: identifier(name), notes: Vec::new() };
    let body = match target {
        Target::Jsbsim => jsbsim::body(&mut source),
        Target::Mujoco => mujoco::body(&mut source),
        Target::C => c::body(&mut source),
        Target::Modelica => modelica::body(&mut source),
    };
    Ok(Export { body, notes: source.notes })
}

impl Export {
    /// The file, with what it is and how far it deviates in its head.
    #[must_use]
    pub fn text(&self, target: Target, model: &Model, name: &str, deviation: &str) -> String {
        let [k, p, omega, zeta] = model.base.values();
        let unit = model.unit();
        let pole = if model.order == Order::Third { format!("p = {p} 1/s, ") } else { String::new() };
        let mut lines = vec![
            format!("{name}, exported for {} by actuator {}", target.name(), env!("CARGO_PKG_VERSION")),
            format!("k = {k} {}, {pole}omega = {omega} rad/s, zeta = {zeta}; positions in {unit}", unit.of_gain()),
        ];
        for (effect, values) in model.effects.active() {
            let values = effect
                .parameters
                .iter()
                .zip(values)
                .map(|(parameter, value)| format!("{} = {value} {}", parameter.name, unit.derived(parameter.unit)));
            lines.push(format!("{}: {}", effect.name, values.collect::<Vec<_>>().join(", ")));
        }
        lines.extend(self.notes.iter().cloned());
        lines.push(deviation.to_owned());
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = match target {
            Target::C => writeln!(text, "/* {}\n */", lines.join("\n * ")),
            Target::Modelica => writeln!(text, "// {}", lines.join("\n// ")),
            // Two hyphens end a comment of XML.
            _ => writeln!(text, "<?xml version=\"1.0\"?>\n<!-- {}\n-->", lines.join("\n     ").replace("--", "- -")),
        };
        text + &self.body
    }
}
