//! A studio on a thread.

use super::{Link, Restarts};
use crate::studio::news::News;
use crate::studio::order::{Order, Wish};
use crate::studio::{Gpu, Mailbox, Studio, Tell};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

/// A studio on a thread of its own.
#[derive(Debug)]
pub struct StudioThread {
    mailbox: Arc<Mailbox>,
    news: Receiver<News>,
    thread: Option<JoinHandle<()>>,
}

impl StudioThread {
    /// Starts a studio; `wake_up` is called whenever it has news.
    pub fn start(gpu: Option<Gpu>, wake_up: Box<dyn Fn() + Send + Sync>) -> Self {
        let mailbox = Arc::new(Mailbox::default());
        let (sender, news) = channel();
        let sender = Mutex::new(sender);
        let tell = move |news| {
            // Nobody listens any more while the window closes.
            let _ = sender.lock().unwrap_or_else(PoisonError::into_inner).send(news);
            wake_up();
        };
        let (inbox, tell): (_, Tell) = (mailbox.clone(), Arc::new(tell));
        let thread = Some(std::thread::spawn(move || work(&inbox, &tell, gpu)));
        Self { mailbox, news, thread }
    }
}

/// Has a studio work until the mailbox is closed; after a panic a new one, which draws without a device.
fn work(mailbox: &Arc<Mailbox>, tell: &Tell, mut gpu: Option<Gpu>) {
    let start = Instant::now();
    let mut restarts = Restarts::default();
    loop {
        let had_device = gpu.is_some();
        let mut studio = Studio::new(mailbox.clone(), tell.clone(), gpu.take());
        // Whatever a panic has left half done goes with the studio, and with what waits in the mailbox.
        let Err(panic) = catch_unwind(AssertUnwindSafe(|| studio.run())) else { return };
        drop(studio);
        let problem = words(&*panic);
        if !restarts.allow(start.elapsed()) {
            return tell(News::Stopped { problem });
        }
        mailbox.forget();
        if had_device {
            tell(News::Remark { text: "drawn by the CPU: the device is not used again after a failure".into() });
        }
        tell(News::Restarted { problem });
    }
}

/// The words of a panic.
fn words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("a panic without words").to_owned()
}

impl Link for StudioThread {
    fn send(&self, order: Order) {
        self.mailbox.send(order);
    }

    fn wish(&self, wish: Arc<Wish>) {
        self.mailbox.wish(wish);
    }

    fn news(&self) -> Option<News> {
        self.news.try_recv().ok()
    }
}

impl Drop for StudioThread {
    fn drop(&mut self) {
        self.mailbox.close();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread, if there was one, has been printed.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::order::Source;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::Duration;

    fn load(thread: &StudioThread, number: u64) {
        thread.send(Order::Load {
            number,
            source: Source::Builtin("sphere_room?tess=16".into()),
            opening: Default::default(),
        });
    }

    /// The first news of a kind.
    fn first(thread: &StudioThread, is_wanted: impl Fn(&News) -> bool) -> News {
        loop {
            let news = thread.news.recv_timeout(Duration::from_secs(60)).unwrap();
            if is_wanted(&news) {
                return news;
            }
        }
    }

    #[test]
    fn a_panic_has_another_studio_go_on_up_to_three_times() {
        let fails = Arc::new(AtomicBool::new(false));
        let armed = fails.clone();
        // The studio calls this in the midst of its work.
        let wake_up = move || assert!(!armed.swap(false, Ordering::SeqCst), "the test has it fail");
        let thread = StudioThread::start(None, Box::new(wake_up));
        for number in 1..=4 {
            fails.store(true, Ordering::SeqCst);
            load(&thread, number);
            let told = first(&thread, |news| matches!(news, News::Restarted { .. } | News::Stopped { .. }));
            match told {
                News::Restarted { problem } if number < 4 => assert!(problem.contains("the test has it fail")),
                News::Stopped { problem } if number == 4 => assert!(problem.contains("the test has it fail")),
                other => panic!("after {number} failures: {other:?}"),
            }
            if number < 4 {
                load(&thread, 10 + number);
                first(&thread, |news| matches!(news, News::Loaded(summary) if summary.number == 10 + number));
            }
        }
    }
}
