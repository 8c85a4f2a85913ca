//! How the program ends when it cannot do what was asked.

use std::fmt::Display;
use std::process::ExitCode;

/// What a command has to say in the end.
pub(crate) struct Output {
    /// For standard output.
    pub(crate) text: String,
    /// The exit code: not 0 where that says something although nothing went wrong.
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
                // The library's messages already say what caused them.
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
