//! `catoptric bake`: long precomputation, whole or step by step.

mod amount;
mod frames;
mod place;
mod recipe;
mod submit;

use super::pretty;
use crate::args::{
    BakeAllArgs, BakeArgs, BakeMergeArgs, BakePlanArgs, BakeRunArgs, BakeStatusArgs, BakeStep, BakeViewsArgs,
};
use crate::failure::{self, Failure, Output, STOPPED};
use crate::terminal::Terminal;
use amount::{size, summary};
use catoptric::output;
use catoptric::progress::Stage;
use catoptric_bake::{
    Check, Claim, Identity, PLAN_NAME, Plan, RunOptions, RunReport, Shard, Store, Work, merge, merge_through, status,
};
use clap::ArgMatches;
use recipe::{Recipe, read_recipe};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Exit code of `status` where units are missing.
const INCOMPLETE: u8 = 3;

pub(crate) fn run(args: &BakeArgs, options: &ArgMatches, terminal: &Terminal) -> Result<Output, Failure> {
    let step = match args {
        BakeArgs::All(args) => return all(args, options, terminal),
        BakeArgs::Step(step) => step.as_ref(),
    };
    let options = options.subcommand().map_or(options, |(_, options)| options);
    match step {
        BakeStep::Plan(args) => plan(args, options, terminal),
        BakeStep::Views(args) => views(args, options, terminal),
        BakeStep::Frames(args) => frames::plan(args, options, terminal),
        BakeStep::Run(args) => run_shard(args, terminal),
        BakeStep::Status(args) => tell_status(args, terminal),
        BakeStep::Merge(args) => merge_units(args, terminal),
        BakeStep::Submit(args) => submit::run(args, terminal),
    }
}

/// Plan, run and merge on this machine.
fn all(args: &BakeAllArgs, options: &ArgMatches, terminal: &Terminal) -> Result<Output, Failure> {
    place::check_file(&args.output)?;
    let recipe = Recipe::new(&args.what, options)?;
    let ingredients = recipe.ingredients(terminal)?;
    let bake = ingredients.bake()?;
    let name = args.output.display();
    let is_made = || args.output.is_file() && bake.open(&args.output).is_ok_and(|file| bake.is_current(&file));
    let nothing_to_do = || Ok(terminal.unless_quiet(format!("{name}: is the bake asked for already\n")).into());
    if is_made() {
        return nothing_to_do();
    }
    let mut parts = args.output.clone().into_os_string();
    parts.push(".parts");
    let (plan, units) = bake.plan(serde_json::to_value(&recipe)?)?;
    // The same command may be at work already: both share the parts, and the last one removes them.
    let claim = Claim::new(PathBuf::from(parts))?;
    let store = claim.store();
    if is_made() {
        // By another one, in the meantime.
        claim.remove(&plan);
        return nothing_to_do();
    }
    plan.publish(store)?;
    let before = status(&plan, store, Check::Sizes)?;
    terminal.say(&format!("{name}: {}", summary(&plan, &before)));
    let report = work(&plan, store, &units, Portion::ALL, args.stop.max_time, terminal)?;
    if report.left > 0 {
        return Ok(stopped(&report, &name.to_string(), terminal));
    }
    // Through the folder of the parts, so that nothing is left beside it if this is killed.
    let merged = merge_through(&plan, store, &store.folder().join(PLAN_NAME), &args.output)?;
    claim.remove(&plan);
    let text = format!("{name}: {} units, {}\n", merged.units, size(merged.bytes));
    Ok(terminal.unless_quiet(text).into())
}

fn plan(args: &BakePlanArgs, options: &ArgMatches, terminal: &Terminal) -> Result<Output, Failure> {
    place::check(&args.output)?;
    let recipe = Recipe::new(&args.what, options)?;
    let ingredients = recipe.ingredients(terminal)?;
    let bake = ingredients.bake()?;
    let store = place::create(&args.output)?;
    let (plan, _) = bake.plan(serde_json::to_value(&recipe)?)?;
    plan.publish(&*store)?;
    let text = format!("{}: {}\n", args.output, summary(&plan, &status(&plan, &*store, Check::Sizes)?));
    Ok(terminal.unless_quiet(text).into())
}

/// The manifest of views that are made elsewhere.
fn views(args: &BakeViewsArgs, options: &ArgMatches, terminal: &Terminal) -> Result<Output, Failure> {
    let ingredients = Recipe::new(&args.what, options)?.ingredients(terminal)?;
    let manifest = ingredients.views_manifest()?;
    output::write_file(&args.output, |writer| writer.write_all(manifest.as_bytes()))?;
    let count = manifest.lines().filter(|line| *line == "[[view]]").count();
    Ok(terminal.unless_quiet(format!("{}: {count} views\n", args.output.display())).into())
}

