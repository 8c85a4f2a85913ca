//! `catoptric bake submit`: a bake as an array job of Slurm.
//!
//! Slurm starts the tasks of a lost machine again, crashed ones it does not. So a second job waits for the array,
//! however that ends, submits what is missing again, and merges.

mod script;

use super::{check_place, place};
use crate::args::BakeSubmitArgs;
use crate::failure::{Failure, Output};
use crate::terminal::Terminal;
use catoptric::output;
use catoptric_bake::{Check, Plan, status};
use script::Scripts;
use std::ffi::OsStr;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

pub(super) fn run(args: &BakeSubmitArgs, terminal: &Terminal) -> Result<Output, Failure> {
    // There is one engine.
    let crate::args::Engine::Slurm = args.engine;
    let store = place::open(&args.place)?;
    let found = status(&Plan::load(&*store)?, &*store, Check::Sizes)?;
    let to_make = found.to_make().len() as u64;
    let output = absolute(&args.output.clone().unwrap_or_else(|| default_output(&args.place)));
    check_place(&output)?;
    let scripts = Scripts {
        program: program()?,
        place: whole_place(&args.place),
        name: name(&args.place).to_owned(),
        folder: script_folder(&args.place),
        output,
        tasks: args.tasks.min(to_make.max(1)),
        sbatch: args.sbatch.clone(),
    };
    scripts.check()?;
    if args.dry_run {
        return Ok(scripts.listing().into());
    }
    if to_make == 0 {
        let text = format!("{}: all {} units are done: nothing is submitted; merge them\n", args.place, found.total);
        return Ok(terminal.unless_quiet(text).into());
    }
    let (array, after) = submit(&scripts)?;
    let text = format!(
        "{}: {to_make} units in {} tasks of job {array}; job {after} makes missing ones again, at most twice, and \
        merges into {}\nmessages: {}\n",
        args.place,
        scripts.tasks,
        scripts.output.display(),
        scripts.folder.join("slurm-*").display(),
    );
    Ok(terminal.unless_quiet(text).into())
}

/// Writes the scripts and submits them; returns the numbers of both jobs.
fn submit(scripts: &Scripts) -> Result<(String, String), Failure> {
    let folder = &scripts.folder;
    fs::create_dir_all(folder)
        .map_err(|error| Failure::input(format!("{}: cannot create it: {error}", folder.display())))?;
    for (path, text) in scripts.files() {
        output::write_file(&path, |writer| writer.write_all(text.as_bytes()))?;
    }
    let array = sbatch(&[OsStr::new("--parsable"), scripts.bake_path().as_os_str()])?;
    let dependency = format!("--dependency=afterany:{array}");
    let after = sbatch(&[OsStr::new("--parsable"), OsStr::new(&dependency), scripts.finish_path().as_os_str()]);
    after.map(|after| (array.clone(), after)).map_err(|error| match error {
        Failure::Input(error) => Failure::input(format!(
            "{error}; job {array} is submitted already, without the job that merges: cancel it (scancel {array}), or \
            wait for it and merge"
        )),
        other => other,
    })
}

/// Submits a job; returns its number.
fn sbatch(words: &[&OsStr]) -> Result<String, Failure> {
    let ended = Command::new("sbatch").args(words).output().map_err(|error| match error.kind() {
        ErrorKind::NotFound => Failure::input(
            "sbatch: there is no such program here; submit on a machine of the cluster that has Slurm's commands \
            (Debian's package slurm-client), or take the scripts that --dry-run prints there",
        ),
        _ => Failure::input(format!("sbatch: cannot start it: {error}")),
    })?;
    let said = String::from_utf8_lossy(&ended.stderr);
    // With several clusters the number is followed by `;` and the cluster's name.
    let number: String = String::from_utf8_lossy(&ended.stdout).chars().take_while(char::is_ascii_digit).collect();
    if ended.status.success() && !number.is_empty() {
        return Ok(number);
    }
    let remedy = match said.contains("job array") {
        true => "; give fewer --tasks: `scontrol show config` says how many an array may have (MaxArraySize)",
        false => "",
    };
    Err(Failure::input(format!("sbatch: {} ({}){remedy}", said.trim().replace('\n', "; "), ended.status)))
}

/// This program, for the scripts.
fn program() -> Result<PathBuf, Failure> {
    let fail = |problem: String| Failure::input(format!("cannot name this program in scripts: {problem}"));
    let path = std::env::current_exe().map_err(|error| fail(error.to_string()))?;
    match path.is_file() {
        true => Ok(path),
        false => Err(fail(format!("{} is no file any more; install it, then submit again", path.display()))),
    }
}

/// The last part of a place's name, without the `.parts` that folders of units usually have.
fn name(place: &str) -> &str {
    let last = place.trim_end_matches('/').rsplit('/').next().unwrap_or_default();
    let name = last.strip_suffix(".parts").unwrap_or(last);
    if name.trim_matches('.').is_empty() { "scene" } else { name }
}

/// The file beside the place.
fn default_output(place: &str) -> PathBuf {
    let file = format!("{}.bake", name(place));
    if place::is_address(place) { file.into() } else { absolute(Path::new(place)).with_file_name(file) }
}

/// A place as other machines find it.
fn whole_place(place: &str) -> PathBuf {
    if place::is_address(place) { place.into() } else { absolute(Path::new(place)) }
}

/// The folder of scripts and messages: that of the plan; for plans in object stores one in the current folder.
fn script_folder(place: &str) -> PathBuf {
    let folder = format!("{}.slurm", name(place));
    if place::is_address(place) { absolute(Path::new(&folder)) } else { absolute(Path::new(place)) }
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_lie_beside_their_place() {
        assert_eq!(default_output("/a/room.parts/"), Path::new("/a/room.bake"));
        assert_eq!(default_output("/a/room"), Path::new("/a/room.bake"));
        assert_eq!(default_output("s3://bucket/rooms/room.parts"), Path::new("room.bake"));
        assert_eq!(script_folder("/a/room.parts"), Path::new("/a/room.parts"));
        assert!(script_folder("s3://bucket/room").ends_with("room.slurm") && script_folder("s3://b/c").is_absolute());
        assert_eq!((name("."), name("s3://bucket/"), whole_place("s3://b/c")), ("scene", "bucket", "s3://b/c".into()));
    }
}
