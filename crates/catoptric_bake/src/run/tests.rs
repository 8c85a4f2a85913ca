//! Runs that are stopped, raced, damaged and starved of space end in the file of an undisturbed one.

use super::*;
use crate::merge::merge;
use crate::status::status;
use crate::store::LocalStore;
use crate::testing::{FillingStore, MemoryStore, payload, plan, work};
use crate::unit::UnitFault;
use proptest::prelude::*;
use rayon::prelude::*;
use std::sync::Barrier;
use std::sync::atomic::AtomicU64;
use std::time::Duration;

fn sizes(count: u64) -> Vec<u64> {
    (0..count).map(|number| number * 37 % 101).collect()
}

/// The merged file, after a check that all units are there.
fn merged(plan: &Plan, store: &dyn Store) -> Vec<u8> {
    assert!(status(plan, store, Check::Contents).unwrap().is_complete());
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("merged");
    merge(plan, store, &output).unwrap();
    std::fs::read(output).unwrap()
}

/// The file of a run that nothing disturbs.
fn undisturbed(plan: &Plan) -> Vec<u8> {
    let store = MemoryStore::default();
    let report = run(plan, &store, &work(plan), &RunOptions::default()).unwrap();
    assert_eq!(report, RunReport { made: plan.identity.unit_count(), ..RunReport::default() });
    merged(plan, &store)
}

fn on_threads<R: Send>(threads: usize, task: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(task)
}

#[test]
fn what_is_there_is_skipped() {
    let (plan, store) = (plan(&sizes(10)), MemoryStore::default());
    let work = work(&plan);
    let shard = RunOptions { shard: Shard::new(1, 3).unwrap(), ..RunOptions::default() };
    assert_eq!(run(&plan, &store, &work, &shard).unwrap(), RunReport { made: 3, ..RunReport::default() });
    let rest = run(&plan, &store, &work, &RunOptions::default()).unwrap();
    assert_eq!(rest, RunReport { made: 7, skipped: 3, ..RunReport::default() });
    assert_eq!(merged(&plan, &store), undisturbed(&plan));
    // More shards than units: some have nothing to do.
    let empty = RunOptions { shard: Shard::new(12, 20).unwrap(), ..RunOptions::default() };
    assert_eq!(run(&plan, &store, &work, &empty).unwrap(), RunReport::default());
}

/// A batch, which is made at once, is one shard's, and made again where a part of it is missing; every unit is reported
/// once.
#[test]
fn batches_are_made_whole_by_one_shard() {
    let mut plan = plan(&sizes(11));
    // 0 1 | 2 | 3 4 5 6 | 7 | 8 9 10
    for number in [1, 4, 5, 6, 9, 10] {
        plan.identity.units[number].with_previous = true;
    }
    assert_eq!(plan.identity.batches(), [0..2, 2..3, 3..7, 7..8, 8..11]);
    let asked = Mutex::new(Vec::new());
    let work = Counted { plan: &plan, asked: &asked };
    let store = MemoryStore::default();
    let on = |index, count| RunOptions { shard: Shard::new(index, count).unwrap(), ..RunOptions::default() };
    assert_eq!(run(&plan, &store, &work, &on(0, 2)).unwrap(), RunReport { made: 9, ..RunReport::default() });
    assert_eq!(run(&plan, &store, &work, &on(1, 2)).unwrap(), RunReport { made: 2, ..RunReport::default() });
    let mut batches = std::mem::take(&mut *asked.lock().unwrap());
    batches.sort_by_key(|batch| batch.start);
    assert_eq!(batches, plan.identity.batches());
    let whole = merged(&plan, &store);
    store.remove(&unit::file_name(4, 11)).unwrap();
    store.files.lock().unwrap().get_mut(&unit::file_name(6, 11)).unwrap()[66] ^= 1;
    let reported = Mutex::new(Vec::new());
    let on_unit = |done: &UnitDone<'_>| reported.lock().unwrap().push((done.number, done.outcome));
    let report = run(&plan, &store, &work, &RunOptions { on_unit: &on_unit, ..RunOptions::default() }).unwrap();
    assert_eq!(report, RunReport { made: 1, replaced: 1, skipped: 9, ..RunReport::default() });
    assert_eq!(asked.into_inner().unwrap(), plan.identity.batches()[2..3]);
    let mut reported = reported.into_inner().unwrap();
    reported.sort_by_key(|(number, _)| *number);
    let outcome = |number| match number {
        4 => Outcome::Made,
        6 => Outcome::Replaced,
        _ => Outcome::Skipped,
    };
    assert_eq!(reported, (0..11).map(|number| (number, outcome(number))).collect::<Vec<_>>());
    assert!(merged(&plan, &store) == whole);

    struct Short;
    impl Work for Short {
        fn batch(&self, _: Range<u64>) -> Result<Vec<Payload>, String> {
            Ok(Vec::new())
        }
    }
    let message = run(&plan, &MemoryStore::default(), &Short, &RunOptions::default()).unwrap_err().to_string();
    assert!(message.contains("0 units were made where the batch has"), "{message}");
    plan.identity.units[0].with_previous = true;
    assert!(plan.to_json().unwrap_err().to_string().contains("units[0].with_previous"));
}

