//! `actuator effects`

use crate::output;
use std::fmt::Write as _;

use actuator_fmu::{
    Result,
    effects::{CHAIN, UNLIMITED},
    parameters::PositionUnit,
};
use serde::Serialize;

/// List the effects of the signal chain with their parameters
#[derive(clap::Args)]
#[command(
    after_help = "In the order in which the signal meets them. In the FMU and in model files a parameter is called \
EFFECT.PARAMETER; at its neutral value an effect is exactly nothing.\n\nExamples:\n  actuator effects --json\n  actuator effects --unit mm"
)]
pub struct Arguments {
    /// Unit of positions in which the parameters are listed: rad, deg, mm, m or 1
    #[arg(long, default_value_t)]
    unit: PositionUnit,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Effect {
    name: &'static str,
    family: &'static str,
    place: &'static str,
    summary: &'static str,
    parameters: Vec<Parameter>,
}

#[derive(Serialize)]
struct Parameter {
    name: &'static str,
    unit: &'static str,
    neutral: f64,
    min: f64,
    max: f64,
    meaning: &'static str,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    if arguments.json {
        let effects: Vec<Effect> = CHAIN
            .iter()
            .map(|effect| Effect {
                name: effect.name,
                family: effect.family.name(),
                place: effect.act.place(),
                summary: effect.summary,
                parameters: effect
                    .parameters
                    .iter()
                    .map(|parameter| Parameter {
                        name: parameter.name,
                        unit: arguments.unit.derived(parameter.unit),
                        neutral: parameter.neutral,
                        min: parameter.min,
                        max: parameter.max,
                        meaning: parameter.meaning,
                    })
                    .collect(),
            })
            .collect();
        return output::print_json(&effects);
    }
    let mut text = format!("{:<30} {:<7} {:>8}  {:<8} meaning\n", "parameter", "unit", "neutral", "place");
    for effect in CHAIN {
        for parameter in effect.parameters {
            let neutral = match parameter.neutral {
                limit if limit >= UNLIMITED => "none".into(),
                limit if limit <= -UNLIMITED => "none".into(),
                other => other.to_string(),
            };
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "{:<30} {:<7} {neutral:>8}  {:<8} {}",
                format!("{}.{}", effect.name, parameter.name),
                arguments.unit.derived(parameter.unit),
                effect.act.place(),
                parameter.meaning
            );
        }
    }
    output::print(&text)
}
