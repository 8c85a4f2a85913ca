//! Work of projections, counted: a measure of time that is the same on every machine and for every number of threads.
//!
//! A frame's work is limited by counts, not by a clock: the same input gives the same pixels. Searches add their work
//! on their own thread; their caller reads the count before and after, on the same thread.

use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

thread_local! {
    static DONE: Cell<u64> = const { Cell::new(0) };
}

/// Adds work, in units of about 100 ns of one core.
#[inline]
pub fn add(units: u64) {
    DONE.set(DONE.get().wrapping_add(units));
}

/// The work that this thread has done so far.
#[inline]
pub fn done() -> u64 {
    DONE.get()
}

/// The work that this thread has done since it had done `before`.
#[inline]
pub fn since(before: u64) -> u64 {
    done().wrapping_sub(before)
}

/// Work that several threads do together, and its limit.
#[derive(Debug)]
pub struct SharedWork {
    limit: u64,
    done: AtomicU64,
}

/// The share of one thread in the work, since this was made.
pub(crate) struct ShareOfWork<'a> {
    whole: &'a SharedWork,
    before: u64,
}

impl SharedWork {
    /// A limit of work, none of which is done yet.
    pub fn new(limit: u64) -> Self {
        Self { limit, done: AtomicU64::new(0) }
    }

    /// The share of this thread.
    pub(crate) fn share(&self) -> ShareOfWork<'_> {
        ShareOfWork { whole: self, before: done() }
    }

    /// The work of all shares that have ended.
    pub(crate) fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// True if there was more to do than the limit. The same for every number of threads: all of it is done else.
    pub(crate) fn is_too_much(&self) -> bool {
        self.done() > self.limit
    }
}

impl ShareOfWork<'_> {
    /// True if the threads together have done more than the limit.
    pub(crate) fn is_too_much(&mut self) -> bool {
        self.hand_in();
        self.whole.is_too_much()
    }

    fn hand_in(&mut self) {
        self.whole.done.fetch_add(since(self.before), Ordering::Relaxed);
        self.before = done();
    }
}

impl Drop for ShareOfWork<'_> {
    fn drop(&mut self) {
        self.hand_in();
    }
}
