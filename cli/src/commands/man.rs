//! `actuator man`

use std::path::PathBuf;

use actuator_fmu::{Error, Result};
use clap::Command;
use clap_mangen::Man;

use crate::{files, output};

/// Print the manual page of the program or of a command, or write them all
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  actuator man fit | man -l -\n  actuator man -o ~/.local/share/man/man1")]
pub struct Arguments {
    /// Command whose page is printed [default: the program's own page]
    command: Option<String>,
    /// Write the pages of the program and of all commands into this folder
    #[arg(short, long, value_name = "DIR", conflicts_with = "command")]
    output: Option<PathBuf>,
    /// Overwrite pages in DIR
    #[arg(long, requires = "output")]
    force: bool,
}

pub fn run(arguments: &Arguments, mut definitions: Command) -> Result<()> {
    definitions.build();
    let commands: Vec<&Command> = definitions
        .get_subcommands()
        .filter(|command| !command.is_hide_set() && command.get_name() != "help")
        .collect();
    if let Some(folder) = &arguments.output {
        let pages = std::iter::once(&definitions).chain(commands.iter().copied());
        let pages: Vec<(String, Vec<u8>)> = pages.map(|command| (file_name(command), page(command))).collect();
        files::write_folder(folder, &pages, arguments.force)?;
        return output::print(&format!("{} pages in {}\n", pages.len(), folder.display()));
    }
    let shown = match &arguments.command {
        None => &definitions,
        Some(name) => commands.iter().copied().find(|command| command.get_name() == name).ok_or_else(|| {
            let names: Vec<&str> = commands.iter().map(|command| command.get_name()).collect();
            Error::new("command", name.clone(), names.join(", ")).remedy("give one of them, or none for the program")
        })?,
    };
    output::print(&String::from_utf8_lossy(&page(shown)))
}

/// `actuator.1`, `actuator-fit.1`
fn file_name(command: &Command) -> String {
    format!("{}.1", name(command))
}

fn name(command: &Command) -> String {
    match command.get_name() {
        "actuator" => "actuator".into(),
        name => format!("actuator-{name}"),
    }
}

fn page(command: &Command) -> Vec<u8> {
    let mut page = Vec::new();
    // Writing to memory cannot fail.
    let _ = Man::new(command.clone()).title(name(command)).render(&mut page);
    page
}
