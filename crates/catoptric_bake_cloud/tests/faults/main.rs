//! Bakes on a cluster of Slurm on this machine, with lost nodes and killed tasks.
//!
//! Where Slurm is not installed these tests show as ignored, with the reason.

#![cfg_attr(target_os = "linux", expect(clippy::unwrap_used, reason = "a test that cannot go on must fail"))]
#![cfg_attr(target_os = "linux", expect(clippy::print_stdout, reason = "what was measured is printed"))]

#[cfg(target_os = "linux")]
mod bake;
#[cfg(target_os = "linux")]
#[path = "../program/itself.rs"]
mod itself;
#[cfg(target_os = "linux")]
mod slurm;

use libtest_mimic::{Arguments, Trial};
use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    if let Some(code) = itself::run() {
        return code;
    }
    let mut arguments = Arguments::from_args();
    // One cluster at a time.
    arguments.test_threads = Some(1);
    libtest_mimic::run(&arguments, trials()).exit_code()
}

#[cfg(not(target_os = "linux"))]
fn trials() -> Vec<Trial> {
    Vec::new()
}

#[cfg(target_os = "linux")]
fn trials() -> Vec<Trial> {
    let slurm = slurm::missing_program().map(|program| format!("Slurm is not installed: there is no {program}"));
    let faults = "lost, cut off and killed tasks end in the file of an undisturbed bake";
    let efficiency = "the share of time that is spent in units, without faults";
    vec![
        trial(faults, slurm.clone(), bake::with_faults),
        // The measure of efficiency runs only when it is asked for.
        trial(efficiency, slurm, bake::efficiency).with_ignored_flag(true),
    ]
}

/// A test, ignored where something is missing.
#[cfg(target_os = "linux")]
fn trial(name: &str, missing: Option<String>, test: fn()) -> Trial {
    match missing {
        None => Trial::test(name, move || {
            test();
            Ok(())
        }),
        Some(reason) => Trial::test(format!("{name} ({reason})"), move || Err(reason.into())).with_ignored_flag(true),
    }
}
