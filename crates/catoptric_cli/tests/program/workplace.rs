//! A folder with a scene in which tests run the program as its users do.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A mirror ball over an unlit floor and a lit wall, with a camera of its own.
pub(crate) const BALL: &str = r#"
[camera]
eye = [0, 1, 4]
target = [0, 0.5, 0]
fov_deg = 45
[[reflector]]
name = "ball"
surface = "sphere"
center = [0, 0.5, 0]
radius = 0.8
[[reflector]]
name = "wall"
surface = "plane"
center = [0, 0, -2]
normal = [0, 0, 1]
size = [6, 4]
[role]
wall = "diffuse"
"#;

/// A folder with a `scene.toml`, in which the program runs.
pub(crate) struct Workplace {
    pub(crate) folder: TempDir,
}

impl Workplace {
    pub(crate) fn with_scene(scene: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        Self { folder }
    }

    /// Runs the program, which must end well, and gives its standard output.
    pub(crate) fn ok(&self, words: &[&str]) -> String {
        self.ends(0, words)
    }

    /// The same, read as JSON.
    pub(crate) fn listed(&self, words: &[&str]) -> Value {
        serde_json::from_str(&self.ok(words)).unwrap()
    }

    /// Messages of command lines that must fail with this exit code name what is wrong.
    pub(crate) fn names_faults(&self, code: i32, before: &[&str], faults: &[(&[&str], &str)]) {
        let files = self.files();
        for (words, named) in faults {
            let message = self.fails(code, &[before, words].concat());
            assert!(message.contains(named), "{words:?} should name {named}: {message}");
            assert_eq!(self.files(), files, "{words:?} left something behind");
        }
    }

    pub(crate) fn new() -> Self {
        Self::with_scene(BALL)
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), contents).unwrap();
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }

    /// The program with these words. It draws on the processor, the same on every machine, unless they say otherwise.
    pub(crate) fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_catoptric"));
        command.args(words).current_dir(self.folder.path());
        let draws = matches!(words.first(), Some(&("render" | "compare")));
        if draws && !["--backend", "--adapter"].iter().any(|option| words.contains(option)) {
            command.args(["--backend", "cpu"]);
        }
        command
    }

    pub(crate) fn run(&self, words: &[&str]) -> Output {
        self.command(words).output().unwrap()
    }

    /// Runs the program, which must end with this exit code, and gives its standard output.
    pub(crate) fn ends(&self, code: i32, words: &[&str]) -> String {
        let output = self.run(words);
        assert_eq!(output.status.code(), Some(code), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs the program, which must end with this exit code and nothing on standard output, and gives its message.
    pub(crate) fn fails(&self, code: i32, words: &[&str]) -> String {
        let output = self.run(words);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{words:?}: {message}");
        assert!(output.stdout.is_empty(), "{words:?}");
        assert!(message.starts_with("error:") && !message.contains("panicked"), "{words:?}: {message}");
        message
    }

    pub(crate) fn files(&self) -> Vec<String> {
        files(self.folder.path())
    }
}

/// The names in a folder, in order.
pub(crate) fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}
