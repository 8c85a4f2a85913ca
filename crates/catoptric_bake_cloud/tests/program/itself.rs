//! The program `catoptric` with its feature `cloud`: the file of these tests, started once more.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

/// The variable that makes the file the program. Schedulers pass it on to jobs, whose scripts name the file alone.
const VARIABLE: &str = "CATOPTRIC_TESTED_PROGRAM";

/// Runs the program in place of the tests, if that is what was started.
pub(crate) fn run() -> Option<ExitCode> {
    std::env::var_os(VARIABLE).map(|_| catoptric_cli::run(std::env::args_os()))
}

/// The program's file.
pub(crate) fn path() -> PathBuf {
    std::env::current_exe().unwrap()
}

/// A command of the program.
pub(crate) fn command() -> Command {
    let mut command = Command::new(path());
    command.env(VARIABLE, "1");
    command
}
