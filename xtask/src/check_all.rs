//! Everything that can be tested, in steps, each going on after the failures of others.

use crate::command::{root, run as succeed};
use crate::web;
use anyhow::{Context, Result, bail, ensure};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The target whose library is another one than this machine's.
const MUSL: &str = "x86_64-unknown-linux-musl";

/// A folder of a file system of a few MiB, for the step that fills it.
const SMALL_DISK: &str = "CATOPTRIC_SMALL_DISK";

/// One command, by a name for `--only`.
struct Step {
    name: &'static str,
    /// A line for `--list`.
    about: &'static str,
    /// Tells why it cannot run on this machine, once what can be installed by Rust itself is.
    missing: fn() -> Option<String>,
    command: fn(&Options) -> Command,
}

/// The words of the command line.
#[derive(Debug, PartialEq)]
struct Options {
    is_list: bool,
    /// Names of steps; none stand for all.
    only: Vec<String>,
    random_seconds: u32,
}

/// The end of a step.
enum Outcome {
    Passed(Tally),
    Failed(String),
    LeftOut(String),
}

/// Tests that a command has told of.
#[derive(Debug, Default, PartialEq)]
struct Tally {
    /// Programs of tests.
    programs: u64,
    passed: u64,
    ignored: u64,
    /// The first that was ignored, which may tell why.
    first_ignored: Option<String>,
}

/// All steps in the order in which they run.
const STEPS: [Step; 9] = [
    Step {
        name: "tests",
        about: "all tests of all packages",
        missing: nothing,
        command: |_| cargo("test --workspace --no-fail-fast --locked"),
    },
    Step {
        name: "same-bits",
        about: "scenes and bakes have the same bits with musl's library",
        missing: no_musl,
        command: |_| {
            let mut command = cargo("test -p catoptric_scenes -p catoptric_bake --test same_bits --locked --target");
            command.arg(MUSL);
            command
        },
    },
    Step {
        name: "parity",
        about: "pictures of the GPU against the processor's: every pair of methods, scenes and qualities",
        missing: nothing,
        command: |_| {
            let mut command = cargo("test -p catoptric_gpu --features wgpu --test parity --locked");
            command.env("CATOPTRIC_PARITY", "all");
            command
        },
    },
    Step {
        name: "page",
        about: "the viewer's page in Chromium, with every kind of graphics",
        missing: no_browser,
        command: |_| cargo("run -p xtask --locked -- web --test"),
    },
    Step {
        name: "random",
        about: "the viewer under random input, an hour unless --random-seconds is given",
        missing: nothing,
        command: |options| {
            let mut command = cargo("test -p catoptric_viewer --test window --locked -- --nocapture random");
            command.env("CATOPTRIC_RANDOM_SECONDS", options.random_seconds.to_string());
            command
        },
    },
    Step {
        name: "slow",
        about: "the library's tests that `cargo test` leaves out: busy scenes, errors against settings, many cases",
        missing: nothing,
        command: |_| {
            cargo(
                "test --release -p catoptric -p catoptric_engine -p catoptric_lookup -p catoptric_projection \
                 --tests --no-fail-fast --locked -- --ignored",
            )
        },
    },
    Step {
        name: "cluster",
        about: "the share of time that a cluster spends in units, on Slurm",
        missing: no_slurm,
        command: |_| {
            cargo("test --release -p catoptric_bake_cloud --test faults --locked -- --ignored --nocapture share")
        },
    },
    Step {
        name: "full-disk",
        about: "a disk that is full for real: CATOPTRIC_SMALL_DISK names a folder of a file system of a few MiB",
        missing: no_small_disk,
        command: |_| cargo("test -p catoptric_bake --lib --locked a_disk_that_is_full -- --ignored"),
    },
    Step {
        name: "fuzz",
        about: "the fuzz targets compile",
        missing: no_fuzzing,
        command: |_| {
            let mut command = cargo("check --locked");
            command.current_dir(root().join("fuzz"));
            command
        },
    },
];

impl Options {
    fn parse(words: &[&str]) -> Result<Self> {
        let mut options = Self { is_list: false, only: Vec::new(), random_seconds: 3600 };
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match *word {
                "--list" => options.is_list = true,
                "--only" => {
                    let name = words.next().context("--only NAME: no NAME")?;
                    let known = STEPS.map(|step| step.name);
                    ensure!(known.contains(name), "there is no step `{name}`, but {}", known.join(", "));
                    options.only.push((*name).to_owned());
                }
                "--random-seconds" => {
                    let number = words.next().and_then(|word| word.parse().ok());
                    options.random_seconds = number.context("--random-seconds N: N is a whole number")?;
                }
                word => bail!("`{word}` is not understood"),
            }
        }
        Ok(options)
    }
}

