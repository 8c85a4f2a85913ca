//! Progress of the studio's work, told to the window, and its end where something newer waits.

use super::mailbox::Mailbox;
use super::news::News;
use super::order::Wish;
use catoptric::progress::{Cancelled, Progress};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The kinds of news for which a piece of work ends before it is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EndedBy {
    /// Anything that waits: what sharpens a picture is done again.
    Anything,
    /// Another scene, another method or another role: what is prepared holds for all views, and a draft that were given
    /// up whenever the eye moves would never be seen.
    OtherWork,
}

/// The progress of work for one side of a wish.
pub(super) struct Interrupt<'a> {
    mailbox: &'a Mailbox,
    tell: &'a (dyn Fn(News) + Send + Sync),
    wish: &'a Wish,
    side: usize,
    ended_by: EndedBy,
    /// Arrivals that have been looked at.
    seen: AtomicU64,
    is_over: AtomicBool,
}

impl<'a> Interrupt<'a> {
    pub(super) fn new(
        mailbox: &'a Mailbox,
        tell: &'a (dyn Fn(News) + Send + Sync),
        (wish, side): (&'a Wish, usize),
        ended_by: EndedBy,
    ) -> Self {
        let (seen, is_over) = (AtomicU64::new(u64::MAX), AtomicBool::new(false));
        Self { mailbox, tell, wish, side, ended_by, seen, is_over }
    }
}

impl Progress for Interrupt<'_> {
    fn at(&self, stage: &str, done: u64, of: u64) -> Result<(), Cancelled> {
        let (arrivals, for_anything) = (self.mailbox.arrivals(), self.ended_by == EndedBy::Anything);
        let has_arrived = self.seen.swap(arrivals, Ordering::Relaxed) != arrivals;
        if self.mailbox.waits_outside(for_anything)
            || (has_arrived && self.mailbox.supersedes(self.wish, self.side, for_anything))
        {
            self.is_over.store(true, Ordering::Relaxed);
        }
        if self.is_over.load(Ordering::Relaxed) {
            return Err(Cancelled);
        }
        // The first and the last step, and about every hundredth.
        if done == 0 || done == of || of < 100 || done.is_multiple_of(of / 100) {
            let share = (of > 0).then(|| done as f32 / of as f32);
            (self.tell)(News::Busy { stage: stage.into(), share });
        }
        Ok(())
    }
}
