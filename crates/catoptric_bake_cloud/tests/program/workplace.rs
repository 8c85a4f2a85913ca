//! A folder in which tests run the program as its users do.

use crate::itself;
use std::path::PathBuf;
use std::process::Command;
use tempfile::TempDir;

/// A bake of 36 units.
pub(crate) const WHAT: [&str; 9] =
    ["builtin:sphere_room", "--method", "light_field", "--set", "st=6", "--set", "uv=16", "--set", "capture_samples=1"];

/// A folder, and the environment of what runs in it.
pub(crate) struct Workplace {
    folder: TempDir,
    variables: Vec<(String, String)>,
}

impl Workplace {
    pub(crate) fn new(variables: Vec<(String, String)>) -> Self {
        Self { folder: tempfile::tempdir().unwrap(), variables }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    pub(crate) fn command(&self, words: &[&str]) -> Command {
        let mut command = itself::command();
        let variables = self.variables.iter().map(|(name, value)| (name, value));
        command.args(words).current_dir(self.folder.path()).envs(variables);
        command
    }

    /// Runs the program, which must end with this exit code. Gives its message if that is 1, which nothing on standard
    /// output may come with, else its standard output.
    pub(crate) fn ends(&self, code: i32, words: &[&str]) -> String {
        let ended = self.command(words).output().unwrap();
        let said = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(code), "{words:?}: {said}");
        if code != 1 {
            return String::from_utf8(ended.stdout).unwrap();
        }
        assert!(ended.stdout.is_empty(), "{words:?}");
        assert!(said.starts_with("error:") && !said.contains("panicked"), "{words:?}: {said}");
        said
    }
}
