//! `actuator completions`

use actuator_fmu::Result;
use clap::{Command, ValueEnum};
use clap_complete::{Shell, generate};

use crate::output;

/// Print the completions of a shell: commands, options and their values
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  actuator completions bash > ~/.local/share/bash-completion/completions/actuator\n  \
actuator completions zsh > \"${fpath[1]}/_actuator\"\n  \
actuator completions fish > ~/.config/fish/completions/actuator.fish"
)]
pub struct Arguments {
    /// Which shell
    shell: ShellArgument,
}

#[derive(Clone, Copy, ValueEnum)]
enum ShellArgument {
    Bash,
    Zsh,
    Fish,
    Powershell,
}

pub fn run(arguments: &Arguments, mut definitions: Command) -> Result<()> {
    let shell = match arguments.shell {
        ShellArgument::Bash => Shell::Bash,
        ShellArgument::Zsh => Shell::Zsh,
        ShellArgument::Fish => Shell::Fish,
        ShellArgument::Powershell => Shell::PowerShell,
    };
    let mut script = Vec::new();
    generate(shell, &mut definitions, "actuator", &mut script);
    output::print(&String::from_utf8_lossy(&script))
}
