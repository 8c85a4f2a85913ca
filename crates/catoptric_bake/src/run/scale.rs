//! The costs of a bake's bookkeeping beside its units, at the size of a cluster: numbers for docs/clusters.md.

use super::*;
use crate::merge::merge;
use crate::status::status;
use crate::store::LocalStore;
use crate::testing::{plan, work};

const UNITS: usize = 10_000;
const TASKS: u64 = 1000;

/// Ten thousand units of 16 kB in a folder.
#[test]
#[ignore = "measures: cargo test --release -p catoptric_bake --lib scale -- --ignored --nocapture"]
fn ten_thousand_units_in_a_thousand_shards() {
    let folder = tempfile::tempdir().unwrap();
    let (plan, store) = (plan(&[16_000; UNITS]), LocalStore::open(folder.path()).unwrap());
    let told = |what: &str, begun: Instant| eprintln!("{what}: {:.3} s", begun.elapsed().as_secs_f64());
    eprintln!("the plan has {} bytes", plan.to_json().unwrap().len());
    plan.publish(&store).unwrap();
    let begun = Instant::now();
    Plan::load(&store).unwrap();
    told("a task reads the plan", begun);
    let begun = Instant::now();
    run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
    told("all units are written", begun);
    let begun = Instant::now();
    let shard = Shard::new(7, TASKS).unwrap();
    run(&plan, &store, &work(&plan), &RunOptions { shard, ..RunOptions::default() }).unwrap();
    told("a task lists all units and reads its ten", begun);
    for check in [Check::Sizes, Check::Contents] {
        let begun = Instant::now();
        assert!(status(&plan, &store, check).unwrap().is_complete());
        told(&format!("status by {check:?}"), begun);
    }
    let begun = Instant::now();
    merge(&plan, &store, &folder.path().join("merged")).unwrap();
    told("all are merged", begun);
}
