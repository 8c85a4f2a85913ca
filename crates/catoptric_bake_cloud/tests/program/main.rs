//! The program `catoptric` with its feature `cloud`: bakes in object stores, and scripts for a scheduler.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]
#![expect(clippy::print_stdout, reason = "what the server did is printed")]

mod itself;
mod object_store;
#[cfg(unix)]
mod submit;
mod workplace;

use libtest_mimic::{Arguments, Trial};
use std::process::ExitCode;

fn main() -> ExitCode {
    if let Some(code) = itself::run() {
        return code;
    }
    let arguments = Arguments::from_args();
    let mut trials = object_store::trials();
    #[cfg(unix)]
    trials.extend(submit::trials());
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// A test by its name.
fn trial(name: &str, test: impl FnOnce() + Send + 'static) -> Trial {
    Trial::test(name, move || {
        test();
        Ok(())
    })
}
