//! The ends of the program other than success: messages and exit codes.

pub(crate) mod memory;
pub(crate) mod text;

use catoptric::output;
use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Exit code of a bake that stopped before its end: try again.
pub(crate) const STOPPED: u8 = 75;
/// Exit code of work that a signal ended: the shells' number for Ctrl-C.
const INTERRUPTED: u8 = 130;

/// From a signal to the end of work that could end by itself, if it does not.
const GRACE: Duration = Duration::from_millis(800);

/// Set when a signal requests the program to stop.
static STOP: AtomicBool = AtomicBool::new(false);
/// Set while a signal requests the work to stop before it ends the program.
static IS_SOFT: AtomicBool = AtomicBool::new(false);

/// Ends the program on Ctrl-C, SIGTERM and SIGHUP without leaving anything temporary behind. Signals that were ignored
/// when it started stay ignored (`nohup`), and files that grow beyond the limit of the system are errors of writing.
pub(crate) fn listen_for_signals() -> Result<(), Failure> {
    // Threads that are started later on inherit it.
    #[cfg(unix)]
    signals::block()?;
    let stop = || match IS_SOFT.load(Ordering::SeqCst) {
        true => {
            STOP.store(true, Ordering::SeqCst);
            std::thread::sleep(GRACE);
            say("stopped, with units at work: they are made anew when it is run again");
            output::exit(STOPPED.into());
        }
        false => output::exit(INTERRUPTED.into()),
    };
    ctrlc::set_handler(stop).map_err(|error| Failure::input(format!("cannot listen for signals: {error}")))
}

#[cfg(unix)]
mod signals {
    use super::Failure;
    use nix::sys::signal::{SigSet, Signal};

    /// Blocks the signal of files that are too large, and those that are ignored now.
    pub(super) fn block() -> Result<(), Failure> {
        let ignored = ignored();
        let mut blocked = SigSet::empty();
        blocked.add(Signal::SIGXFSZ);
        for signal in [Signal::SIGHUP, Signal::SIGINT, Signal::SIGTERM] {
            if ignored >> (signal as u64 - 1) & 1 != 0 {
                blocked.add(signal);
            }
        }
        blocked.thread_block().map_err(|error| Failure::input(format!("cannot block signals: {error}")))
    }

    /// A bit for each signal that is ignored, from 1 on, where the system tells it in `/proc`.
    fn ignored() -> u64 {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
    }
}

/// From now on a signal sets the flag that this returns, and ends the program only if that has not done so soon.
pub(crate) fn stop_softly() -> &'static AtomicBool {
    IS_SOFT.store(true, Ordering::SeqCst);
    &STOP
}

/// Prints a line on standard error, where it can be printed: no program can complain of that.
pub(crate) fn say(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// The text of a file that the user names.
pub(crate) fn read_text(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|error| {
        let problem = match error.kind() {
            io::ErrorKind::InvalidData => "is no text; save it as UTF-8".into(),
            _ => format!("cannot read it: {error}"),
        };
        Failure::input(format!("{}: {problem}", path.display()))
    })
}

/// The outcome of writing to standard output.
pub(crate) fn written(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        // A reader that closes the pipe early (`| head`) has had enough; that is no fault.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::input(format!("standard output: cannot write to it: {error}")))
        }
        _ => Ok(()),
    }
}

/// The message and exit code of a command that did not succeed.
pub(crate) struct Output {
    /// For standard output.
    pub(crate) text: String,
    /// The exit code; other than 0 also if it carries an answer although nothing went wrong.
    pub(crate) code: u8,
}

impl From<String> for Output {
    fn from(text: String) -> Self {
        Self { text, code: 0 }
    }
}

/// Why the program stops.
pub(crate) enum Failure {
    /// The command line is wrong: exit code 2.
    Usage(String),
    /// The input or the environment is at fault: exit code 1.
    Input(anyhow::Error),
}

impl Failure {
    pub(crate) fn usage(problem: impl Display) -> Self {
        Self::Usage(problem.to_string())
    }

    pub(crate) fn input(problem: impl Display) -> Self {
        Self::Input(anyhow::anyhow!("{problem}"))
    }

    /// The one message about the failure.
    pub(crate) fn message(&self) -> String {
        match self {
            Self::Usage(problem) => problem.clone(),
            Self::Input(error) => error.to_string(),
        }
    }

    /// Prints the one message and gives the exit code.
    pub(crate) fn report(&self) -> ExitCode {
        match self {
            Self::Usage(problem) => {
                say(format_args!("error: {}\n\nFor more information, try '--help'.", text::some_lines(problem)));
                ExitCode::from(2)
            }
            Self::Input(error) => {
                // The library's messages already contain their causes.
                say(format_args!("error: {}", text::some_lines(&error.to_string())));
                ExitCode::from(1)
            }
        }
    }
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Input(error.into())
    }
}