fn run_shard(args: &BakeRunArgs, terminal: &Terminal) -> Result<Output, Failure> {
    let shard: Shard = match args.shard.as_deref() {
        None => Shard::ALL,
        Some("auto") => Shard::from_environment(|name| std::env::var(name).ok())?,
        Some(text) => text.parse().map_err(Failure::usage)?,
    };
    let store = place::open(&args.place)?;
    let plan = Plan::load(&*store)?;
    let file = store.place(PLAN_NAME);
    let units = args.units.as_deref().map(read_units).transpose()?;
    let portion = Portion { shard, units: units.as_deref() };
    let max_time = args.stop.max_time;
    let report = if let Some(recipe) = frames::recipe_of(&plan, &file)? {
        let view = recipe.view();
        let sequence = recipe.sequence(&view, terminal)?;
        refuse_changed(&plan, &sequence.identity()?, &file)?;
        work(&plan, &*store, &sequence, portion, max_time, terminal)?
    } else {
        let ingredients = read_recipe::<Recipe>(&plan, &file)?.ingredients(terminal)?;
        let bake = ingredients.bake()?;
        refuse_changed(&plan, &bake.identity()?, &file)?;
        work(&plan, &*store, &bake.units()?, portion, max_time, terminal)?
    };
    if report.left > 0 {
        return Ok(stopped(&report, &args.place, terminal));
    }
    let RunReport { made, skipped, replaced, beaten, .. } = report;
    let text = format!(
        "{}: shard {shard}: {made} units made, {skipped} were there, {replaced} replaced, {beaten} made by others \
        first\n",
        args.place
    );
    Ok(terminal.unless_quiet(text).into())
}

/// Refuses a plan of something else than what its recipe leads to now.
fn refuse_changed(plan: &Plan, now: &Identity, file: &str) -> Result<(), Failure> {
    match plan.identity.difference(now) {
        None => Ok(()),
        Some(difference) => Err(Failure::input(format!(
            "{file}: the scene or the program has changed since: {difference}; plan again elsewhere"
        ))),
    }
}

fn tell_status(args: &BakeStatusArgs, terminal: &Terminal) -> Result<Output, Failure> {
    let store = place::open(&args.place)?;
    let plan = Plan::load(&*store)?;
    let check = if args.verify { Check::Contents } else { Check::Sizes };
    let found = status(&plan, &*store, check)?;
    let code = if found.is_complete() { 0 } else { INCOMPLETE };
    let text = if args.json {
        pretty(&found)?
    } else if args.missing {
        found.to_make().iter().map(|number| format!("{number}\n")).collect()
    } else {
        let mut text = format!("{}: {} of {} units are done", args.place, found.complete, found.total);
        for bad in &found.bad {
            text += &format!("\n  {} {}", bad.file, bad.why);
        }
        if !found.left_over.is_empty() {
            text += &format!("\n  {} temporary files, of runs at work or killed", found.left_over.len());
        }
        terminal.unless_quiet(text + "\n")
    };
    Ok(Output { text, code })
}

fn merge_units(args: &BakeMergeArgs, terminal: &Terminal) -> Result<Output, Failure> {
    let store = place::open(&args.place)?;
    let plan = Plan::load(&*store)?;
    if let Some(recipe) = frames::recipe_of(&plan, &store.place(PLAN_NAME))? {
        return frames::write(&recipe, &plan, &*store, &args.output, terminal);
    }
    let merged = merge(&plan, &*store, &args.output)?;
    let text = format!("{}: {} units, {}\n", args.output.display(), merged.units, size(merged.bytes));
    Ok(terminal.unless_quiet(text).into())
}

/// The units that one run makes.
#[derive(Clone, Copy)]
struct Portion<'a> {
    shard: Shard,
    units: Option<&'a [u64]>,
}

impl Portion<'_> {
    const ALL: Self = Self { shard: Shard::ALL, units: None };
}

/// The numbers in a file, one a line.
fn read_units(path: &Path) -> Result<Vec<u64>, Failure> {
    let fail = |problem: String| Failure::input(format!("{}: {problem}", path.display()));
    let text = failure::read_text(path)?;
    let number = |(line, text): (usize, &str)| {
        let problem = || format!("line {}: `{text}` is no unit's number; `status --missing` prints such", line + 1);
        text.trim().parse().map_err(|_| fail(problem()))
    };
    text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()).map(number).collect()
}

/// Makes units until the shard is done, the time is up or a signal requests a stop.
fn work(
    plan: &Plan,
    store: &dyn Store,
    units: &dyn Work,
    Portion { shard, units: listed }: Portion<'_>,
    max_time: Option<Duration>,
    terminal: &Terminal,
) -> Result<RunReport, Failure> {
    // Units that take long are given up: published ones stay.
    let stop = failure::stop_softly();
    let until = max_time.map(|time| Instant::now() + time);
    terminal.set_subject(&plan.identity.method);
    let options = RunOptions { shard, units: listed, stop, until, ..RunOptions::default() };
    let count: u64 = options.batches(plan).iter().map(|batch| batch.end - batch.start).sum();
    let stage = Stage::begin(terminal, "baking", count as usize)?;
    let tell = |done: &catoptric_bake::UnitDone<'_>| {
        if terminal.tell(done) {
            return;
        }
        if let Some(note) = done.note.filter(|_| terminal.verbose) {
            terminal.say_above(&format!("{}: {note}", done.name));
        }
        // The terminal cancels nothing.
        let _ = stage.advance(1);
    };
    Ok(catoptric_bake::run(plan, store, units, &RunOptions { on_unit: &tell, ..options })?)
}

fn stopped(report: &RunReport, place: &str, terminal: &Terminal) -> Output {
    let done = report.made + report.skipped + report.replaced + report.beaten;
    let text = format!("{place}: stopped: {done} of {} units are done; run it again to go on\n", done + report.left);
    Output { text: terminal.unless_quiet(text), code: STOPPED }
}
