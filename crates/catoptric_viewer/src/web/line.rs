//! The page's end of the line to the worker.

use catoptric_viewer::app::Link;
use catoptric_viewer::studio::news::News;
use catoptric_viewer::studio::order::{Order, Wish};
use catoptric_viewer::studio::wire::{Message, Request, read_news, request};
use eframe::egui::Context;
use js_sys::{Array, Atomics, Int32Array, Reflect, SharedArrayBuffer, Uint8Array};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;
use wasm_bindgen::prelude::Closure;
use wasm_bindgen::{JsCast, JsValue};
use web_sys::{ErrorEvent, MessageEvent, Worker, WorkerOptions, WorkerType};

/// News that has come and was not read.
type Inbox = Rc<RefCell<VecDeque<News>>>;

/// A studio in a worker.
pub(super) struct WorkerLine {
    worker: Worker,
    inbox: Inbox,
    /// Counts of messages that were sent, in memory that the worker sees while it works: all, and those about something
    /// else than eye and time. `None` on pages that are not isolated.
    sent: Option<Int32Array>,
    last: RefCell<Option<Arc<Wish>>>,
    _on_message: Closure<dyn FnMut(MessageEvent)>,
    _on_error: Closure<dyn FnMut(ErrorEvent)>,
}

impl WorkerLine {
    /// Starts the worker of this address with the compiled module that the page runs. `processor` is what is to draw.
    ///
    /// # Errors
    /// What the browser says.
    pub(super) fn start(url: &str, (module, processor): (&JsValue, &str), window: &Context) -> Result<Self, JsValue> {
        let options = WorkerOptions::new();
        options.set_type(WorkerType::Module);
        let worker = Worker::new_with_options(url, &options)?;
        let inbox = Inbox::default();
        let (to_inbox, wake) = (inbox.clone(), window.clone());
        let on_message = Closure::new(move |event: MessageEvent| {
            to_inbox.borrow_mut().push_back(read(&event.data()));
            wake.request_repaint();
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
        Ok(Self { worker, inbox, sent, last: RefCell::default(), _on_message: on_message, _on_error: on_error })
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
}

impl Link for WorkerLine {
    fn send(&self, order: Order) {
        let is_load = matches!(order, Order::Load { .. });
        self.post(&Request::Order(order), is_load);
    }

    fn wish(&self, wish: Arc<Wish>) {
        let last = self.last.replace(Some(wish.clone()));
        let is_same =
            |last: &Arc<Wish>| (last.scene, &last.changes, &last.sides) == (wish.scene, &wish.changes, &wish.sides);
        let is_other_work = !last.as_ref().is_some_and(is_same);
        self.post(&Request::Wish(wish), is_other_work);
    }

    fn news(&self) -> Option<News> {
        self.inbox.borrow_mut().pop_front()
    }
}

impl Drop for WorkerLine {
    fn drop(&mut self) {
        self.worker.terminate();
    }
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
