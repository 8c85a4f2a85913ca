//! The program `catoptric`: pictures of reflections by several methods, and how far each is from the ray-traced truth.

mod args;
mod commands;
mod drawing;
mod failure;
mod parse;
mod report;
mod scene_source;
mod settings;
mod stats;
mod terminal;

use args::{Cli, Command, Global};
use clap::{ArgMatches, CommandFactory, FromArgMatches};
use failure::Failure;
use std::io::Write;
use std::process::ExitCode;
use terminal::Terminal;

fn main() -> ExitCode {
    let matches = Cli::command().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let options = matches.subcommand().map(|(_, options)| options.clone()).unwrap_or_default();
    match run(&cli, &options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

fn run(cli: &Cli, options: &ArgMatches) -> Result<(), Failure> {
    set_threads(&cli.global)?;
    let terminal = Terminal::new(&cli.global);
    let output = match &cli.command {
        Command::Render(args) => commands::render::run(args, options, &terminal)?,
        Command::Compare(args) => commands::compare::run(args, options, &terminal)?,
        Command::Project(args) => commands::project::run(args, options, &terminal)?,
        Command::Methods(args) => commands::methods::run(args)?,
        Command::Info(args) => commands::info::run(args, options)?,
        Command::Scenes(args) => commands::scenes::run(args)?,
        Command::Doctor(args) => commands::doctor::run(args)?,
        Command::Completions(args) => commands::completions(args.shell),
    };
    // A reader that closes the pipe early (`| head`) has had enough; that is no fault.
    match std::io::stdout().lock().write_all(output.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

fn set_threads(global: &Global) -> Result<(), Failure> {
    if let Some(threads) = global.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()?;
    }
    Ok(())
}
