//! Bakes on the cluster, disturbed and undisturbed.

use crate::itself;
use crate::slurm::{Cluster, Task, signal, wait};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Rows of six slabs.
const UNITS: u64 = 6 * 34;
/// Longer than anything takes on a machine that does something else as well.
const PATIENCE: Duration = Duration::from_secs(600);

/// The scene and settings of the bake: a unit a row of views, of some tenths of a second.
const WHAT: [&str; 9] = [
    "builtin:sphere_room?tess=16",
    "--method",
    "light_field",
    "--set",
    "st=34",
    "--set",
    "uv=16",
    "--set",
    "capture_samples=16",
];

/// A folder whose name has what shells do not take as it is.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        Self { folder: tempfile::Builder::new().prefix("two words ").tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(name)
    }

    /// Runs the program, which must end well.
    fn ok(&self, command: &mut Command, words: &[&str]) -> String {
        let ended = command.args(words).current_dir(self.folder.path()).output().unwrap();
        assert!(ended.status.success(), "{words:?}: {}", String::from_utf8_lossy(&ended.stderr));
        String::from_utf8(ended.stdout).unwrap()
    }

    fn plan(&self) {
        self.ok(&mut itself::command(), &[&["bake", "plan"], &WHAT[..], &["-o", "room.parts"]].concat());
    }

    fn submit(&self, cluster: &Cluster, tasks: u64) {
        let submit = ["bake", "submit", "room.parts", "--engine", "slurm", "--tasks", &tasks.to_string()];
        let said = self.ok(&mut cluster.command(itself::command()), &submit);
        println!("{said}");
    }

    fn unit_count(&self) -> usize {
        names(&self.path("room.parts"), "unit-").len()
    }

    /// The lines that tasks print for every unit.
    fn reports(&self) -> Vec<Value> {
        let logs = names(&self.path("room.parts"), "slurm-").into_iter().filter(|name| name.ends_with(".err"));
        let texts: Vec<String> =
            logs.map(|name| fs::read_to_string(self.path("room.parts").join(name)).unwrap()).collect();
        let lines = texts.iter().flat_map(|text| text.lines());
        lines.filter_map(|line| serde_json::from_str(line).ok()).collect()
    }
}

fn names(folder: &Path, prefix: &str) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    entries.filter(|name| name.starts_with(prefix)).collect()
}

/// Says where the cluster stood when a test fails.
struct Witness<'a>(&'a Cluster, &'a Place);

impl Drop for Witness<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            println!("{}", self.0.describe());
            for name in names(&self.1.path("room.parts"), "slurm-") {
                let text = fs::read_to_string(self.1.path("room.parts").join(&name)).unwrap_or_default();
                let other: Vec<&str> = text.lines().filter(|line| !line.starts_with('{')).collect();
                println!("== {name}\n{}", other.join("\n"));
            }
        }
    }
}