/// Makes units, and remembers the batches.
struct Counted<'a> {
    plan: &'a Plan,
    asked: &'a Mutex<Vec<Range<u64>>>,
}

impl Work for Counted<'_> {
    fn batch(&self, numbers: Range<u64>) -> Result<Vec<Payload>, String> {
        self.asked.lock().unwrap().push(numbers.clone());
        Ok(numbers.map(|number| Payload { bytes: payload(self.plan, number), note: None }).collect())
    }
}

/// Units that one shard has left are spread over all shards of a list.
#[test]
fn listed_units_are_divided_into_shards() {
    let (plan, store) = (plan(&sizes(12)), MemoryStore::default());
    let (work, left) = (work(&plan), [1, 4, 7, 10]);
    for index in 0..2 {
        let (shard, before) = (Shard::new(index, 2).unwrap(), store.list().unwrap().len());
        let options = RunOptions { shard, units: Some(&left), ..RunOptions::default() };
        assert_eq!(run(&plan, &store, &work, &options).unwrap(), RunReport { made: 2, ..RunReport::default() });
        assert_eq!(store.list().unwrap().len(), before + 2);
    }
    assert_eq!(status(&plan, &store, Check::Contents).unwrap().missing(), [0, 2, 3, 5, 6, 8, 9, 11]);
    let beyond = RunOptions { units: Some(&[3, 12]), ..RunOptions::default() };
    let message = run(&plan, &store, &work, &beyond).unwrap_err().to_string();
    assert!(message.contains("units: there is no unit 12; the plan has 0 to 11"), "{message}");
}

#[test]
fn progress_reports_every_unit_once() {
    let (plan, store) = (plan(&sizes(20)), MemoryStore::default());
    let reported = Mutex::new(Vec::new());
    let on_unit = |done: &UnitDone<'_>| {
        assert_eq!((done.name, done.total), (plan.identity.units[done.number as usize].name.as_str(), 20));
        assert_eq!((done.bytes, done.outcome), (plan.identity.units[done.number as usize].bytes, Outcome::Made));
        reported.lock().unwrap().push((done.number, done.done));
    };
    let options = RunOptions { on_unit: &on_unit, ..RunOptions::default() };
    on_threads(3, || run(&plan, &store, &work(&plan), &options)).unwrap();
    let (mut numbers, mut counts): (Vec<u64>, Vec<u64>) = reported.into_inner().unwrap().into_iter().unzip();
    numbers.sort_unstable();
    counts.sort_unstable();
    assert_eq!((numbers, counts), ((0..20).collect(), (1..=20).collect()));
}

/// Units that use the pool themselves do not begin other units while they wait.
#[test]
fn no_thread_holds_two_units() {
    let (plan, store) = (plan(&[8; 24]), MemoryStore::default());
    let (at_work, most) = (AtomicU64::new(0), AtomicU64::new(0));
    let nested = |number: u64| -> Result<Vec<u8>, String> {
        most.fetch_max(at_work.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
        let sum: usize = (0..200).into_par_iter().with_max_len(1).map(|k: usize| k ^ number as usize).sum();
        assert!(sum > 0);
        at_work.fetch_sub(1, Ordering::SeqCst);
        Ok(payload(&plan, number))
    };
    on_threads(3, || run(&plan, &store, &nested, &RunOptions::default())).unwrap();
    assert!(most.into_inner() <= 3);
}

#[test]
fn stopped_runs_go_on_to_the_same_file() {
    let plan = plan(&sizes(23));
    let expected = undisturbed(&plan);
    let work = work(&plan);
    for (threads, after, shards) in [(1, 0, 1), (1, 5, 2), (2, 3, 1), (3, 7, 5), (2, 22, 40)] {
        let store = MemoryStore::default();
        let stop = AtomicBool::new(after == 0);
        // Threads report in another order than they count: a late report of fewer units must not clear the flag.
        let on_unit = |done: &UnitDone<'_>| {
            stop.fetch_or(done.done >= after, Ordering::Relaxed);
        };
        let options = RunOptions { stop: &stop, on_unit: &on_unit, ..RunOptions::default() };
        let report = on_threads(threads, || run(&plan, &store, &work, &options)).unwrap();
        assert!(report.made >= after && report.made < after + threads as u64, "{report:?}");
        assert_eq!((report.made + report.left, report.stopped.is_some()), (23, report.left > 0), "{report:?}");
        let missing = status(&plan, &store, Check::Sizes).unwrap().missing;
        assert_eq!(missing, report.left);
        for index in 0..shards {
            let options = RunOptions { shard: Shard::new(index, shards).unwrap(), ..RunOptions::default() };
            on_threads(4 - threads, || run(&plan, &store, &work, &options)).unwrap();
        }
        assert!(merged(&plan, &store) == expected, "{threads} threads, stopped after {after}, {shards} shards");
    }
}

