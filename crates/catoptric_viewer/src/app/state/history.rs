//! Changes of the user, step by step, to be undone and done again.

use crate::studio::order::Changes;

/// Steps that are kept.
const STEPS: usize = 200;

/// The steps before and after the present changes.
#[derive(Debug, Default)]
pub(in crate::app) struct History {
    /// The changes as they were recorded last.
    present: Changes,
    before: Vec<Changes>,
    after: Vec<Changes>,
}

impl History {
    /// Records changes as a step, if they are others than before: once nothing is in the hand.
    pub(in crate::app) fn record(&mut self, now: &Changes) {
        if *now == self.present {
            return;
        }
        self.before.push(std::mem::replace(&mut self.present, now.clone()));
        if self.before.len() > STEPS {
            self.before.remove(0);
        }
        self.after.clear();
    }

    /// True if there is a step to be undone.
    pub(in crate::app) fn can_undo(&self) -> bool {
        !self.before.is_empty()
    }

    /// True if there is a step that was undone.
    pub(in crate::app) fn can_redo(&self) -> bool {
        !self.after.is_empty()
    }

    /// The changes before the last step; `None` if there is no step.
    pub(in crate::app) fn undo(&mut self) -> Option<Changes> {
        let before = self.before.pop()?;
        self.after.push(std::mem::replace(&mut self.present, before));
        Some(self.present.clone())
    }

    /// The changes after a step that was undone; `None` if there is none.
    pub(in crate::app) fn redo(&mut self) -> Option<Changes> {
        let after = self.after.pop()?;
        self.before.push(std::mem::replace(&mut self.present, after));
        Some(self.present.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn steps_are_undone_and_done_again() {
        let moved = |by: f32| Changes { moves: [("ball".into(), by * Vec3::X)].into(), ..Changes::default() };
        let mut history = History::default();
        for now in [Changes::default(), moved(1.0), moved(1.0), moved(2.0)] {
            history.record(&now);
        }
        assert_eq!(
            (history.undo(), history.undo(), history.undo()),
            (Some(moved(1.0)), Some(Changes::default()), None)
        );
        assert_eq!(history.redo(), Some(moved(1.0)));
        // Another step ends what could be done again.
        history.record(&moved(3.0));
        assert_eq!((history.redo(), history.undo()), (None, Some(moved(1.0))));
    }
}
