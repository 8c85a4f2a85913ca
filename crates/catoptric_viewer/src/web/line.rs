//! The page's end of the line to the worker.

use catoptric_viewer::app::{Link, Restarts};
use catoptric_viewer::studio::news::News;
use catoptric_viewer::studio::order::{Order, Wish};
use catoptric_viewer::studio::wire::{Message, Request, read_news, request};
use eframe::egui::Context;
use js_sys::{Array, Atomics, Function, Int32Array, Reflect, SharedArrayBuffer, Uint8Array};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;
use wasm_bindgen::prelude::Closure;
use wasm_bindgen::{JsCast, JsValue};
use web_sys::{ErrorEvent, MessageEvent, Worker, WorkerOptions, WorkerType};

/// The processor of a studio that takes the place of one that has failed: the CPU.
pub(super) const AFTER_FAILURE: &str = "cpu after a failure";

/// News that has come and was not read.
type Inbox = Rc<RefCell<VecDeque<News>>>;

/// A studio in a worker, which is started again if it fails.
pub(super) struct WorkerLine {
    url: String,
    /// The compiled module that the page runs.
    module: JsValue,
    window: Context,
    /// `None` once it has failed too often.
    running: RefCell<Option<RunningWorker>>,
    restarts: RefCell<Restarts>,
}

/// A worker and what is known of it.
struct RunningWorker {
    worker: Worker,
    /// The page's option `processor`: the one that is to draw.
    processor: String,
    inbox: Inbox,
    /// Counts of messages that were sent, in memory that the worker sees while it works: all, and those about something
    /// else than eye and time. `None` on pages that are not isolated.
    sent: Option<Int32Array>,
    last: RefCell<Option<Arc<Wish>>>,
    _on_message: Closure<dyn FnMut(MessageEvent)>,
    _on_error: Closure<dyn FnMut(ErrorEvent)>,
}

impl WorkerLine {
    /// Starts the worker of this address with the compiled module that the page runs. `processor` is the page's
    /// option: the one that is to draw.
    ///
    /// # Errors
    /// The browser's error if it starts no worker.
    pub(super) fn start(url: &str, (module, processor): (&JsValue, &str), window: &Context) -> Result<Self, JsValue> {
        let running = RefCell::new(Some(RunningWorker::start(url, (module, processor), window)?));
        let (url, module, window) = (url.into(), module.clone(), window.clone());
        Ok(Self { url, module, window, running, restarts: RefCell::default() })
    }

    fn post(&self, what: &Request, is_other_work: bool) {
        if let Some(running) = &*self.running.borrow() {
            running.post(what, is_other_work);
        }
    }

    /// Starts another worker in place of one that has failed, if it has not failed too often. Returns what is told.
    fn restart(&self, problem: String) -> News {
        let Some(failed) = self.running.take() else { return News::Stopped { problem } };
        // The device may be why.
        let processor = if failed.processor == "cpu" { "cpu" } else { AFTER_FAILURE };
        // Ends a worker that has failed and still waits for messages.
        drop(failed);
        if !self.restarts.borrow_mut().allow(Duration::from_secs_f64(js_sys::Date::now() / 1e3)) {
            return News::Stopped { problem };
        }
        match RunningWorker::start(&self.url, (&self.module, processor), &self.window) {
            Ok(running) => {
                self.running.replace(Some(running));
                News::Restarted { problem }
            }
            Err(error) => News::Stopped { problem: format!("{problem}; another worker cannot be started: {error:?}") },
        }
    }
}

impl RunningWorker {
    fn start(url: &str, (module, processor): (&JsValue, &str), window: &Context) -> Result<Self, JsValue> {
        let options = WorkerOptions::new();
        options.set_type(WorkerType::Module);
        let worker = Worker::new_with_options(url, &options)?;
        let inbox = Inbox::default();
        let (to_inbox, wake) = (inbox.clone(), window.clone());
        let on_message = Closure::new(move |event: MessageEvent| match event.data().as_string() {
            Some(lock) => watch(&lock, &to_inbox, &wake),
            None => {
                to_inbox.borrow_mut().push_back(read(&event.data()));
                wake.request_repaint();
            }
        });
        let (to_inbox, wake) = (inbox.clone(), window.clone());
        let on_error = Closure::new(move |event: ErrorEvent| {
            to_inbox.borrow_mut().push_back(stopped(&text(&event, "message")));
            wake.request_repaint();
        });
        worker.set_onmessage(Some(AsRef::<JsValue>::as_ref(&on_message).unchecked_ref()));
        worker.set_onerror(Some(AsRef::<JsValue>::as_ref(&on_error).unchecked_ref()));
        let is_isolated = Reflect::get(&js_sys::global(), &"crossOriginIsolated".into())?.is_truthy();
        let sent = is_isolated.then(|| Int32Array::new(&SharedArrayBuffer::new(8)));
        let counts = sent.as_ref().map_or(JsValue::UNDEFINED, JsValue::from);
        let begin = Array::of3(module, &counts, &processor.into());
        worker.post_message(&begin)?;
        let (last, processor) = (RefCell::default(), processor.into());
        Ok(Self { worker, processor, inbox, sent, last, _on_message: on_message, _on_error: on_error })
    }

