//! The window's content in egui's test harness: what the hand does and what is then seen.
//!
//! Pixels of the screen are looked at, too, as the processor draws the window, and on a device where there is one;
//! without one these tests show as ignored, with the reason. `CATOPTRIC_REQUIRE_GPU=1` makes them fail then. Tests of
//! reports and bakes show so, too, without the program `catoptric`, and fail then where `CI` is set.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]
#![expect(clippy::print_stdout, reason = "what was measured is printed")]

mod apart;
#[cfg(target_os = "linux")]
mod desktop;
mod documents;
mod errands;
mod first_minute;
mod hand;
mod overlays;
mod painted;
mod random;
mod restart;
mod screen;
mod session;

use libtest_mimic::{Arguments, Trial};

fn main() {
    // As the program does.
    catoptric_viewer::memory::keep_little();
    let arguments = Arguments::from_args();
    let mut trials = hand::trials();
    trials.extend(random::trials());
    trials.extend(screen::trials());
    trials.extend(documents::trials());
    trials.extend(first_minute::trials());
    trials.extend(errands::trials());
    #[cfg(target_os = "linux")]
    trials.extend(desktop::trials());
    trials.extend(overlays::trials());
    trials.extend(restart::trials());
    libtest_mimic::run(&arguments, trials).exit();
}

/// A test that cannot be made here: ignored with the reason, or failed where it is required.
fn lacking(name: &str, reason: String, is_required: bool) -> Trial {
    let trial = Trial::test(format!("{name} ({reason})"), move || Err(reason.into()));
    trial.with_ignored_flag(!is_required)
}

/// A test by its name.
fn trial(name: &str, test: fn()) -> Trial {
    Trial::test(name, move || {
        test();
        Ok(())
    })
}