/// Runs the steps that the words of the command line name, and prints how each has ended.
pub(crate) fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(words)?;
    let is_wanted = |step: &Step| options.only.is_empty() || options.only.iter().any(|name| name == step.name);
    let steps: Vec<Step> = STEPS.into_iter().filter(is_wanted).collect();
    if options.is_list {
        for step in &steps {
            println!("{:12} {}", step.name, step.about);
        }
        return Ok(());
    }
    let mut rows = Vec::new();
    for step in &steps {
        let start = Instant::now();
        let outcome = step.run(&options);
        rows.push((step.name, outcome, start.elapsed()));
    }
    println!();
    for (name, outcome, time) in &rows {
        println!("{}", row(name, outcome, *time));
    }
    let failed = rows.iter().filter(|(_, outcome, _)| matches!(outcome, Outcome::Failed(_)));
    let failed: Vec<&str> = failed.map(|(name, ..)| *name).collect();
    ensure!(failed.is_empty(), "failed: {}", failed.join(", "));
    Ok(())
}

impl Step {
    fn run(&self, options: &Options) -> Outcome {
        let mut command = (self.command)(options);
        println!("\n== {}: {}", self.name, shown(&command));
        if let Some(reason) = (self.missing)() {
            println!("left out: {reason}");
            return Outcome::LeftOut(reason);
        }
        match told(&mut command) {
            Ok(tally) => tally.outcome(),
            Err(error) => {
                println!("{error:#}");
                Outcome::Failed(format!("{error:#}"))
            }
        }
    }
}

impl Tally {
    /// Counts what a line of a test's program tells.
    fn count(&mut self, line: &str) {
        if let Some(counts) = line.strip_prefix("test result: ") {
            let number = |word: &str| {
                let before = counts.split_once(word).map_or("", |(before, _)| before);
                before.rsplit(' ').next().and_then(|digits| digits.parse::<u64>().ok()).unwrap_or_default()
            };
            self.programs += 1;
            self.passed += number(" passed");
            self.ignored += number(" ignored");
        } else if let Some((name, _)) = line.strip_prefix("test ").and_then(|line| line.split_once("... ignored")) {
            self.first_ignored.get_or_insert_with(|| name.trim().to_owned());
        }
    }

    /// How a step with this tally ends whose command has succeeded: tests that have not run have not passed.
    fn outcome(self) -> Outcome {
        match self {
            Self { programs: 1.., passed: 0, first_ignored: Some(name), .. } => {
                Outcome::LeftOut(format!("its tests are ignored here: {name}"))
            }
            Self { programs: 1.., passed: 0, .. } => Outcome::Failed("no test has run".into()),
            tally => Outcome::Passed(tally),
        }
    }
}

/// Runs a command, shows what it prints and counts the tests in it.
fn told(command: &mut Command) -> Result<Tally> {
    let mut running = command.stdout(Stdio::piped()).spawn().context("it cannot be started")?;
    let mut tally = Tally::default();
    for line in BufReader::new(running.stdout.take().context("its output is not read")?).split(b'\n') {
        let line = line.context("its output cannot be read")?;
        let line = String::from_utf8_lossy(&line);
        println!("{line}");
        tally.count(&line);
    }
    let status = running.wait().context("it has no end")?;
    ensure!(status.success(), "{status}");
    Ok(tally)
}

/// A command of cargo's, its words separated by blanks.
fn cargo(words: &str) -> Command {
    let mut command = Command::new(env!("CARGO"));
    command.args(words.split(' ')).current_dir(root());
    command
}

/// A command as it is typed into a shell.
fn shown(command: &Command) -> String {
    let is_plain = |word: &str| word.chars().all(|c| c.is_ascii_alphanumeric() || "-_=/.,:".contains(c));
    let quoted = |word: &str| if is_plain(word) { word.to_owned() } else { format!("'{word}'") };
    let folder = command.get_current_dir().and_then(|folder| folder.strip_prefix(root()).ok());
    let folder = folder.filter(|folder| *folder != Path::new("")).map(|folder| format!("cd {} &&", folder.display()));
    let variables = command.get_envs().filter_map(|(name, value)| Some((name.to_str()?, value?.to_str()?)));
    let mut words: Vec<String> = folder.into_iter().collect();
    words.extend(variables.map(|(name, value)| format!("{name}={}", quoted(value))));
    words.extend(Path::new(command.get_program()).file_stem().map(|name| name.to_string_lossy().into_owned()));
    words.extend(command.get_args().map(|word| quoted(&word.to_string_lossy())));
    words.join(" ")
}