    fn post(&self, what: &Request, is_other_work: bool) {
        let Some(Message { text, bytes }) = request(what) else { return };
        if let Some(sent) = &self.sent {
            let counts = if is_other_work { 0..2 } else { 0..1 };
            // Both indices are there.
            counts.for_each(|index| drop(Atomics::add(sent, index, 1)));
        }
        let bytes = Uint8Array::from(&bytes[..]);
        let message = Array::of3(&text.into(), &bytes, &is_other_work.into());
        if let Err(problem) = self.worker.post_message_with_transfer(&message, &Array::of1(&bytes.buffer())) {
            self.inbox.borrow_mut().push_back(stopped(&format!("{problem:?}")));
        }
    }

    /// True if a wish is about something else than the eye and the time of the one before.
    fn is_other_work(&self, wish: &Arc<Wish>) -> bool {
        let last = self.last.replace(Some(wish.clone()));
        let is_same =
            |last: &Arc<Wish>| (last.scene, &last.changes, &last.sides) == (wish.scene, &wish.changes, &wish.sides);
        !last.as_ref().is_some_and(is_same)
    }
}

impl Link for WorkerLine {
    fn send(&self, order: Order) {
        let is_load = matches!(order, Order::Load { .. });
        self.post(&Request::Order(order), is_load);
    }

    fn wish(&self, wish: Arc<Wish>) {
        let is_other_work = self.running.borrow().as_ref().is_some_and(|running| running.is_other_work(&wish));
        self.post(&Request::Wish(wish), is_other_work);
    }

    fn news(&self) -> Option<News> {
        let news = self.running.borrow().as_ref()?.inbox.borrow_mut().pop_front()?;
        Some(match news {
            News::Stopped { problem } => self.restart(problem),
            other => other,
        })
    }
}

impl Drop for RunningWorker {
    fn drop(&mut self) {
        self.worker.terminate();
    }
}

/// Waits for the lock that a worker holds as long as it lives, whatever ends it, and tells that it has gone.
fn watch(lock: &str, inbox: &Inbox, window: &Context) {
    let (inbox, window) = (inbox.clone(), window.clone());
    let gone = Closure::once_into_js(move || {
        // Nobody reads this if the page itself has ended it.
        inbox.borrow_mut().push_back(stopped("the browser has ended the worker, perhaps for want of memory"));
        window.request_repaint();
    });
    let ask = || -> Result<(), JsValue> {
        let navigator = Reflect::get(&js_sys::global(), &"navigator".into())?;
        let locks = Reflect::get(&navigator, &"locks".into())?;
        let request: Function = Reflect::get(&locks, &"request".into())?.dyn_into()?;
        request.call2(&locks, &lock.into(), &gone).map(drop)
    };
    // Where there are no locks, workers post none.
    let _ = ask();
}

/// The news in a message of the worker: a text and bytes, or the words of its failure.
fn read(data: &JsValue) -> News {
    let message = Array::from(data);
    let Some(text) = message.get(0).as_string() else {
        return stopped(&message.get(1).as_string().unwrap_or_default());
    };
    let bytes = message.get(1).dyn_into().map_or_else(|_| Vec::new(), |bytes: Uint8Array| bytes.to_vec());
    read_news(Message { text, bytes }).unwrap_or_else(|error| stopped(&error.to_string()))
}

/// The studio does nothing any more.
fn stopped(problem: &str) -> News {
    News::Stopped { problem: problem.into() }
}

/// A text of an event; plain events have none.
fn text(event: &JsValue, key: &str) -> String {
    Reflect::get(event, &key.into()).ok().and_then(|value| value.as_string()).unwrap_or_default()
}
