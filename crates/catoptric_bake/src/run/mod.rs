//! Makes the missing units of a plan on all cores, until all are done or a stop is requested.

#[cfg(test)]
mod killed;
#[cfg(test)]
mod scale;
#[cfg(test)]
mod tests;

use crate::error::BakeError;
use crate::plan::{PLAN_NAME, Plan};
use crate::shard::Shard;
use crate::status::{Check, Found, Listing};
use crate::store::{Created, Store};
use crate::unit;
use serde::Serialize;
use std::collections::HashSet;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// The number of attempts to publish a unit that others remove or damage in the meantime.
const ATTEMPTS: usize = 3;

/// The work of a bake. Also any function from a unit's number to its payload.
pub trait Work: Sync {
    /// The payloads of a batch's units, by their numbers: of sizes that the plan allows, and the same bits on every
    /// machine, thread and try.
    ///
    /// # Errors
    /// The fault, in words.
    fn batch(&self, numbers: Range<u64>) -> Result<Vec<Payload>, String>;
}

impl<F: Fn(u64) -> Result<Vec<u8>, String> + Sync> Work for F {
    fn batch(&self, numbers: Range<u64>) -> Result<Vec<Payload>, String> {
        numbers.map(|number| Ok(Payload { bytes: self(number)?, note: None })).collect()
    }
}

/// The contents of a unit.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Payload {
    /// As many as planned.
    pub bytes: Vec<u8>,
    /// A note for people on how it was made; it is reported once and kept nowhere.
    pub note: Option<String>,
}

/// The options of a run.
#[derive(Clone, Copy)]
pub struct RunOptions<'a> {
    /// The shard whose units are made.
    pub shard: Shard,
    /// The units that are divided into shards; all of the plan if `None`. Every n-th of the list, so that what is left
    /// of some shards of an earlier run is spread over all of this one.
    pub units: Option<&'a [u64]>,
    /// The check of published units. Contents are the default: reading a unit takes far less than making it,
    /// and what is found now need not be made again after a merge that refused. Sizes are for stores that are slow or
    /// costly to read; the merge finds the rest.
    pub check: Check,
    /// Stops the run before the next unit once it is set; units at work are finished.
    pub stop: &'a AtomicBool,
    /// Stops the run before the next unit from this time on.
    pub until: Option<Instant>,
    /// Called for every unit that is done or was done already, from any thread.
    pub on_unit: &'a (dyn Fn(&UnitDone<'_>) + Sync),
}

impl Default for RunOptions<'_> {
    fn default() -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Self { shard: Shard::ALL, units: None, check: Check::Contents, stop: &NEVER, until: None, on_unit: &|_| {} }
    }
}

impl RunOptions<'_> {
    /// The batches that a run with these options sees to: every n-th of those that have a unit of the list, so that
    /// what is left of one shard is spread over all.
    pub fn batches(&self, plan: &Plan) -> Vec<Range<u64>> {
        let mut batches = plan.identity.batches();
        if let Some(units) = self.units {
            let listed: HashSet<u64> = units.iter().copied().collect();
            batches.retain(|batch| batch.clone().any(|number| listed.contains(&number)));
        }
        self.shard.of(&batches).cloned().collect()
    }
}

/// The outcome of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The unit was missing and is published.
    Made,
    /// The unit was there.
    Skipped,
    /// The unit was there, damaged, and a good one is published in its place.
    Replaced,
    /// The unit was made, but another writer had published the same bits first.
    Beaten,
}

/// A unit that is done.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UnitDone<'a> {
    /// The unit's number in the plan.
    pub number: u64,
    /// The unit's name in the plan.
    pub name: &'a str,
    /// The bytes of its payload as planned, or the most that it may have.
    pub bytes: u64,
    /// The way in which the unit was done.
    pub outcome: Outcome,
    /// The maker's note on how it was made; `None` if it was not made now.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<&'a str>,
    /// The time that took, of a batch with that of making all its units in the first.
    pub seconds: f64,
    /// The number of units of the shard that are done; threads may report in another order than they count.
    pub done: u64,
    /// The number of units in the shard.
    pub total: u64,
}

/// Why a run stopped before its shard was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// The stop flag was set.
    Asked,
    /// The time was up.
    Time,
}

