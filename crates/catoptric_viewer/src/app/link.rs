//! The window's end of the line to the studio.

use crate::studio::news::News;
use crate::studio::order::{Order, Wish};
use crate::studio::{Gpu, Mailbox, Studio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

/// A studio on a thread of its own.
#[derive(Debug)]
pub struct Link {
    mailbox: Arc<Mailbox>,
    news: Receiver<News>,
    thread: Option<JoinHandle<()>>,
}

impl Link {
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

    /// Gives an order.
    pub fn send(&self, order: Order) {
        self.mailbox.send(order);
    }

    /// Replaces the wish.
    pub fn wish(&self, wish: Arc<Wish>) {
        self.mailbox.wish(wish);
    }

    /// The next news, if there is any.
    pub fn news(&self) -> Option<News> {
        self.news.try_recv().ok()
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.mailbox.close();
        if let Some(thread) = self.thread.take() {
            // Its panic, if there was one, has been printed.
            let _ = thread.join();
        }
    }
}
