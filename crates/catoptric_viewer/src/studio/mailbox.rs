//! Orders on their way to the studio.

use super::order::{Order, Wish};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Orders that wait, and the newest wish: older wishes are forgotten.
#[derive(Debug, Default)]
pub struct Mailbox {
    inbox: Mutex<Inbox>,
    arrived: Condvar,
    /// Counts what has arrived, so that nobody needs the lock to see that nothing has.
    arrivals: AtomicU64,
    /// Tells whether anything waits that has not got here yet; with `false`, anything but another eye or time.
    waits_outside: Option<fn(bool) -> bool>,
}

#[derive(Debug, Default)]
struct Inbox {
    orders: VecDeque<Order>,
    wish: Option<Arc<Wish>>,
    is_closed: bool,
}

/// A look into the mailbox: what lay there.
#[derive(Debug)]
pub enum Mail {
    /// An order.
    Order(Order),
    /// A wish that has not been seen.
    Wish(Arc<Wish>),
    /// Nothing within the time.
    Nothing,
    /// There will be no more.
    Closed,
}

impl Mailbox {
    /// A mailbox into which nothing comes while work goes on, as in browsers: `waits_outside` tells whether anything
    /// waits to come in; with `false`, anything but another eye or time.
    pub fn fed_between_work(waits_outside: fn(bool) -> bool) -> Self {
        Self { waits_outside: Some(waits_outside), ..Self::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Inbox> {
        self.inbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn put(&self, change: impl FnOnce(&mut Inbox)) {
        change(&mut self.lock());
        self.arrivals.fetch_add(1, Ordering::Release);
        self.arrived.notify_all();
    }

    /// Puts an order behind the others. Scenes that wait to be loaded are forgotten for a newer one.
    pub fn send(&self, order: Order) {
        self.put(|inbox| {
            if is_load(&order) {
                inbox.orders.retain(|other| !is_load(other));
            }
            inbox.orders.push_back(order);
        });
    }

    /// Replaces the wish.
    pub fn wish(&self, wish: Arc<Wish>) {
        self.put(|inbox| inbox.wish = Some(wish));
    }

    /// Forgets what waits.
    pub fn forget(&self) {
        self.put(|inbox| (inbox.orders, inbox.wish) = (VecDeque::new(), None));
    }

    /// Ends the studio's work.
    pub fn close(&self) {
        self.put(|inbox| inbox.is_closed = true);
    }

    /// The next order, else the newest wish; waits for one as long as is given (`None`: for ever).
    pub fn take(&self, patience: Option<Duration>) -> Mail {
        let mut inbox = self.lock();
        loop {
            if inbox.is_closed {
                return Mail::Closed;
            }
            if let Some(order) = inbox.orders.pop_front() {
                return Mail::Order(order);
            }
            if let Some(wish) = inbox.wish.take() {
                return Mail::Wish(wish);
            }
            match patience {
                // Nothing may wait in browsers.
                Some(Duration::ZERO) => return Mail::Nothing,
                Some(patience) => {
                    let waited = self.arrived.wait_timeout(inbox, patience);
                    let (next, timeout) = waited.unwrap_or_else(PoisonError::into_inner);
                    inbox = next;
                    let is_empty = inbox.orders.is_empty() && inbox.wish.is_none() && !inbox.is_closed;
                    if timeout.timed_out() && is_empty {
                        return Mail::Nothing;
                    }
                }
                None => inbox = self.arrived.wait(inbox).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }

    /// True if anything waits that has not got here yet; with `for_anything` false, anything but another eye or time.
    pub(super) fn waits_outside(&self, for_anything: bool) -> bool {
        self.waits_outside.is_some_and(|waits| waits(for_anything))
    }

    /// A number that changes with every arrival.
    pub(super) fn arrivals(&self) -> u64 {
        self.arrivals.load(Ordering::Acquire)
    }

    /// True if work for `wish` is to be given up for what waits: anything that is not about the eye and the time, or,
    /// where `for_anything` is true, anything at all.
    pub(super) fn supersedes(&self, wish: &Wish, side: usize, for_anything: bool) -> bool {
        let inbox = self.lock();
        if inbox.is_closed || inbox.orders.iter().any(|order| for_anything || is_load(order)) {
            return true;
        }
        inbox.wish.as_ref().is_some_and(|next| {
            for_anything
                || next.scene != wish.scene
                || next.changes != wish.changes
                || next.sides.get(side) != wish.sides.get(side)
        })
    }
}

fn is_load(order: &Order) -> bool {
    matches!(order, Order::Load { .. })
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric::methods::Quality;
    use catoptric::scene::Camera;
    use glam::Vec3;

    fn wish(method: &str, x: f32) -> Wish {
        let quality = Quality { samples: 4, order: 2 };
        let drawn = super::super::order::Drawn { method: method.into(), settings: toml::Table::new(), quality };
        let camera = Camera::look_at("", Vec3::new(x, 0.0, 3.0), Vec3::ZERO, Vec3::Y, 40.0);
        let changes = super::super::order::Changes::default();
        Wish {
            scene: 1,
            time: 0.0,
            clip: None,
            changes,
            camera,
            size: [8, 8],
            sides: vec![drawn],
            has_automatic_order: false,
            display: Default::default(),
            compares: false,
            overlays: Vec::new(),
        }
    }

    #[test]
    fn the_newest_wish_stands_behind_all_orders() {
        let mailbox = Mailbox::default();
        mailbox.wish(Arc::new(wish("auto", 0.0)));
        mailbox.wish(Arc::new(wish("auto", 1.0)));
        mailbox.send(Order::Pick { number: 1, position_px: [0.0; 2] });
        assert!(matches!(mailbox.take(None), Mail::Order(Order::Pick { number: 1, .. })));
        assert!(matches!(mailbox.take(None), Mail::Wish(found) if *found == wish("auto", 1.0)));
        assert!(matches!(mailbox.take(Some(Duration::from_millis(1))), Mail::Nothing));
        for number in [3, 4] {
            let source = super::super::order::Source::Builtin("vase".into());
            mailbox.send(Order::Load { number, source, opening: Default::default() });
        }
        assert!(matches!(mailbox.take(None), Mail::Order(Order::Load { number: 4, .. })));
        assert!(matches!(mailbox.take(Some(Duration::ZERO)), Mail::Nothing));
        mailbox.close();
        assert!(matches!(mailbox.take(None), Mail::Closed));
    }

    #[test]
    fn the_eye_interrupts_what_sharpens_and_nothing_else() {
        let mailbox = Mailbox::default();
        let drawn = wish("auto", 0.0);
        assert!(!mailbox.supersedes(&drawn, 0, true));
        mailbox.wish(Arc::new(wish("auto", 1.0)));
        assert!(mailbox.supersedes(&drawn, 0, true) && !mailbox.supersedes(&drawn, 0, false));
        mailbox.wish(Arc::new(wish("reference", 0.0)));
        assert!(mailbox.supersedes(&drawn, 0, false));
    }
}
