//! `catoptric bake submit`: its scripts, on a scheduler of a few lines that works as Slurm does.

use crate::workplace::{WHAT, Workplace};
use crate::{itself, trial};
use libtest_mimic::Trial;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

const SUBMIT: [&str; 7] = ["bake", "submit", "room.parts", "--engine", "slurm", "--tasks", "5"];

/// Runs tasks at once, one after the other. Tasks of the index in `$CRASHING` crash; a job that waits for another runs
/// when that has ended, which is now.
const SBATCH: &str = r#"#!/bin/bash
echo "sbatch $*" >>"$CALLS"
array=
while [[ $1 == -* ]]; do
    case $1 in --array=*) array=${1#*=} ;; esac
    shift
done
script=$1
shift
[ "$array" ] || array=$(sed -n 's/^#SBATCH --array=//p' "$script")
export SLURM_JOB_ID=$(grep -c . "$CALLS") SLURM_CPUS_ON_NODE=1
if [ "$array" ]; then
    export SLURM_ARRAY_TASK_MIN=0 SLURM_ARRAY_TASK_COUNT=$((${array#0-} + 1))
    for ((task = 0; task < SLURM_ARRAY_TASK_COUNT; task++)); do
        [ "$task" = "$CRASHING" ] || SLURM_ARRAY_TASK_ID=$task bash "$script" "$@" >>"$CALLS.out" 2>>"$CALLS.err"
    done
else
    bash "$script" "$@" >>"$CALLS.out" 2>>"$CALLS.err"
fi
echo "$SLURM_JOB_ID;cluster"
"#;

pub(crate) fn trials() -> Vec<Trial> {
    vec![
        trial(
            "an array makes the units, and a job after it merges",
            an_array_makes_the_units_and_a_job_after_it_merges,
        ),
        trial("what crashed tasks leave is submitted again", what_crashed_tasks_leave_is_submitted_again),
        trial("what crashes again and again is given up", what_crashes_again_and_again_is_given_up),
        trial("scripts are shown before anything is done", scripts_are_shown_before_anything_is_done),
        trial("what keeps jobs from being submitted is named", what_keeps_jobs_from_being_submitted_is_named),
    ]
}

/// A place with a plan, and the scheduler in its folder `programs`.
fn planned() -> Workplace {
    let place = Workplace::new(Vec::new());
    place.ends(0, &[&["bake", "plan"], &WHAT[..], &["-o", "room.parts"]].concat());
    fs::create_dir(place.path("programs")).unwrap();
    fs::write(place.path("programs/sbatch"), SBATCH).unwrap();
    fs::set_permissions(place.path("programs/sbatch"), fs::Permissions::from_mode(0o755)).unwrap();
    place
}

fn text(place: &Workplace, name: &str) -> String {
    String::from_utf8(place.bytes(name)).unwrap()
}

/// The names in a folder, in order.
fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn submit(place: &Workplace, more: &[&str], crashing: &str) -> Output {
    let mut command: Command = place.command(&[&SUBMIT[..], more].concat());
    let path = format!("{}:{}", place.path("programs").display(), std::env::var("PATH").unwrap());
    command.env("PATH", path).env("CALLS", place.path("calls")).env("CRASHING", crashing).output().unwrap()
}

fn an_array_makes_the_units_and_a_job_after_it_merges() {
    let place = planned();
    place.ends(0, &[&["bake"], &WHAT[..], &["-o", "here.bake"]].concat());
    let ended = submit(&place, &[], "");
    let said = String::from_utf8(ended.stdout).unwrap();
    assert!(ended.status.success() && said.contains("36 units in 5 tasks of job 1; job 2 makes"), "{said}");
    assert!(place.bytes("room.bake") == place.bytes("here.bake"));
    assert_eq!(text(&place, "calls").lines().count(), 2);
    assert!(text(&place, "calls").lines().nth(1).unwrap().contains("--dependency=afterany:1"));
    // There is nothing more to do.
    let ended = submit(&place, &[], "");
    assert!(String::from_utf8(ended.stdout).unwrap().contains("all 36 units are done"));
    assert_eq!(text(&place, "calls").lines().count(), 2);
}

fn what_crashed_tasks_leave_is_submitted_again() {
    let place = planned();
    place.ends(0, &[&["bake"], &WHAT[..], &["-o", "here.bake"]].concat());
    // The fourth of five tasks crashes: seven units are missing, and divided among five tasks of which the fourth
    // crashes, too: one is missing; a list of one has no fourth task.
    assert!(submit(&place, &["-o", "merged.bake"], "3").status.success());
    let calls = text(&place, "calls");
    let arrays: Vec<&str> = calls.lines().filter(|line| line.contains("bake.sbatch")).collect();
    assert_eq!(calls.lines().count(), 6, "{calls}");
    assert!(arrays[1].contains("--array=0-4") && arrays[2].contains("--array=0-0"), "{calls}");
    assert!(place.bytes("merged.bake") == place.bytes("here.bake"));
}

fn what_crashes_again_and_again_is_given_up() {
    let place = planned();
    assert!(submit(&place, &[], "0").status.success());
    assert_eq!(text(&place, "calls").lines().filter(|line| line.contains("bake.sbatch")).count(), 3);
    assert!(text(&place, "calls.err").contains("submitted again 2 times"), "{}", text(&place, "calls.err"));
    assert!(!place.path("room.bake").exists());
    // By hand, it is all the same bake.
    place.ends(0, &["bake", "run", "room.parts"]);
    place.ends(0, &["bake", "merge", "room.parts", "-o", "room.bake"]);
}

fn scripts_are_shown_before_anything_is_done() {
    let place = planned();
    let before = files(&place.path(""));
    let listing =
        place.ends(0, &[&SUBMIT[..], &["--dry-run", "--", "--partition=long", "--comment=two words"]].concat());
    let parts = place.path("room.parts");
    for line in [
        format!("# {}/bake.sbatch:", parts.display()),
        "#SBATCH --array=0-4".into(),
        "#SBATCH --requeue".into(),
        "#SBATCH --partition=long \"--comment=two words\"".into(),
        format!("exec {} bake run {} --shard auto", itself::path().display(), parts.display()),
        format!("#SBATCH --error={}/slurm-%A_%a.err", parts.display()),
        format!("# sbatch --dependency=afterany:$job {}/finish.sbatch", parts.display()),
    ] {
        assert!(listing.lines().any(|found| found.starts_with(&line)), "{line}: {listing}");
    }
    assert_eq!(files(&place.path("")), before);
    assert_eq!(files(&parts), ["plan.json"]);
    place.ends(2, &[&SUBMIT[..], &["--dry-run", "--", "--array=0-3"]].concat());
    place.ends(2, &["bake", "submit", "room.parts", "--engine", "cron"]);
    place.ends(2, &["bake", "submit", "room.parts"]);
}

fn what_keeps_jobs_from_being_submitted_is_named() {
    let place = planned();
    let fails = |path: &Path| {
        let ended = place.command(&SUBMIT).env("PATH", path).env("CALLS", place.path("calls")).output().unwrap();
        let message = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(1), "{message}");
        message
    };
    let message = fails(&place.path("nowhere"));
    assert!(message.contains("sbatch: there is no such program here") && message.contains("--dry-run"), "{message}");
    fs::write(place.path("programs/sbatch"), "#!/bin/sh\necho 'error: Invalid job array specification' >&2\nexit 1\n")
        .unwrap();
    let message = fails(&place.path("programs"));
    assert!(message.contains("Invalid job array") && message.contains("MaxArraySize"), "{message}");
    // The array is submitted, the job after it is not.
    fs::write(
        place.path("programs/sbatch"),
        "#!/bin/sh\ncase $* in *bake.sbatch) echo 7 ;; *) echo full >&2; exit 1 ;; esac\n",
    )
    .unwrap();
    let message = fails(&place.path("programs"));
    assert!(message.contains("full") && message.contains("scancel 7"), "{message}");
    let message = place.ends(1, &["bake", "submit", "nowhere", "--engine", "slurm"]);
    assert!(message.contains("nowhere"), "{message}");
}
