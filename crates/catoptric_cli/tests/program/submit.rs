//! `catoptric bake submit`: its scripts, on a scheduler of a few lines that works as Slurm does.
#![cfg(unix)]

use crate::workplace::Workplace;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

/// 36 units.
const WHAT: [&str; 9] =
    ["scene.toml", "--method", "light_field", "--set", "st=6", "--set", "uv=16", "--set", "capture_samples=1"];
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

/// A place with a plan, and the scheduler in its folder `programs`.
fn planned() -> Workplace {
    let place = Workplace::new();
    place.ok(&[&["bake", "plan"], &WHAT[..], &["-o", "room.parts"]].concat());
    fs::create_dir(place.path("programs")).unwrap();
    place.write("programs/sbatch", SBATCH);
    fs::set_permissions(place.path("programs/sbatch"), fs::Permissions::from_mode(0o755)).unwrap();
    place
}

fn submit(place: &Workplace, more: &[&str], crashing: &str) -> Output {
    let mut command: Command = place.command(&[&SUBMIT[..], more].concat());
    let path = format!("{}:{}", place.path("programs").display(), std::env::var("PATH").unwrap());
    command.env("PATH", path).env("CALLS", place.path("calls")).env("CRASHING", crashing).output().unwrap()
}

#[test]
fn an_array_makes_the_units_and_a_job_after_it_merges() {
    let place = planned();
    place.ok(&[&["bake"], &WHAT[..], &["-o", "here.bake"]].concat());
    let ended = submit(&place, &[], "");
    let said = String::from_utf8(ended.stdout).unwrap();
    assert!(ended.status.success() && said.contains("36 units in 5 tasks of job 1; job 2 makes"), "{said}");
    assert!(place.bytes("room.bake") == place.bytes("here.bake"));
    assert_eq!(place.text("calls").lines().count(), 2);
    assert!(place.text("calls").lines().nth(1).unwrap().contains("--dependency=afterany:1"));
    // There is nothing more to do.
    let ended = submit(&place, &[], "");
    assert!(String::from_utf8(ended.stdout).unwrap().contains("all 36 units are done"));
    assert_eq!(place.text("calls").lines().count(), 2);
}

#[test]
fn what_crashed_tasks_leave_is_submitted_again() {
    let place = planned();
    place.ok(&[&["bake"], &WHAT[..], &["-o", "here.bake"]].concat());
    // The fourth of five tasks crashes: seven units are missing, and divided among five tasks of which the fourth
    // crashes, too: one is missing; a list of one has no fourth task.
    assert!(submit(&place, &["-o", "merged.bake"], "3").status.success());
    let calls = place.text("calls");
    let arrays: Vec<&str> = calls.lines().filter(|line| line.contains("bake.sbatch")).collect();
    assert_eq!(calls.lines().count(), 6, "{calls}");
    assert!(arrays[1].contains("--array=0-4") && arrays[2].contains("--array=0-0"), "{calls}");
    assert!(place.bytes("merged.bake") == place.bytes("here.bake"));
}

#[test]
fn what_crashes_again_and_again_is_given_up() {
    let place = planned();
    assert!(submit(&place, &[], "0").status.success());
    assert_eq!(place.text("calls").lines().filter(|line| line.contains("bake.sbatch")).count(), 3);
    assert!(place.text("calls.err").contains("submitted again 2 times"), "{}", place.text("calls.err"));
    assert!(!place.path("room.bake").exists());
    // By hand, it is all the same bake.
    place.ok(&["bake", "run", "room.parts"]);
    place.ok(&["bake", "merge", "room.parts", "-o", "room.bake"]);
}

#[test]
fn scripts_are_shown_before_anything_is_done() {
    let place = planned();
    let files = place.files();
    let text = place.ok(&[&SUBMIT[..], &["--dry-run", "--", "--partition=long", "--comment=two words"]].concat());
    let parts = place.path("room.parts");
    for line in [
        format!("# {}/bake.sbatch:", parts.display()),
        "#SBATCH --array=0-4".into(),
        "#SBATCH --requeue".into(),
        "#SBATCH --partition=long \"--comment=two words\"".into(),
        format!("exec {} bake run {} --shard auto", env!("CARGO_BIN_EXE_catoptric"), parts.display()),
        format!("#SBATCH --error={}/slurm-%A_%a.err", parts.display()),
        format!("# sbatch --dependency=afterany:$job {}/finish.sbatch", parts.display()),
    ] {
        assert!(text.lines().any(|found| found.starts_with(&line)), "{line}: {text}");
    }
    assert_eq!(place.files(), files);
    assert_eq!(crate::workplace::files(&parts), ["plan.json"]);
    place.ends(2, &[&SUBMIT[..], &["--dry-run", "--", "--array=0-3"]].concat());
    place.ends(2, &["bake", "submit", "room.parts", "--engine", "cron"]);
    place.ends(2, &["bake", "submit", "room.parts"]);
}

#[test]
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
    place.write("programs/sbatch", "#!/bin/sh\necho 'error: Invalid job array specification' >&2\nexit 1\n");
    let message = fails(&place.path("programs"));
    assert!(message.contains("Invalid job array") && message.contains("MaxArraySize"), "{message}");
    // The array is submitted, the job after it is not.
    place.write("programs/sbatch", "#!/bin/sh\ncase $* in *bake.sbatch) echo 7 ;; *) echo full >&2; exit 1 ;; esac\n");
    let message = fails(&place.path("programs"));
    assert!(message.contains("full") && message.contains("scancel 7"), "{message}");
    let message = place.fails(1, &["bake", "submit", "nowhere", "--engine", "slurm"]);
    assert!(message.contains("nowhere"), "{message}");
}

#[test]
fn runs_of_listed_units_make_these_alone() {
    let place = planned();
    place.write("list", "3\n\n 17\n35\n");
    place.ok(&["bake", "run", "room.parts", "--units", "list", "--shard", "1/2", "--quiet"]);
    assert_eq!(crate::workplace::files(&place.path("room.parts")), ["plan.json", "unit-000017.bin"]);
    place.ok(&["bake", "run", "room.parts", "--units", "list", "--quiet"]);
    assert_eq!(place.ends(3, &["bake", "status", "room.parts", "--missing"]).lines().count(), 33);
    for (list, named) in [("3\nx\n", "list: line 2: `x` is no unit's number"), ("36\n", "there is no unit 36")] {
        place.write("list", list);
        let message = place.fails(1, &["bake", "run", "room.parts", "--units", "list"]);
        assert!(message.contains(named), "{message}");
    }
}
