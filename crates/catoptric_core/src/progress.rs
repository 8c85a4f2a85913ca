//! Progress of long work, and its cancellation.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The caller cancelled the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Receives the progress of work, and may cancel it; called from any thread.
pub trait Progress: Sync {
    /// `done` of `of` steps of a stage are complete; `of` is 0 where the number of steps is unknown.
    ///
    /// # Errors
    /// [`Cancelled`] stops the work at the next opportunity.
    fn at(&self, stage: &str, done: u64, of: u64) -> Result<(), Cancelled>;
}

/// Ignores progress and never cancels.
pub struct Silent;

impl Progress for Silent {
    fn at(&self, _stage: &str, _done: u64, _of: u64) -> Result<(), Cancelled> {
        Ok(())
    }
}

/// One stage of work, advanced by all threads that take part in it.
pub struct Stage<'a> {
    progress: &'a dyn Progress,
    name: &'a str,
    of: u64,
    done: AtomicU64,
    cancelled: AtomicBool,
}

impl<'a> Stage<'a> {
    /// Begins a stage of `of` steps.
    ///
    /// # Errors
    /// [`Cancelled`] if the caller has cancelled the work.
    pub fn begin(progress: &'a dyn Progress, name: &'a str, of: usize) -> Result<Self, Cancelled> {
        let stage = Self { progress, name, of: of as u64, done: AtomicU64::new(0), cancelled: AtomicBool::new(false) };
        stage.advance(0)?;
        Ok(stage)
    }

    /// Completes `steps` more steps.
    ///
    /// # Errors
    /// [`Cancelled`] if the caller, or another thread's report, has cancelled the work.
    pub fn advance(&self, steps: u64) -> Result<(), Cancelled> {
        self.check()?;
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        self.progress.at(self.name, done, self.of).inspect_err(|_| self.cancelled.store(true, Ordering::Relaxed))
    }

    /// `Err` once the stage has been cancelled: cheap enough for any loop.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.cancelled.load(Ordering::Relaxed) { Err(Cancelled) } else { Ok(()) }
    }
}
