//! The ends of the program other than success: messages and exit codes.

use std::fmt::Display;
use std::process::ExitCode;

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

    /// Prints the one message and gives the exit code.
    pub(crate) fn report(&self) -> ExitCode {
        match self {
            Self::Usage(problem) => {
                eprintln!("error: {problem}\n\nFor more information, try '--help'.");
                ExitCode::from(2)
            }
            Self::Input(error) => {
                // The library's messages already contain their causes.
                eprintln!("error: {error}");
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
