//! The command line. Each command is one file with its arguments, its example and its text.

mod build;
mod campaign;
mod compare;
mod demo;
mod diagnose;
mod effects;
mod excite;
mod fit;
mod frf;
mod generate_campaign;
mod inspect;
mod records;
mod render;
mod sets;
mod simulate;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(
    name = "actuator",
    version,
    about = "Measured actuators as FMI 2.0 co-simulation units",
    after_help = "Exit code: 0 on success, 2 on bad usage or input."
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Sets(sets::Arguments),
    Effects(effects::Arguments),
    Build(build::Arguments),
    Simulate(simulate::Arguments),
    Excite(excite::Arguments),
    Inspect(inspect::Arguments),
    Frf(frf::Arguments),
    Fit(fit::Arguments),
    Compare(compare::Arguments),
    Diagnose(diagnose::Arguments),
    Campaign(campaign::Arguments),
    Demo(demo::Arguments),
    GenerateCampaign(generate_campaign::Arguments),
    #[command(hide = true)]
    Render(render::Arguments),
}

/// Bad usage or input.
const REFUSED: u8 = 2;

/// Parses the arguments, runs the command, reports an error on standard error.
pub fn run() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Sets(arguments) => sets::run(&arguments),
        Command::Effects(arguments) => effects::run(&arguments),
        Command::Build(arguments) => build::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Excite(arguments) => excite::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Frf(arguments) => frf::run(&arguments),
        Command::Fit(arguments) => fit::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Diagnose(arguments) => diagnose::run(&arguments),
        Command::Campaign(arguments) => campaign::run(&arguments),
        Command::Demo(arguments) => demo::run(&arguments),
        Command::GenerateCampaign(arguments) => generate_campaign::run(&arguments),
        Command::Render(arguments) => render::run(&arguments),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("actuator: {error}");
            ExitCode::from(REFUSED)
        }
    }
}
