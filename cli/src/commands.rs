//! The command line. Each command is one file with its arguments, its example and its text.

mod build;
mod campaign;
mod compare;
mod completions;
mod demo;
mod diagnose;
mod effects;
mod excite;
mod export;
mod fit;
mod frf;
mod generate_campaign;
mod inspect;
mod man;
mod records;
mod render;
mod schema;
mod sets;
mod simulate;

use std::{any::TypeId, process::ExitCode, time::Duration};

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::{interruption, invocation::Invocation, output};

#[derive(Parser)]
#[command(
    name = "actuator",
    version,
    about = "Measured actuators as FMI 2.0 units, for co-simulation and model exchange",
    after_help = "Exit code: 0 on success, 2 on bad usage or input; with --exit-code, diagnose and inspect tell their verdict by it.\n\n\
Work of more than a second shows on a terminal how far it is and about how long it will take. With ACTUATOR_PROGRESS=lines in the environment it \
says so in lines of JSON on standard error, terminal or not."
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
    Export(export::Arguments),
    Inspect(inspect::Arguments),
    Frf(frf::Arguments),
    Fit(fit::Arguments),
    Compare(compare::Arguments),
    Diagnose(diagnose::Arguments),
    Campaign(campaign::Arguments),
    Demo(demo::Arguments),
    GenerateCampaign(generate_campaign::Arguments),
    Schema(schema::Arguments),
    Completions(completions::Arguments),
    Man(man::Arguments),
    #[command(hide = true)]
    Render(render::Arguments),
}

/// The definitions of all commands. The argument after a numeric option is its value, even if negative: if refused, then with a specific
/// message.
fn definitions() -> clap::Command {
    let is_number = |argument: &clap::Arg| {
        let parser = argument.get_value_parser().type_id();
        parser == TypeId::of::<f64>() || parser == TypeId::of::<Duration>() || argument.get_id() == "delay"
    };
    Arguments::command().mut_subcommands(|command| {
        command.mut_args(|argument| if is_number(&argument) { argument.allow_hyphen_values(true) } else { argument })
    })
}

/// Nothing to report by an exit code.
const SUCCESS: u8 = 0;

/// Bad usage or input.
const REFUSED: u8 = 2;

/// Parses the arguments, runs the command, reports errors on standard error.
pub fn run() -> ExitCode {
    let matches = definitions().get_matches();
    let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let invocation = &Invocation::new(std::env::args_os().skip(1), &definitions(), &matches);
    let _temporary = interruption::prepare();
    let done = |()| SUCCESS;
    let outcome = match arguments.command {
        Command::Sets(arguments) => sets::run(&arguments).map(done),
        Command::Effects(arguments) => effects::run(&arguments).map(done),
        Command::Build(arguments) => build::run(&arguments).map(done),
        Command::Simulate(arguments) => simulate::run(&arguments).map(done),
        Command::Export(arguments) => export::run(&arguments).map(done),
        Command::Excite(arguments) => excite::run(&arguments).map(done),
        Command::Inspect(arguments) => inspect::run(&arguments, invocation),
        Command::Frf(arguments) => frf::run(&arguments).map(done),
        Command::Fit(arguments) => fit::run(&arguments, invocation).map(done),
        Command::Compare(arguments) => compare::run(&arguments, invocation).map(done),
        Command::Diagnose(arguments) => diagnose::run(&arguments, invocation),
        Command::Campaign(arguments) => campaign::run(&arguments, invocation).map(done),
        Command::Demo(arguments) => demo::run(&arguments, invocation).map(done),
        Command::GenerateCampaign(arguments) => generate_campaign::run(&arguments).map(done),
        Command::Schema(arguments) => schema::run(&arguments).map(done),
        Command::Completions(arguments) => completions::run(&arguments, definitions()).map(done),
        Command::Man(arguments) => man::run(&arguments, definitions()).map(done),
        Command::Render(arguments) => render::run(&arguments).map(done),
    };
    match outcome {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            interruption::wait_if_ending();
            output::remark(&format!("actuator: {error}"));
            ExitCode::from(REFUSED)
        }
    }
}