#[test]
fn time_stops_a_run() {
    let (plan, store) = (plan(&sizes(6)), MemoryStore::default());
    let options = RunOptions { until: Some(Instant::now()), ..RunOptions::default() };
    let report = run(&plan, &store, &work(&plan), &options).unwrap();
    assert_eq!(report, RunReport { left: 6, stopped: Some(Reason::Time), ..RunReport::default() });
    let slow = |number: u64| -> Result<Vec<u8>, String> {
        std::thread::sleep(Duration::from_millis(40));
        Ok(payload(&plan, number))
    };
    let options = RunOptions { until: Some(Instant::now() + Duration::from_millis(20)), ..RunOptions::default() };
    let report = on_threads(1, || run(&plan, &store, &slow, &options)).unwrap();
    assert!(report.left > 0 && report.stopped == Some(Reason::Time), "{report:?}");
    run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
    assert_eq!(merged(&plan, &store), undisturbed(&plan));
}

#[test]
fn two_writers_at_once_make_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let (plan, store) = (plan(&sizes(12)), LocalStore::open(folder.path()).unwrap());
    // Both have listed before either publishes, and publish each unit at the same time.
    let together = Barrier::new(2);
    let work = |number: u64| -> Result<Vec<u8>, String> {
        together.wait();
        Ok(payload(&plan, number))
    };
    let writer = || on_threads(1, || run(&plan, &store, &work, &RunOptions::default()).unwrap());
    let (one, other) = std::thread::scope(|scope| {
        let (one, other) = (scope.spawn(writer), scope.spawn(writer));
        (one.join().unwrap(), other.join().unwrap())
    });
    assert_eq!((one.made + other.made, one.beaten + other.beaten), (12, 12));
    assert_eq!(one.made + one.beaten, 12);
    assert_eq!(merged(&plan, &store), undisturbed(&plan));
    assert!(status(&plan, &store, Check::Sizes).unwrap().left_over.is_empty());
}

#[test]
fn writers_that_differ_are_reported() {
    let (plan, store) = (plan(&[8; 4]), MemoryStore::default());
    // Another writer publishes something else while this one is at work.
    let work = |number: u64| -> Result<Vec<u8>, String> {
        if number == 2 {
            let name = unit::file_name(2, 4);
            store.create(&name, &unit::encode(plan.hash(), 2, &[9; 8])).unwrap();
        }
        Ok(payload(&plan, number))
    };
    let error = run(&plan, &store, &work, &RunOptions::default()).unwrap_err();
    assert!(matches!(error, BakeError::Differs { number: 2, .. }), "{error}");
    let message = error.to_string();
    assert!(message.contains("memory/unit-000002.bin: unit 2 (row 2)"), "{message}");
    assert!(message.contains("not deterministic"), "{message}");
}

#[test]
fn damaged_units_are_made_again() {
    let plan = plan(&[40; 8]);
    let expected = undisturbed(&plan);
    let store = MemoryStore::default();
    run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
    let damage = |number: u64, change: &dyn Fn(&mut Vec<u8>)| {
        change(store.files.lock().unwrap().get_mut(&unit::file_name(number, 8)).unwrap());
    };
    damage(0, &Vec::clear);
    damage(1, &|bytes| bytes.truncate(77));
    damage(2, &|bytes| bytes.push(0));
    damage(3, &|bytes| bytes[90] ^= 4);
    damage(4, &|bytes| bytes[3] ^= 1);
    damage(5, &|bytes| bytes.fill(0));
    // By sizes alone the last three are not noticed.
    let sizes = RunOptions { check: Check::Sizes, ..RunOptions::default() };
    let report = run(&plan, &store, &work(&plan), &sizes).unwrap();
    assert_eq!(report, RunReport { replaced: 3, skipped: 5, ..RunReport::default() });
    let report = run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
    assert_eq!(report, RunReport { replaced: 3, skipped: 5, ..RunReport::default() });
    assert!(merged(&plan, &store) == expected);
}

