//! Work of projections, counted: a measure of time that is the same on every machine and for every number of threads.
//!
//! A frame's work is limited by counts, not by a clock: the same input gives the same pixels. Searches add what they do
//! where they do it; who gave them something to do reads the count before and after, on the same thread.

use std::cell::Cell;

thread_local! {
    static DONE: Cell<u64> = const { Cell::new(0) };
}

/// Adds work, in units of about 100 ns of one core.
#[inline]
pub(crate) fn add(units: u64) {
    DONE.set(DONE.get().wrapping_add(units));
}

/// The work that this thread has done so far.
#[inline]
pub(crate) fn done() -> u64 {
    DONE.get()
}

/// The work that this thread has done since it had done `before`.
#[inline]
pub(crate) fn since(before: u64) -> u64 {
    done().wrapping_sub(before)
}
