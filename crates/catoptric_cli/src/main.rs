//! The program `catoptric`.

use std::process::ExitCode;

fn main() -> ExitCode {
    catoptric_cli::run(std::env::args_os())
}
