//! `actuator schema`

use actuator_fmu::{Error, Result};

use crate::{output, schemas::SCHEMAS};

/// Print the JSON Schema of what a command writes as JSON
#[derive(clap::Args)]
#[command(
    after_help = "JSON Schema 2020-12. Each is that of `--json` of the command, and of the file that the command writes: diagnosis.json, \
inspection.json, campaign.json.\n\nExamples:\n  actuator schema               the names\n  actuator schema diagnose > diagnosis.schema.json"
)]
pub struct Arguments {
    /// Command [default: list their names]
    command: Option<String>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let names = || SCHEMAS.map(|(name, _)| name);
    let Some(wanted) = &arguments.command else { return output::print(&(names().join("\n") + "\n")) };
    let found = SCHEMAS.iter().find(|(name, _)| name == wanted);
    let (_, text) = found.ok_or_else(|| {
        Error::new("command", wanted.clone(), names().join(", ")).remedy("give one of them; the others write no JSON")
    })?;
    output::print(text)
}
