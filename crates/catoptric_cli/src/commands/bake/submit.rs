//! `catoptric bake submit`: a bake as an array job of Slurm.

use crate::args::BakeSubmitArgs;
use crate::failure::{Failure, Output};
use crate::terminal::Terminal;

#[cfg(not(feature = "cloud"))]
pub(super) fn run(_: &BakeSubmitArgs, _: &Terminal) -> Result<Output, Failure> {
    Err(super::place::without_cloud("bake submit"))
}

#[cfg(feature = "cloud")]
pub(super) fn run(args: &BakeSubmitArgs, terminal: &Terminal) -> Result<Output, Failure> {
    use catoptric_bake::{Check, Plan, status};
    use catoptric_bake_cloud::{SlurmError, SlurmScripts};
    // There is one engine.
    let crate::args::Engine::Slurm = args.engine;
    let store = super::place::open(&args.place)?;
    let found = status(&Plan::load(&*store)?, &*store, Check::Sizes)?;
    let to_make = found.to_make().len() as u64;
    let tasks = args.tasks.min(to_make);
    let scripts = SlurmScripts::new(program()?, &args.place, args.output.as_deref(), tasks, args.sbatch.clone());
    let scripts = scripts.map_err(|error| match error {
        SlurmError::Option { .. } => Failure::usage(error),
        _ => error.into(),
    })?;
    super::place::check_file(scripts.output())?;
    if args.dry_run {
        return Ok(scripts.listing().into());
    }
    if to_make == 0 {
        let text = format!("{}: all {} units are done: nothing is submitted; merge them\n", args.place, found.total);
        return Ok(terminal.unless_quiet(text).into());
    }
    let jobs = scripts.submit()?;
    let text = format!(
        "{}: {to_make} units in {tasks} tasks of job {}; job {} makes missing ones again, at most twice, and merges \
        into {}\nmessages: {}\n",
        args.place,
        jobs.array,
        jobs.finish,
        scripts.output().display(),
        scripts.folder().join("slurm-*").display(),
    );
    Ok(terminal.unless_quiet(text).into())
}

/// This program, for the scripts.
#[cfg(feature = "cloud")]
fn program() -> Result<std::path::PathBuf, Failure> {
    let fail = |problem: String| Failure::input(format!("cannot name this program in scripts: {problem}"));
    let path = std::env::current_exe().map_err(|error| fail(error.to_string()))?;
    match path.is_file() {
        true => Ok(path),
        false => Err(fail(format!("{} is no file any more; install it, then submit again", path.display()))),
    }
}