/// A line of the table at the end.
fn row(name: &str, outcome: &Outcome, time: Duration) -> String {
    let outcome = match outcome {
        Outcome::Passed(Tally { programs: 0, .. }) => "passed".to_owned(),
        Outcome::Passed(tally) => format!("passed: {} tests, {} ignored", tally.passed, tally.ignored),
        Outcome::Failed(reason) => format!("FAILED: {reason}"),
        Outcome::LeftOut(reason) => format!("left out: {reason}"),
    };
    format!("{name:12} {:>8.1} s  {outcome}", time.as_secs_f64())
}

fn nothing() -> Option<String> {
    None
}

fn no_musl() -> Option<String> {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return Some(format!("programs for {MUSL} do not run here"));
    }
    no_target(MUSL)
}

fn no_browser() -> Option<String> {
    match web::installed() {
        Some(_) => no_target(web::TARGET),
        None => Some("Chromium is not installed".into()),
    }
}

/// Installs a target where it is not.
fn no_target(target: &str) -> Option<String> {
    let added = succeed(Command::new("rustup").args(["target", "add", target]));
    added.err().map(|error| format!("the target {target} cannot be installed: {error:#}"))
}

fn no_slurm() -> Option<String> {
    (!is_installed("slurmctld")).then(|| "Slurm is not installed".into())
}

fn no_small_disk() -> Option<String> {
    std::env::var_os(SMALL_DISK).is_none().then(|| format!("{SMALL_DISK} names no folder"))
}

/// libFuzzer is C++.
fn no_fuzzing() -> Option<String> {
    (!is_installed("c++")).then(|| "there is no C++ compiler".into())
}

/// True if a program lies in a folder of PATH or of the system's own programs.
fn is_installed(program: &str) -> bool {
    let path = format!("{}:/usr/sbin:/sbin:/usr/local/sbin", std::env::var("PATH").unwrap_or_default());
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read() {
        let options = Options::parse(&["--only", "page", "--random-seconds", "60", "--only", "fuzz"]).unwrap();
        assert_eq!(options.only, ["page", "fuzz"]);
        assert_eq!((options.random_seconds, options.is_list), (60, false));
        assert!(Options::parse(&["--list"]).unwrap().is_list);
        for words in [&["--only"][..], &["--only", "pages"], &["--random-seconds", "long"], &["page"]] {
            assert!(Options::parse(words).is_err(), "{words:?}");
        }
    }

    #[test]
    fn commands_are_shown_as_they_are_typed() {
        let options = Options::parse(&["--random-seconds", "5"]).unwrap();
        let shown = |name: &str| shown(&(STEPS.iter().find(|step| step.name == name).unwrap().command)(&options));
        assert_eq!(shown("tests"), "cargo test --workspace --no-fail-fast --locked");
        assert_eq!(shown("fuzz"), "cd fuzz && cargo check --locked");
        assert!(shown("random").starts_with("CATOPTRIC_RANDOM_SECONDS=5 cargo test "));
        assert!(shown("same-bits").ends_with(" --locked --target x86_64-unknown-linux-musl"));
    }

    #[test]
    fn tests_that_have_not_run_have_not_passed() {
        let row = |lines: &[&str]| {
            let mut tally = Tally::default();
            lines.iter().for_each(|line| tally.count(line));
            row("step", &tally.outcome(), Duration::from_millis(1500))
        };
        let passed = "test result: ok. 12 passed; 0 failed; 3 ignored; 0 measured; 4 filtered out; finished in 0.01s";
        let ignored = "test result: ok. 0 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.00s";
        let empty = "test result: ok. 0 passed; 0 failed; 0 ignored; 0 measured; 9 filtered out; finished in 0.00s";
        assert_eq!(row(&[passed, empty, passed]), "step              1.5 s  passed: 24 tests, 6 ignored");
        let reason = "test parity (no adapter) ... ignored";
        assert_eq!(
            row(&[reason, ignored]),
            "step              1.5 s  left out: its tests are ignored here: parity (no adapter)"
        );
        assert_eq!(row(&[empty]), "step              1.5 s  FAILED: no test has run");
        assert_eq!(row(&["Finished"]), "step              1.5 s  passed");
    }
}
