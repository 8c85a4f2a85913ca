//! A cluster of Slurm on this machine, over loopback alone: without a database, control groups or services of the
//! system. It ends with the test, and so do the tasks on it.

use crate::itself;
use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Programs that must be there.
const PROGRAMS: [&str; 8] = ["munged", "munge", "slurmctld", "slurmd", "sbatch", "squeue", "sinfo", "scontrol"];
/// Daemons are in folders that users may not search.
const MORE_FOLDERS: &str = "/usr/sbin:/sbin:/usr/local/sbin";

/// The program that is missing for a cluster.
pub(crate) fn missing_program() -> Option<&'static str> {
    let path = search_path();
    PROGRAMS.into_iter().find(|program| !std::env::split_paths(&path).any(|folder| folder.join(program).is_file()))
}

fn search_path() -> String {
    format!("{}:{MORE_FOLDERS}", std::env::var("PATH").unwrap_or_default())
}

/// Waits until something is there, or for too long.
pub(crate) fn wait<T>(what: &str, longest: Duration, mut look: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        match look() {
            Some(found) => return found,
            None if begun.elapsed() > longest => panic!("waited {longest:?} for {what}"),
            None => std::thread::sleep(Duration::from_millis(50)),
        }
    }
}

/// A task of an array that runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Task {
    pub(crate) index: u64,
    pub(crate) node: String,
}

pub(crate) struct Cluster {
    /// Configuration, logs and sockets.
    folder: PathBuf,
    munged: Child,
    controller: Child,
    /// `None` for nodes that are lost.
    nodes: Vec<Option<Child>>,
}

impl Cluster {
    /// Starts nodes of one processor each. The path of the folder must be short, for a socket lies in it.
    pub(crate) fn start(folder: &Path, count: usize) -> Self {
        for name in ["run", "log", "state", "spool", "munge"] {
            // munged refuses folders that others could write to.
            fs::DirBuilder::new().mode(0o700).recursive(true).create(folder.join(name)).unwrap();
        }
        let mut key = fs::OpenOptions::new();
        let mut key = key.write(true).create_new(true).mode(0o600).open(folder.join("munge/key")).unwrap();
        let random = fs::File::open("/dev/urandom").unwrap();
        std::io::copy(&mut std::io::Read::take(random, 1024), &mut key).unwrap();
        fs::write(folder.join("slurm.conf"), configuration(folder, count)).unwrap();
        let start = |program: &str, words: &[&str]| start(folder, program, program, words);
        let munged = start("munged", &munge_words(folder).each_ref().map(String::as_str));
        let socket = folder.join("run/munge.sock");
        wait("munged", Duration::from_secs(20), || socket.exists().then_some(()));
        let controller = start("slurmctld", &["-D", "-f", &text(&folder.join("slurm.conf"))]);
        let mut cluster = Self { folder: folder.into(), munged, controller, nodes: Vec::new() };
        let is_up = || cluster.says("scontrol", &["ping"]).contains("is UP").then_some(());
        wait("slurmctld", Duration::from_secs(60), is_up);
        cluster.nodes = (1..=count).map(|number| Some(cluster.start_node(number))).collect();
        let idle = || cluster.says("sinfo", &["-h", "-N", "-t", "idle", "-o", "%N"]).lines().count() == count;
        wait("idle nodes", Duration::from_secs(60), || idle().then_some(()));
        cluster
    }

    fn start_node(&self, number: usize) -> Child {
        let (name, configuration) = (format!("n{number}"), text(&self.folder.join("slurm.conf")));
        start(&self.folder, &name, "slurmd", &["-D", "-c", "-N", &name, "-f", &configuration])
    }

    /// A command that knows this cluster.
    pub(crate) fn command(&self, mut command: Command) -> Command {
        command.env("PATH", search_path()).env("SLURM_CONF", self.folder.join("slurm.conf"));
        command
    }

    /// The standard output of a command of Slurm.
    pub(crate) fn says(&self, program: &str, words: &[&str]) -> String {
        let ended = self.command(Command::new(program)).args(words).output().unwrap();
        String::from_utf8_lossy(&ended.stdout).into_owned()
    }

    /// The tasks of arrays that run now.
    pub(crate) fn running(&self) -> Vec<Task> {
        let listed = self.says("squeue", &["-h", "-t", "R", "-o", "%K %N"]);
        let task = |line: &str| {
            let (index, node) = line.split_once(' ')?;
            Some(Task { index: index.parse().ok()?, node: node.trim().into() })
        };
        listed.lines().filter_map(task).collect()
    }

    /// True if nothing runs or waits.
    pub(crate) fn is_idle(&self) -> bool {
        let ended = self.command(Command::new("squeue")).arg("-h").output().unwrap();
        ended.status.success() && ended.stdout.is_empty()
    }

    /// True once Slurm has noticed that a node does not answer.
    pub(crate) fn is_down(&self, node: &str) -> bool {
        self.says("sinfo", &["-h", "-N", "-n", node, "-o", "%T"]).starts_with("down")
    }

    /// Kills a node's daemon and every process of its tasks: a machine that is lost.
    pub(crate) fn lose(&mut self, node: &str) {
        let processes = self.processes(node);
        self.cut_off(node);
        // Whoever would report the end of the others goes first.
        for pid in processes.iter().filter_map(|pid| parent_step(*pid)).chain(processes.iter().copied()) {
            signal(pid, "KILL");
        }
    }

    /// Kills a node's daemon alone: its tasks go on, and nobody hears of them.
    pub(crate) fn cut_off(&mut self, node: &str) {
        let mut daemon = self.nodes[number(node) - 1].take().unwrap();
        daemon.kill().unwrap();
        daemon.wait().unwrap();
    }

