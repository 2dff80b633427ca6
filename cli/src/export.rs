//! A model for simulators that do not import FMUs: as text in their own language; effects that they cannot express are refused by name.

mod c;
mod jsbsim;
pub mod measure;
mod modelica;
mod mujoco;
pub mod target;

use std::fmt::Write as _;

use actuator_fmu::{
    error::{Error, Result},
    parameters::{Model, Order},
};

use target::{Source, Target, identifier};

/// An exported model.
#[derive(Debug, Clone)]
pub struct Export {
    /// The text after the header.
    body: String,
    /// Approximated or omitted effects.
    pub notes: Vec<String>,
}

/// Effects that a target can express.
fn effects(target: Target) -> &'static [&'static str] {
    match target {
        Target::Jsbsim => &jsbsim::EFFECTS,
        Target::Mujoco => &mujoco::EFFECTS,
        Target::C => &c::EFFECTS,
        Target::Modelica => &modelica::EFFECTS,
    }
}

/// A model in the language of a target.
///
/// # Errors
/// Effects that the target cannot express.
pub fn export(model: &Model, name: &str, target: Target) -> Result<Export> {
    let active: Vec<&str> = model.effects.active().map(|(effect, _)| effect.name).collect();
    let unknown: Vec<&str> = active.into_iter().filter(|name| !effects(target).contains(name)).collect();
    if !unknown.is_empty() {
        let allowed = format!("those that {} can express: {}", target.name(), effects(target).join(", "));
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
    /// The file, with description and deviation in its header.
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
            // Two hyphens end an XML comment.
            _ => writeln!(text, "<?xml version=\"1.0\"?>\n<!-- {}\n-->", lines.join("\n     ").replace("--", "- -")),
        };
        text + &self.body
    }
}
