//! The command line of this run, stated on pages so that readers can repeat it.

use std::{ffi::OsString, iter::once};

use clap::{ArgMatches, Command, parser::ValueSource};

/// A command line, and the options in it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Invocation {
    /// Program, command and arguments.
    pub command: Vec<String>,
    /// Options given, each with its values; empty if all have their defaults.
    pub options: Vec<String>,
}

/// Options that name models and records, which pages list with their hashes.
const LISTED: [&str; 4] = ["model", "fit", "check", "reference"];

impl Invocation {
    /// From arguments parsed with the definitions of all commands. `arguments` are those after the program's name.
    #[must_use]
    pub fn new(arguments: impl Iterator<Item = OsString>, definitions: &Command, matches: &ArgMatches) -> Self {
        let words = arguments.map(|argument| argument.to_string_lossy().into_owned());
        let options = matches.subcommand().and_then(|(name, given)| {
            let command = definitions.find_subcommand(name)?;
            Some(command.get_arguments().filter_map(|argument| option(argument, given)).collect())
        });
        Self { command: once("actuator".to_owned()).chain(words).collect(), options: options.unwrap_or_default() }
    }

    /// The command line in shell syntax.
    #[must_use]
    pub fn shell(&self) -> String {
        joined(self.command.iter().map(String::as_str))
    }
}

/// An option with its values, if given.
fn option(argument: &clap::Arg, given: &ArgMatches) -> Option<String> {
    let id = argument.get_id().as_str();
    if argument.is_positional() || LISTED.contains(&id) || given.value_source(id) != Some(ValueSource::CommandLine) {
        return None;
    }
    let name = argument
        .get_long()
        .map_or_else(|| format!("-{}", argument.get_short().unwrap_or_default()), |long| format!("--{long}"));
    let takes_values = argument.get_action().takes_values();
    let values = given.get_raw(id).filter(|_| takes_values).into_iter().flatten();
    let values: Vec<String> = values.map(|value| value.to_string_lossy().into_owned()).collect();
    Some(joined(once(name.as_str()).chain(values.iter().map(String::as_str))))
}

fn joined<'a>(words: impl Iterator<Item = &'a str>) -> String {
    words.map(quoted).collect::<Vec<String>>().join(" ")
}

/// A word quoted for a POSIX shell: unchanged if it has no special characters, otherwise in single quotes.
fn quoted(word: &str) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_-+=:,./@%".contains(letter);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_back_what_was_given() {
        let words = ["actuator", "fit", "a b.csv", "it's", "$HOME", "", "--delay=0.01", "*.csv"];
        let command = words.map(str::to_owned).to_vec();
        let line = Invocation { command, options: Vec::new() }.shell();
        assert_eq!(line, r"actuator fit 'a b.csv' 'it'\''s' '$HOME' '' --delay=0.01 '*.csv'");
        let said = std::process::Command::new("sh").args(["-c", &format!("printf '%s\\n' {line}")]).output().unwrap();
        assert_eq!(String::from_utf8(said.stdout).unwrap().lines().collect::<Vec<_>>(), words);
    }

    #[test]
    fn options_are_those_that_were_given() {
        let argument = |name: &'static str| clap::Arg::new(name).long(name);
        let fit = Command::new("fit")
            .arg(clap::Arg::new("records").num_args(1..))
            .arg(argument("order").default_value("auto"))
            .arg(argument("delay").default_value("0"))
            .arg(argument("check"))
            .arg(argument("force").action(clap::ArgAction::SetTrue))
            .arg(argument("json").action(clap::ArgAction::SetTrue));
        let definitions = Command::new("actuator").subcommand(fit);
        let line = ["fit", "a.csv", "--order", "3", "--check", "b.csv", "--force"];
        let matches = definitions.clone().get_matches_from(once("actuator").chain(line));
        let invocation = Invocation::new(line.iter().map(OsString::from), &definitions, &matches);
        assert_eq!(invocation.options, ["--order 3", "--force"]);
        assert_eq!(invocation.shell(), "actuator fit a.csv --order 3 --check b.csv --force");
    }
}