    /// Starts the daemon of a lost node again.
    pub(crate) fn bring_back(&mut self, node: &str) {
        self.nodes[number(node) - 1] = Some(self.start_node(number(node)));
    }

    /// All processes of tasks on a node.
    fn processes(&self, node: &str) -> Vec<u32> {
        let marks =
            [format!("SLURM_CONF={}", text(&self.folder.join("slurm.conf"))), format!("SLURMD_NODENAME={node}")];
        let is_marked = |pid: &u32| {
            let environment = fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
            let variables: Vec<&[u8]> = environment.split(|byte| *byte == 0).collect();
            marks.iter().all(|mark| variables.contains(&mark.as_bytes()))
        };
        let entries = fs::read_dir("/proc").unwrap().filter_map(Result::ok);
        let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
        pids.filter(is_marked).collect()
    }

    /// The processes of this program on a node.
    pub(crate) fn programs(&self, node: &str) -> Vec<u32> {
        let program = itself::path();
        let is_program = |pid: &u32| fs::read_link(format!("/proc/{pid}/exe")).is_ok_and(|path| path == program);
        self.processes(node).into_iter().filter(is_program).collect()
    }

    /// For messages: the queue, the nodes and the ends of all logs.
    pub(crate) fn describe(&self) -> String {
        let mut text = self.says("squeue", &[]) + &self.says("sinfo", &["-N", "-o", "%N %T %E"]);
        for entry in fs::read_dir(self.folder.join("log")).unwrap().filter_map(Result::ok) {
            let log = fs::read_to_string(entry.path()).unwrap_or_default();
            let lines: Vec<&str> = log.lines().collect();
            let last = lines[lines.len().saturating_sub(15)..].join("\n");
            text += &format!("\n== {}\n{last}\n", entry.path().display());
        }
        text
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        let nodes: Vec<String> = (1..=self.nodes.len()).map(|number| format!("n{number}")).collect();
        for node in &nodes {
            let processes = self.processes(node);
            for pid in processes.iter().filter_map(|pid| parent_step(*pid)).chain(processes.iter().copied()) {
                signal(pid, "KILL");
            }
        }
        for daemon in self.nodes.iter_mut().flatten().chain([&mut self.controller, &mut self.munged]) {
            // The daemon may have ended of itself.
            let _ = daemon.kill();
            let _ = daemon.wait();
        }
    }
}

pub(crate) fn signal(pid: u32, name: &str) {
    // The process may be gone already.
    let _ = Command::new("kill").args([&format!("-{name}"), &pid.to_string()]).stderr(Stdio::null()).status();
}

/// Slurm's process that watches a task, if it is the parent.
fn parent_step(pid: u32) -> Option<u32> {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let parent: u32 = status.lines().find_map(|line| line.strip_prefix("PPid:"))?.trim().parse().ok()?;
    let name = fs::read_to_string(format!("/proc/{parent}/comm")).ok()?;
    name.starts_with("slurmstepd").then_some(parent)
}

fn number(node: &str) -> usize {
    node.trim_start_matches('n').parse().unwrap()
}

fn text(path: &Path) -> String {
    path.to_str().unwrap().into()
}

/// Starts a daemon in the foreground, its messages in a log.
fn start(folder: &Path, log: &str, program: &str, words: &[&str]) -> Child {
    let log = fs::File::create(folder.join(format!("log/{log}.log"))).unwrap();
    let mut command = Command::new(program);
    command.args(words).env("PATH", search_path()).env("SLURM_CONF", folder.join("slurm.conf"));
    command.stdin(Stdio::null()).stdout(log.try_clone().unwrap()).stderr(log).spawn().unwrap()
}

fn munge_words(folder: &Path) -> [String; 6] {
    let option = |name: &str, file: &str| format!("--{name}={}", text(&folder.join(file)));
    [
        "--foreground".into(),
        "--force".into(),
        option("key-file", "munge/key"),
        option("socket", "run/munge.sock"),
        option("pid-file", "run/munged.pid"),
        option("seed-file", "munge/seed"),
    ]
}

/// Loopback alone, no accounts, and lost nodes are noticed after ten seconds.
fn configuration(folder: &Path, count: usize) -> String {
    let name = |option: &str, program: &str| {
        let ended = Command::new(program).arg(option).output().unwrap();
        String::from_utf8(ended.stdout).unwrap().trim().to_owned()
    };
    let (host, user, folder) = (name("-s", "hostname"), name("-un", "id"), text(folder));
    // All are held until all are found, so that they differ.
    let listeners: Vec<TcpListener> = (0..=count).map(|_| TcpListener::bind("127.0.0.1:0").unwrap()).collect();
    let ports: Vec<u16> = listeners.iter().map(|listener| listener.local_addr().unwrap().port()).collect();
    let mut text = format!(
        "ClusterName=local
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
# A task starts again only after its former credential has expired.
AuthInfo=socket={folder}/run/munge.sock,cred_expire=5
CredType=cred/munge
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool/%n
SlurmctldPidFile={folder}/run/slurmctld.pid
SlurmdPidFile={folder}/run/%n.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_min_interval=100000,bf_interval=2,requeue_delay=0
ReturnToService=2
SlurmdTimeout=10
SlurmctldTimeout=10
KillWait=5
MinJobAge=600
SlurmdParameters=config_overrides
PartitionName=local Nodes=ALL Default=YES MaxTime=INFINITE State=UP
",
        port = ports[0]
    );
    for (number, port) in (1..).zip(&ports[1..]) {
        text +=
            &format!("NodeName=n{number} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1 State=UNKNOWN\n");
    }
    text
}
