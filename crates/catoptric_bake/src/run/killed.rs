//! Processes that are killed while they write, that write at the same time, and that find the disk full.
//!
//! The processes are this test program, which a variable of the environment makes a writer.

use super::*;
use crate::merge::merge;
use crate::status::status;
use crate::store::LocalStore;
use crate::testing::{MemoryStore, plan, work};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

const FOLDER: &str = "CATOPTRIC_BAKE_TEST_FOLDER";

/// Little to compute and much to write, so that what is interrupted is mostly a write.
fn planned() -> Plan {
    plan(&[1 << 18; 40])
}

/// A process that bakes into a folder.
fn writer(folder: &Path) -> Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "run::killed::bakes_when_the_environment_names_a_folder"]).env(FOLDER, folder);
    command.stdout(Stdio::null()).spawn().unwrap()
}

#[test]
fn bakes_when_the_environment_names_a_folder() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let (plan, store) = (planned(), LocalStore::open(folder).unwrap());
    run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
}

fn is_as_if_undisturbed(plan: &Plan, store: &dyn Store) -> bool {
    let (calm, folder) = (MemoryStore::default(), tempfile::tempdir().unwrap());
    let [one, other] = ["one", "other"].map(|name| folder.path().join(name));
    run(plan, &calm, &work(plan), &RunOptions::default()).unwrap();
    merge(plan, &calm, &one).unwrap();
    merge(plan, store, &other).unwrap();
    std::fs::read(one).unwrap() == std::fs::read(other).unwrap()
}

#[test]
fn killed_writers_leave_whole_units_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (plan, store) = (planned(), LocalStore::open(folder.path()).unwrap());
    let (mut killed, mut published) = (0, 0);
    // Later and later, until something was killed in the middle of its work.
    for milliseconds in (4..400).step_by(4) {
        let mut child = writer(folder.path());
        std::thread::sleep(Duration::from_millis(milliseconds));
        child.kill().unwrap();
        killed += u64::from(!child.wait().unwrap().success());
        let found = status(&plan, &store, Check::Contents).unwrap();
        assert!(found.bad.is_empty(), "{found:?}");
        published = found.complete;
        if (published > 10 && !found.left_over.is_empty()) || found.is_complete() {
            break;
        }
    }
    assert!(killed > 0 && published > 0, "{killed} were killed, {published} units published");
    assert!(writer(folder.path()).wait().unwrap().success());
    assert!(is_as_if_undisturbed(&plan, &store));
}

#[test]
fn processes_at_once_make_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let (plan, store) = (planned(), LocalStore::open(folder.path()).unwrap());
    let writers = [writer(folder.path()), writer(folder.path())];
    for mut writer in writers {
        assert!(writer.wait().unwrap().success());
    }
    assert!(is_as_if_undisturbed(&plan, &store));
    assert!(status(&plan, &store, Check::Sizes).unwrap().left_over.is_empty());
}

/// For example: `mount -t tmpfs -o size=4m tmpfs small`, then this test with `CATOPTRIC_SMALL_DISK=small`.
#[test]
#[ignore = "needs a file system that is smaller than 10 MiB: CATOPTRIC_SMALL_DISK names a folder of one"]
fn a_disk_that_is_full_leaves_whole_units_alone() {
    let small = tempfile::tempdir_in(std::env::var_os("CATOPTRIC_SMALL_DISK").unwrap()).unwrap();
    let (plan, store) = (planned(), LocalStore::open(small.path()).unwrap());
    let error = run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap_err();
    assert!(matches!(error, BakeError::Full { .. }), "{error}");
    let found = status(&plan, &store, Check::Contents).unwrap();
    assert!(found.complete > 0 && found.bad.is_empty() && found.left_over.is_empty(), "{found:?}");
    // A merge beside the units finds it full as well.
    let few = crate::testing::plan(&[1 << 18; 3]);
    let memory = MemoryStore::default();
    run(&few, &memory, &work(&few), &RunOptions::default()).unwrap();
    let error = merge(&few, &memory, &small.path().join("merged")).unwrap_err();
    assert!(matches!(error, BakeError::Full { .. }), "{error}");
    assert!(status(&plan, &store, Check::Sizes).unwrap().left_over.is_empty());
    // Once there is room it goes on.
    let roomy = tempfile::tempdir().unwrap();
    for entry in store.list().unwrap() {
        std::fs::copy(small.path().join(&entry.name), roomy.path().join(&entry.name)).unwrap();
    }
    let roomy = LocalStore::open(roomy.path()).unwrap();
    assert_eq!(run(&plan, &roomy, &work(&plan), &RunOptions::default()).unwrap().skipped, found.complete);
    assert!(is_as_if_undisturbed(&plan, &roomy));
}