/// The counts of a run over the units of its shard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RunReport {
    /// Units that were missing and are published.
    pub made: u64,
    /// Units that were there.
    pub skipped: u64,
    /// Units that were damaged and are replaced.
    pub replaced: u64,
    /// Units that were made here while another writer published them first.
    pub beaten: u64,
    /// Units that are left to do.
    pub left: u64,
    /// Why the run stopped, when units are left.
    pub stopped: Option<Reason>,
}

/// Makes the units of a shard that are missing or damaged.
///
/// Each thread of rayon's current pool takes one batch at a time, in the order of their numbers, and holds at most its
/// payloads and one unit's file in memory. Where some units of a batch are missing, all of it is made again. Work may
/// use rayon itself.
///
/// # Errors
/// The first failure, after which no more units are begun: [`BakeError::Work`] and [`BakeError::Size`] of the work;
/// [`BakeError::Differs`] when another writer has published other bits; [`BakeError::Misplaced`] when something whole
/// that does not belong there has a unit's name; [`BakeError::Invalid`] for units that the plan does not have; and
/// those of the store. What was published until then is kept.
pub fn run(plan: &Plan, store: &dyn Store, work: &dyn Work, options: &RunOptions<'_>) -> Result<RunReport, BakeError> {
    let planned = plan.identity.unit_count();
    if let Some(number) = options.units.and_then(|units| units.iter().find(|number| **number >= planned)) {
        let problem = format!("there is no unit {number}; the plan has 0 to {}", planned.saturating_sub(1));
        return Err(BakeError::invalid(store.place(PLAN_NAME), "units", problem));
    }
    let batches = options.batches(plan);
    let total = batches.iter().map(|batch| batch.end - batch.start).sum();
    let run = Run {
        plan,
        store,
        work,
        options,
        listing: Listing::read(plan, store)?,
        batches,
        total,
        next: AtomicUsize::new(0),
        failed: AtomicBool::new(false),
        progress: Mutex::new(RunState { report: RunReport { left: total, ..RunReport::default() }, failure: None }),
    };
    // One loop a thread, not a parallel iterator: a thread that waits for work's own parallel loops could begin another
    // unit of an iterator meanwhile, and memory would not be bounded.
    rayon::broadcast(|_| run.take_units());
    let RunState { mut report, failure } = run.progress.into_inner().unwrap_or_else(PoisonError::into_inner);
    if report.left == 0 {
        report.stopped = None;
    }
    failure.map_or(Ok(report), Err)
}

struct Run<'a> {
    plan: &'a Plan,
    store: &'a dyn Store,
    work: &'a dyn Work,
    options: &'a RunOptions<'a>,
    listing: Listing<'a>,
    /// The batches of the shard, as ranges of numbers of units.
    batches: Vec<Range<u64>>,
    /// Their units.
    total: u64,
    next: AtomicUsize,
    failed: AtomicBool,
    progress: Mutex<RunState>,
}

struct RunState {
    report: RunReport,
    failure: Option<BakeError>,
}

/// Stops the other threads when one panics: else they would work to the end before the panic is passed on.
struct StopOnPanic<'a>(&'a AtomicBool);

impl Drop for StopOnPanic<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.store(true, Ordering::Relaxed);
        }
    }
}

