//! Chores of the project's developers: `cargo xtask COMMAND`.
#![expect(clippy::print_stdout, reason = "what chores have come to is printed")]

mod check_all;
mod command;
mod new_method;
mod web;

use anyhow::{Result, bail};
use std::process::Command;

const HELP: &str = "\
Usage: cargo xtask COMMAND

Commands:
  new-method NAME --family lookup|projection [--bake] [--layout]
                   make the folder of a method with all roles, its lines in the registry, a test and a bench that
                   fail until it draws
  web [--serve [PORT] | --test [FOLDER [WORD]] [--graphics webgpu|webgl|none]]
                   build the viewer for browsers into dist; serve it on this machine; test it, or a folder that was
                   built before, in Chromium: all tests, those with a word in their names, those with one kind of
                   graphics
  ci               run what continuous integration runs
  check-all [--list] [--only NAME]... [--random-seconds N]
                   run everything that can be tested, which takes hours; list the steps; run those of these names

Pictures, plots and tables of the documents: cargo figures --help";

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["new-method", ref rest @ ..] => new_method::make(rest),
        ["web", ref rest @ ..] => web::run(rest),
        ["ci"] => command::run(Command::new("bash").arg(".ci/run")),
        ["check-all", ref rest @ ..] => check_all::run(rest),
        ["--help" | "-h"] => {
            println!("{HELP}");
            Ok(())
        }
        [other, ..] => bail!("there is no command `{other}`\n\n{HELP}"),
        [] => bail!("{HELP}"),
    }
}
