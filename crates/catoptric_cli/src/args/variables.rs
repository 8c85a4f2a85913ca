//! Environment variables that stand for options.

use clap::error::{ContextKind, ContextValue};
use clap::parser::ValueSource;
use clap::{ArgMatches, Command};
use std::env;

/// Options of all commands, and their variables.
const GENERAL: [(&str, &str); 1] = [("threads", "CATOPTRIC_THREADS")];
/// Options of `render` and `compare`.
const OF_PICTURES: [(&str, &str); 8] = [
    ("size", "CATOPTRIC_SIZE"),
    ("samples", "CATOPTRIC_SAMPLES"),
    ("order", "CATOPTRIC_ORDER"),
    ("backend", "CATOPTRIC_BACKEND"),
    ("adapter", "CATOPTRIC_ADAPTER"),
    ("environment", "CATOPTRIC_ENVIRONMENT"),
    ("exposure", "CATOPTRIC_EXPOSURE"),
    ("tone", "CATOPTRIC_TONE"),
];
/// Options of `render` alone.
const OF_RENDER: [(&str, &str); 1] = [("method", "CATOPTRIC_METHOD")];

fn all() -> impl Iterator<Item = (&'static str, &'static str)> {
    GENERAL.into_iter().chain(OF_PICTURES).chain(OF_RENDER)
}

/// The command line with the variables. Help lists them once, not at each option.
pub(crate) fn with_variables(command: Command) -> Command {
    let with = |command: Command, options: &[(&'static str, &'static str)]| {
        options.iter().fold(command, |command, (option, variable)| {
            command.mut_arg(option, |arg| arg.env(variable).hide_env(true))
        })
    };
    let command = with(command, &GENERAL).mut_subcommands(|command| command.allow_negative_numbers(true));
    let command = command.mut_subcommand("render", |render| with(with(render, &OF_PICTURES), &OF_RENDER));
    command.mut_subcommand("compare", |compare| with(compare, &OF_PICTURES))
}

/// The variables that a command has taken options from, with their values.
pub(crate) fn from_variables(options: &ArgMatches) -> Vec<String> {
    let is_used = |option: &str| {
        options.try_contains_id(option).unwrap_or(false)
            && options.value_source(option) == Some(ValueSource::EnvVariable)
    };
    let used = all().filter(|(option, _)| is_used(option));
    used.map(|(_, variable)| format!("{variable}={}", env::var_os(variable).unwrap_or_default().display())).collect()
}

/// The message about a command line; where a variable is at fault it is named.
pub(crate) fn name_variable(message: &clap::Error) -> Option<String> {
    let text = |kind| match message.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    let (argument, value) = (text(ContextKind::InvalidArg)?, text(ContextKind::InvalidValue)?);
    let is_at_fault = |(option, variable): &(&str, &str)| {
        let is_given = env::args_os().any(|word| {
            let word = word.to_string_lossy();
            word.strip_prefix("--").and_then(|word| word.split('=').next()) == Some(option)
        });
        let name = argument.strip_prefix("--").and_then(|rest| rest.split(' ').next());
        name == Some(option) && !is_given && env::var_os(variable).is_some_and(|set| set.to_string_lossy() == value)
    };
    let (_, variable) = all().find(is_at_fault)?;
    let quoted = format!("'{argument}'");
    Some(message.to_string().replacen(&quoted, &format!("{quoted} (from the environment variable {variable})"), 1))
}
