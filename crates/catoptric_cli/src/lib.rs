//! The program `catoptric`: pictures of reflections by several methods, and how far each is from the ray-traced truth.
//!
//! As a library it is one function, for other programs that carry this one.

mod args;
mod backend;
mod baked;
mod commands;
mod drawing;
mod failure;
mod parse;
mod report;
mod scene_source;
mod settings;
mod stats;
mod terminal;

use args::{Cli, Command, Global, from_variables, name_variable, with_tip, with_variables};
use clap::{ArgMatches, CommandFactory, FromArgMatches};
use failure::{Failure, Output, text, written};
use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;
use terminal::Terminal;

/// Runs the program with the words of a command line, its name first, and tells its exit code. It takes over the
/// process: it listens for signals, prints, and sets the number of threads. Once a process.
pub fn run(words: impl IntoIterator<Item = OsString>) -> ExitCode {
    let words: Vec<OsString> = words.into_iter().collect();
    let matches = with_variables(Cli::command()).try_get_matches_from(&words);
    let parsed = matches.and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, matches)));
    let (cli, matches) = match parsed {
        Ok(parsed) => parsed,
        Err(message) => return explain(&message),
    };
    let options = matches.subcommand().map(|(_, options)| options.clone()).unwrap_or_default();
    match obey(&cli, &options, &words) {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            let code = failure.report();
            let variables = from_variables(&options);
            if !variables.is_empty() {
                failure::say(format_args!("note: options from environment variables: {}", variables.join(", ")));
            }
            code
        }
    }
}

/// Prints the command line's help or fault.
fn explain(message: &clap::Error) -> ExitCode {
    let words = name_variable(message).or_else(|| with_tip(message)).unwrap_or_else(|| message.to_string());
    let plain = text::some_lines(&in_words(&words));
    if message.use_stderr() && plain != message.to_string() {
        failure::say(plain.trim_end());
        return ExitCode::from(2);
    }
    let printed = message.print().and_then(|()| std::io::stdout().flush());
    match written(printed) {
        Err(failure) if !message.use_stderr() => failure.report(),
        _ => ExitCode::from(u8::try_from(message.exit_code()).unwrap_or(2)),
    }
}

/// The message about a command line without the words of the libraries that read numbers.
fn in_words(message: &str) -> String {
    const WORDS: [(&str, &str); 5] = [
        ("invalid digit found in string", "it must be a whole number"),
        ("cannot parse integer from empty string", "it must be a whole number"),
        ("number too large to fit in target type", "the number is too large"),
        ("number too small to fit in target type", "the number is too small"),
        ("..=", " to "),
    ];
    WORDS.iter().fold(message.to_owned(), |text, (theirs, ours)| text.replace(theirs, ours))
}

/// Runs the command; returns the exit code.
fn obey(cli: &Cli, options: &ArgMatches, words: &[OsString]) -> Result<u8, Failure> {
    failure::listen_for_signals()?;
    set_threads(&cli.global)?;
    let terminal = Terminal::new(&cli.global);
    let output: Output = match &cli.command {
        Command::Render(args) if args.watch => commands::render::watch::run(args, options, &terminal)?.into(),
        Command::Render(args) => commands::render::run(args, options, &terminal)?.into(),
        Command::Compare(args) => commands::compare::run(args, options, (words, &terminal))?,
        Command::Project(args) => commands::project::run(args, options, &terminal)?.into(),
        Command::Bake(args) => commands::bake::run(args, options, &terminal)?,
        Command::Diff(args) => commands::diff::run(args, &terminal)?,
        Command::Explain(args) => commands::methods::explain(args)?.into(),
        Command::View(args) => commands::view::run(args)?,
        Command::Methods(args) => commands::methods::run(args)?.into(),
        Command::Info(args) => commands::info::run(args, options)?.into(),
        Command::Scenes(args) => commands::scenes::run(args)?.into(),
        Command::Doctor(args) => commands::doctor::run(args)?.into(),
        Command::Completions(args) => commands::completions::run(args.shell).into(),
    };
    let mut stdout = std::io::stdout().lock();
    let shown = text::printable(&output.text);
    written(stdout.write_all(shown.as_bytes()).and_then(|()| stdout.flush()))?;
    Ok(output.code)
}

/// The most threads for each core: more wait for each other.
const MOST_THREADS_A_CORE: usize = 4;

fn set_threads(global: &Global) -> Result<(), Failure> {
    let Some(wanted) = global.threads else { return Ok(()) };
    let most = MOST_THREADS_A_CORE * std::thread::available_parallelism()?.get();
    let threads = usize::from(wanted).min(most);
    if threads < usize::from(wanted) && !global.quiet {
        failure::say(format_args!("note: --threads {wanted}: {threads} work, {MOST_THREADS_A_CORE} for each core"));
    }
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    Ok(())
}
