//! A studio on a thread.

use super::Link;
use crate::studio::news::News;
use crate::studio::order::{Order, Wish};
use crate::studio::{Gpu, Mailbox, Studio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

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
        let mut studio = Studio::new(mailbox.clone(), Arc::new(tell), gpu);
        let thread = Some(std::thread::spawn(move || studio.run()));
        Self { mailbox, news, thread }
    }
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
            // Its panic, if there was one, has been printed.
            let _ = thread.join();
        }
    }
}
