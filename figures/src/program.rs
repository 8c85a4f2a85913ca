//! The program, run for pictures and numbers.

use crate::commands::Line;
use crate::repository::run;
use anyhow::{Context, Result};
use image::RgbImage;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// The variable that names a program which is there already.
const PROGRAM: &str = "CATOPTRIC_PROGRAM";

/// The program's command line: of the program that the environment names, or one that is built.
pub(crate) fn catoptric(words: &[&str]) -> Command {
    if let Some(program) = std::env::var_os(PROGRAM) {
        let mut command = Command::new(program);
        command.args(words);
        return command;
    }
    let mut command = Command::new(env!("CARGO"));
    command.args(["run", "--release", "--locked", "-q", "-p", "catoptric_cli", "--"]).args(words);
    command
}

/// The command that runs a line.
pub(crate) fn command(line: &Line) -> Command {
    let words: Vec<&str> = line.0.iter().map(String::as_str).collect();
    catoptric(&words)
}

/// The picture that a `render` command draws into a file.
pub(crate) fn picture(command: &mut Command, path: &Path) -> Result<RgbImage> {
    run(command.arg("-o").arg(path))?;
    Ok(image::open(path).with_context(|| format!("cannot read {}", path.display()))?.to_rgb8())
}

/// The numbers in a file of the program's.
pub(crate) fn json(path: &Path) -> Result<Value> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    serde_json::from_str(&text).with_context(|| format!("{} is no JSON", path.display()))
}

/// The rows of a comparison of methods with the reference, the reference's first.
pub(crate) fn compare(scene: &str, words: &[&str], methods: &[&str], report: &Path) -> Result<Vec<Value>> {
    let mut command = catoptric(&["compare", scene, "--quiet", "--method", "reference"]);
    command.args(words).arg("--report").arg(report);
    for method in methods {
        command.args(["--method", method]);
    }
    run(&mut command)?;
    Ok(json(&report.join("report.json"))?.as_array().cloned().unwrap_or_default())
}