#[test]
fn whole_files_of_others_are_left_alone() {
    let (planned, store) = (plan(&[8; 3]), MemoryStore::default());
    let other = plan(&[8; 4]);
    let foreign = unit::encode(other.hash(), 1, &payload(&planned, 1));
    store.create("unit-000001.bin", &foreign).unwrap();
    let error = run(&planned, &store, &work(&planned), &RunOptions::default()).unwrap_err();
    let expected = UnitFault::OtherPlan { found: other.hash() };
    assert!(matches!(error, BakeError::Misplaced { fault, .. } if fault == expected), "{error}");
    assert_eq!(store.get("unit-000001.bin").unwrap().unwrap(), foreign);
    // A file of another size is noticed only once it would be replaced.
    store.remove("unit-000001.bin").unwrap();
    let longer = unit::encode(planned.hash(), 1, &[1; 9]);
    store.create("unit-000001.bin", &longer).unwrap();
    let error = run(&planned, &store, &work(&planned), &RunOptions::default()).unwrap_err();
    assert!(error.to_string().contains("holds 9 bytes where the plan says 8"), "{error}");
    assert_eq!(store.get("unit-000001.bin").unwrap().unwrap(), longer);
}

#[test]
fn a_full_disk_leaves_whole_units_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (plan, store) = (plan(&sizes(9)), LocalStore::open(folder.path()).unwrap());
    for writes in [0, 1, 4] {
        let filling = FillingStore { store: &store, writes: AtomicU64::new(writes) };
        let error = run(&plan, &filling, &work(&plan), &RunOptions::default()).unwrap_err();
        assert!(matches!(error, BakeError::Full { .. }), "{error}");
        let status = status(&plan, &store, Check::Contents).unwrap();
        assert!(status.bad.is_empty() && status.left_over.is_empty(), "{status:?}");
    }
    assert_eq!(status(&plan, &store, Check::Sizes).unwrap().complete, 5);
    let report = run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
    assert_eq!(report, RunReport { made: 4, skipped: 5, ..RunReport::default() });
    assert_eq!(merged(&plan, &store), undisturbed(&plan));
}

#[test]
fn what_a_killed_writer_leaves_is_no_unit() {
    let folder = tempfile::tempdir().unwrap();
    let (plan, store) = (plan(&sizes(3)), LocalStore::open(folder.path()).unwrap());
    let path = folder.path().join(".catoptric-123456.tmp");
    std::fs::write(&path, &unit::encode(plan.hash(), 1, &payload(&plan, 1))[..50]).unwrap();
    let before = status(&plan, &store, Check::Contents).unwrap();
    assert_eq!((before.missing, before.bad.len(), before.left_over.len()), (3, 0, 1));
    run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
    assert_eq!(merged(&plan, &store), undisturbed(&plan));
    assert!(path.exists());
}

#[test]
fn failures_stop_the_run_and_name_the_unit() {
    let plan = plan(&[8; 50]);
    let store = MemoryStore::default();
    let failing = |number: u64| if number == 3 { Err("no light".into()) } else { Ok(payload(&plan, number)) };
    let error = on_threads(1, || run(&plan, &store, &failing, &RunOptions::default())).unwrap_err();
    assert_eq!(error.to_string(), "unit 3 (row 3): no light");
    assert_eq!(store.list().unwrap().len(), 3);
    let larger = |number: u64| -> Result<Vec<u8>, String> { Ok(vec![0; if number == 5 { 9 } else { 8 }]) };
    let error = run(&plan, &MemoryStore::default(), &larger, &RunOptions::default()).unwrap_err();
    assert!(matches!(error, BakeError::Size { number: 5, planned: 8, found: 9, .. }), "{error}");
}

/// Says that a panic has got as far as here: its message, with which it begins, may take longer than all units.
struct Unwinding<'a>(&'a AtomicBool);