impl Run<'_> {
    fn take_units(&self) {
        let _guard = StopOnPanic(&self.failed);
        while let Some(batch) = self.next() {
            if let Err(error) = self.look_or_make(batch) {
                self.failed.store(true, Ordering::Relaxed);
                self.progress().failure.get_or_insert(error);
            }
        }
    }

    fn progress(&self) -> std::sync::MutexGuard<'_, RunState> {
        // Nothing that could panic is done while it is held.
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next batch, unless it is time to stop.
    fn next(&self) -> Option<Range<u64>> {
        if self.failed.load(Ordering::Relaxed) {
            return None;
        }
        let reason = if self.options.stop.load(Ordering::Relaxed) {
            Some(Reason::Asked)
        } else {
            self.options.until.filter(|&until| Instant::now() >= until).map(|_| Reason::Time)
        };
        if let Some(reason) = reason {
            self.progress().report.stopped.get_or_insert(reason);
            return None;
        }
        self.batches.get(self.next.fetch_add(1, Ordering::Relaxed)).cloned()
    }

    /// Reports a unit, which took the time since `begun`; the next one begins now.
    fn report(&self, number: u64, outcome: Outcome, note: Option<&str>, begun: &mut Instant) {
        let left = {
            let report = &mut self.progress().report;
            *match outcome {
                Outcome::Made => &mut report.made,
                Outcome::Skipped => &mut report.skipped,
                Outcome::Replaced => &mut report.replaced,
                Outcome::Beaten => &mut report.beaten,
            } += 1;
            report.left -= 1;
            report.left
        };
        let planned = &self.plan.identity.units[number as usize];
        (self.options.on_unit)(&UnitDone {
            number,
            name: &planned.name,
            bytes: planned.bytes,
            outcome,
            note,
            seconds: std::mem::replace(begun, Instant::now()).elapsed().as_secs_f64(),
            done: self.total - left,
            total: self.total,
        });
    }

    /// Sees to it that all units of a batch are there, and reports each.
    fn look_or_make(&self, batch: Range<u64>) -> Result<(), BakeError> {
        let mut begun = Instant::now();
        let mut to_make = Vec::new();
        for number in batch.clone() {
            match self.listing.find(number, self.options.check)? {
                Found::Bad(fault) if !fault.is_damage() => {
                    let file = self.store.place(&self.file_name(number));
                    return Err(BakeError::Misplaced { file, fault });
                }
                Found::Missing | Found::Bad(_) => to_make.push(number),
                Found::Good => self.report(number, Outcome::Skipped, None, &mut begun),
            }
        }
        if to_make.is_empty() {
            return Ok(());
        }
        let name = |number: u64| self.plan.identity.units[number as usize].name.clone();
        let problem = |problem| BakeError::Work { number: batch.start, name: name(batch.start), problem };
        let payloads = self.work.batch(batch.clone()).map_err(problem)?;
        let (found, wanted) = (payloads.len() as u64, batch.end - batch.start);
        if found != wanted {
            return Err(problem(format!("{found} units were made where the batch has {wanted}")));
        }
        for (number, Payload { bytes, note }) in batch.zip(payloads) {
            let (planned, found) = (&self.plan.identity.units[number as usize], bytes.len() as u64);
            if !planned.admits(found) {
                return Err(BakeError::Size { number, name: name(number), planned: planned.bytes, found });
            }
            if to_make.binary_search(&number).is_ok() {
                let outcome = self.publish(number, &unit::encode(self.listing.hash, number, &bytes))?;
                self.report(number, outcome, note.as_deref(), &mut begun);
            }
        }
        Ok(())
    }

    /// Publishes a unit. A damaged one in its place is looked at again just before it is removed, and only once the
    /// good one is ready: so it is rare that a good one of another writer is removed.
    fn publish(&self, number: u64, bytes: &[u8]) -> Result<Outcome, BakeError> {
        let name = self.file_name(number);
        let file = || self.store.place(&name);
        let mut replaced = false;
        for _ in 0..ATTEMPTS {
            if self.store.create(&name, bytes)? == Created::New {
                return Ok(if replaced { Outcome::Replaced } else { Outcome::Made });
            }
            let Some(found) = self.store.get(&name)? else { continue };
            if found == bytes {
                // After a damaged one was removed it does not matter whose it is; a store that lost the answer to what
                // was sent finds that again.
                return Ok(if replaced { Outcome::Replaced } else { Outcome::Beaten });
            }
            match self.plan.identity.units[number as usize].decode(&found, self.listing.hash, number) {
                Ok(_) => {
                    let name = self.plan.identity.units[number as usize].name.clone();
                    return Err(BakeError::Differs { file: file(), number, name });
                }
                Err(fault) if fault.is_damage() => {
                    self.store.remove(&name)?;
                    replaced = true;
                }
                Err(fault) => return Err(BakeError::Misplaced { file: file(), fault }),
            }
        }
        Err(BakeError::Contended { file: file() })
    }

    fn file_name(&self, number: u64) -> String {
        unit::file_name(number, self.plan.identity.unit_count())
    }
}
