//! How often a studio that has failed is started again.

use std::collections::VecDeque;
use std::time::Duration;

/// Starts again that are allowed [`Restarts::WITHIN`] a time: what fails more often fails for ever.
#[derive(Debug, Default)]
pub struct Restarts {
    /// The last ones.
    times: VecDeque<Duration>,
}

impl Restarts {
    /// The most starts that are allowed within [`Self::WITHIN`].
    pub const MOST: usize = 3;

    /// The time over which starts are counted.
    pub const WITHIN: Duration = Duration::from_secs(60);

    /// True if another start is allowed now, which is then counted. `now` is the time since any fixed moment.
    pub fn allow(&mut self, now: Duration) -> bool {
        self.times.retain(|time| now.saturating_sub(*time) < Self::WITHIN);
        let is_allowed = self.times.len() < Self::MOST;
        if is_allowed {
            self.times.push_back(now);
        }
        is_allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_are_allowed_a_minute() {
        let mut restarts = Restarts::default();
        let allowed = [0, 10, 20, 30, 59, 61, 62, 71].map(|second| restarts.allow(Duration::from_secs(second)));
        assert_eq!(allowed, [true, true, true, false, false, true, false, true]);
    }
}