impl Drop for Unwinding<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[test]
fn a_panic_stops_the_run_and_is_passed_on() {
    let (plan, store) = (plan(&[8; 500]), MemoryStore::default());
    let unwinds = AtomicBool::new(false);
    let panicking = |number: u64| -> Result<Vec<u8>, String> {
        if number == 3 {
            let _told = Unwinding(&unwinds);
            panic!("a bug");
        }
        while number > 3 && !unwinds.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(1));
        Ok(payload(&plan, number))
    };
    let task = || on_threads(2, || run(&plan, &store, &panicking, &RunOptions::default()));
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(task)).is_err());
    assert!(store.list().unwrap().len() < 400);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Any sequence of runs of any shards, stopped anywhere, with units damaged in between.
    #[test]
    fn any_history_ends_in_the_same_file(
        history in prop::collection::vec((0u64..6, 1u64..6, 0u64..9, 1usize..3, 0u64..17, 0usize..120), 0..6),
    ) {
        let plan = plan(&sizes(17));
        let store = MemoryStore::default();
        for (index, count, after, threads, bad, at) in history {
            let stop = AtomicBool::new(false);
            let on_unit = |done: &UnitDone<'_>| {
                stop.fetch_or(done.done > after, Ordering::Relaxed);
            };
            let shard = Shard::new(index % count, count).unwrap();
            let options = RunOptions { shard, stop: &stop, on_unit: &on_unit, ..RunOptions::default() };
            on_threads(threads, || run(&plan, &store, &work(&plan), &options)).unwrap();
            if let Some(bytes) = store.files.lock().unwrap().get_mut(&unit::file_name(bad, 17)) {
                if at < bytes.len() { bytes[at] ^= 16 } else { bytes.truncate(at / 2) }
            }
        }
        run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
        prop_assert!(merged(&plan, &store) == undisturbed(&plan));
    }
}

/// Units of which only the largest size is known before they are made.
#[test]
fn units_may_be_smaller_than_planned() {
    let mut plan = plan(&[40; 6]);
    plan.identity.units[2..].iter_mut().for_each(|unit| unit.at_most = true);
    let size = |number: u64| [40, 40, 40, 0, 17, 39][number as usize];
    let made = |number: u64| -> Result<Vec<u8>, String> { Ok(payload(&plan, number)[..size(number)].to_vec()) };
    let whole = |store: &MemoryStore| run(&plan, store, &made, &RunOptions::default()).unwrap();
    let store = MemoryStore::default();
    whole(&store);
    let expected = merged(&plan, &store);
    let baked = crate::container::BakedFile::from_bytes("a.bake", &expected).unwrap();
    assert_eq!(baked.identity(), &plan.identity);
    for number in 0..6 {
        assert_eq!(baked.unit(number), &payload(&plan, number)[..size(number)]);
    }

    // Files that were cut off are still noticed, if not by their size alone.
    store.files.lock().unwrap().get_mut(&unit::file_name(5, 6)).unwrap().truncate(100);
    store.files.lock().unwrap().get_mut(&unit::file_name(3, 6)).unwrap().pop();
    let bad = |check: Check| status(&plan, &store, check).unwrap().bad.iter().map(|bad| bad.number).collect::<Vec<_>>();
    assert_eq!((bad(Check::Sizes), bad(Check::Contents)), (vec![3], vec![3, 5]));
    assert_eq!(whole(&store), RunReport { replaced: 2, skipped: 4, ..RunReport::default() });
    assert!(merged(&plan, &store) == expected);

    // Larger ones are refused, and others of the size that was said.
    for (number, bytes) in [(4, 41), (1, 39)] {
        let wrong = |other: u64| if other == number { Ok(vec![1; bytes]) } else { made(other) };
        let error = run(&plan, &MemoryStore::default(), &wrong, &RunOptions::default()).unwrap_err();
        assert!(matches!(error, BakeError::Size { planned: 40, .. }), "{error}");
    }
    // Merged files with such a unit are refused, too.
    let mut exact = plan.clone();
    exact.identity.units[4].at_most = false;
    let layout =
        crate::container::Layout::of(&exact.identity, &(0..6).map(|unit| size(unit) as u64).collect::<Vec<_>>());
    let layout = layout.unwrap();
    let mut bytes = layout.head(&[[0; 32]; 6]);
    bytes.resize(layout.file_bytes as usize, 0);
    let footer = bytes.len() - 32;
    let hash = blake3::hash(&bytes[..layout.payloads as usize]);
    bytes[footer..].copy_from_slice(hash.as_bytes());
    let error = crate::container::BakedFile::from_bytes("a.bake", &bytes).unwrap_err();
    assert!(error.to_string().contains("its sizes do not fit"), "{error}");
}