/// A node is lost, one is cut off while its task lives on, a task is killed, and a bit of a unit is flipped.
pub(crate) fn with_faults() {
    const TASKS: u64 = 10;
    let (place, state) = (Place::new(), tempfile::tempdir().unwrap());
    place.ok(&mut itself::command(), &[&["bake"], &WHAT[..], &["-o", "calm.bake", "--quiet"]].concat());
    place.plan();
    let mut cluster = Cluster::start(state.path(), 3);
    place.submit(&cluster, TASKS);
    let tasks = wait("a task at work on every node", PATIENCE, || {
        let (tasks, reports) = (cluster.running(), place.reports());
        let has_begun =
            |task: &&Task| reports.iter().any(|line| line["number"].as_u64().unwrap() % TASKS == task.index);
        let on = |node: &str| tasks.iter().find(|task| task.node == node).filter(has_begun).cloned();
        Some([on("n1")?, on("n2")?, on("n3")?])
    });
    let [lost, cut_off, killed] = tasks;
    println!("lost: {lost:?}; cut off: {cut_off:?}; killed: {killed:?}; {} units are there", place.unit_count());

    let [victim] = cluster.programs(&killed.node)[..] else { panic!("one task runs on {}", killed.node) };
    signal(victim, "KILL");
    let [survivor] = cluster.programs(&cut_off.node)[..] else { panic!("one task runs on {}", cut_off.node) };
    // The surviving task sleeps until its copy has begun, so that both write at once.
    signal(survivor, "STOP");
    cluster.cut_off(&cut_off.node);
    cluster.lose(&lost.node);
    // Nobody looks at this unit again before it is merged.
    let damaged = place.path("room.parts").join(format!("unit-{:06}.bin", killed.index));
    let mut bytes = fs::read(&damaged).unwrap();
    bytes[200] ^= 1;
    fs::write(&damaged, bytes).unwrap();

    wait("two nodes that are down", PATIENCE, || {
        (cluster.is_down(&lost.node) && cluster.is_down(&cut_off.node)).then_some(())
    });
    cluster.bring_back(&lost.node);
    let again = wait("a copy of the task that was cut off", PATIENCE, || {
        cluster.running().into_iter().find(|task| task.index == cut_off.index && task.node != cut_off.node)
    });
    wait("the copy's process", PATIENCE, || (!cluster.programs(&again.node).is_empty()).then_some(()));
    assert_eq!(cluster.programs(&cut_off.node), [survivor], "the task that was cut off lives");
    signal(survivor, "CONT");
    {
        let _witness = Witness(&cluster, &place);
        wait("an idle cluster", PATIENCE, || cluster.is_idle().then_some(()));
        assert!(place.path("room.bake").is_file(), "it is merged");
    }
    wait("the end of the task that was cut off", PATIENCE, || cluster.programs(&cut_off.node).is_empty().then_some(()));
    assert!(fs::read(place.path("room.bake")).unwrap() == fs::read(place.path("calm.bake")).unwrap());

    let listed: Vec<u64> = names(&place.path("room.parts"), "missing-")
        .iter()
        .flat_map(|name| {
            let text = fs::read_to_string(place.path("room.parts").join(name)).unwrap();
            text.lines().map(|line| line.parse().unwrap()).collect::<Vec<u64>>()
        })
        .collect();
    assert!(listed.contains(&killed.index) && listed.iter().all(|unit| unit % TASKS == killed.index), "{listed:?}");
    let mut outcomes = BTreeMap::<String, u64>::new();
    for line in place.reports() {
        *outcomes.entry(line["outcome"].as_str().unwrap().into()).or_default() += 1;
    }
    println!("{} units submitted again: {listed:?}; outcomes: {outcomes:?}", listed.len());
    assert_eq!(outcomes.get("replaced"), Some(&1));
}

/// The time spent in units, of all the time that the nodes' processors had: from the submission to the merged file.
pub(crate) fn efficiency() {
    let nodes = std::thread::available_parallelism().map_or(1, usize::from).min(3);
    for tasks in [nodes as u64, 10] {
        let (place, state) = (Place::new(), tempfile::tempdir().unwrap());
        place.plan();
        let cluster = Cluster::start(state.path(), nodes);
        let begun = Instant::now();
        place.submit(&cluster, tasks);
        let _witness = Witness(&cluster, &place);
        wait("all units", PATIENCE, || (place.unit_count() == UNITS as usize).then_some(()));
        let made = begun.elapsed().as_secs_f64();
        wait("the merged file", PATIENCE, || place.path("room.bake").is_file().then_some(()));
        let merged = begun.elapsed().as_secs_f64();
        let seconds: f64 = place.reports().iter().map(|line| line["seconds"].as_f64().unwrap()).sum();
        println!(
            "{tasks} tasks on {nodes} nodes of one processor: {seconds:.1} s in {UNITS} units; all made after \
            {made:.1} s, efficiency {:.3}; merged after {merged:.1} s, {:.3}",
            seconds / (made * nodes as f64),
            seconds / (merged * nodes as f64)
        );
        assert!(seconds > 0.5 * made * nodes as f64, "half of the time is lost");
    }
}
