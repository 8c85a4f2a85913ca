//! The studio in a worker, which draws by WebGPU where there is a device, else by the CPU.
//!
//! Where the page is isolated, memory that both share tells the worker of messages that wait; else work is not ended
//! before it is done.

use catoptric_gpu::Context;
use catoptric_viewer::studio::news::News;
use catoptric_viewer::studio::wire::{Message, Request, news, read_request};
use catoptric_viewer::studio::{Gpu, Mailbox, Studio, Turn};
use js_sys::{Atomics, Function, Int32Array, Reflect, Uint8Array};
use std::cell::{Cell, RefCell};
use std::sync::Arc;
use std::time::Duration;
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsError, JsValue};

thread_local! {
    /// Counts of messages that were sent: all, and those about something else than eye and time.
    static SENT: RefCell<Option<Int32Array>> = const { RefCell::new(None) };
    /// The same of those that were received.
    static RECEIVED: Cell<[i32; 2]> = const { Cell::new([0; 2]) };
    /// Posts news to the page.
    static POST: RefCell<Option<Function>> = const { RefCell::new(None) };
}

/// True if messages wait that were not received; with `for_anything` false, only those about something else than eye
/// and time count.
fn waits_outside(for_anything: bool) -> bool {
    let index = if for_anything { 0 } else { 1 };
    let sent = SENT.with_borrow(|sent| Atomics::load(sent.as_ref()?, index).ok());
    sent.is_some_and(|sent| sent != RECEIVED.get()[index as usize])
}

/// The device that is to draw, or why there is none.
async fn chosen(processor: &str) -> Result<Gpu, String> {
    match processor {
        "cpu" => return Err(String::new()),
        super::line::AFTER_FAILURE => return Err("WebGPU is not used again after a failure".into()),
        _ => {}
    }
    let navigator = Reflect::get(&js_sys::global(), &"navigator".into()).unwrap_or_default();
    if !Reflect::get(&navigator, &"gpu".into()).is_ok_and(|gpu| gpu.is_truthy()) {
        return Err("this browser offers no WebGPU here".into());
    }
    let context = Context::request(None).await.map_err(|error| error.to_string())?;
    let is_software = context.adapter().is_some_and(|adapter| adapter.is_software);
    if is_software && processor != "gpu" {
        return Err("its WebGPU draws on the processor itself".into());
    }
    Ok(Gpu::apart(context))
}

/// The words for scenes that the CPU draws.
fn by_cpu(reason: &str, is_interruptible: bool) -> String {
    let mut words = String::from("drawn by the CPU, on one thread");
    if !reason.is_empty() {
        words.push_str(": ");
        words.push_str(reason);
    }
    if !is_interruptible {
        words.push_str("; the page is not isolated, so work cannot be interrupted");
    }
    words
}

/// The studio of a worker.
#[wasm_bindgen]
pub struct StudioWorker {
    studio: Studio,
    mailbox: Arc<Mailbox>,
}

#[wasm_bindgen]
impl StudioWorker {
    /// Starts a studio. `sent` are the counts of what was sent, in shared memory, or undefined; `post` takes a text and
    /// an array of bytes to the page; `processor` is what is to draw scenes: `gpu`, `cpu`,
    /// [`super::line::AFTER_FAILURE`] (the CPU, too), or anything else for the better one.
    pub async fn start(sent: Option<Int32Array>, post: Function, processor: String) -> Self {
        let is_interruptible = sent.is_some();
        SENT.set(sent);
        POST.set(Some(post));
        let (gpu, remark) = match chosen(&processor).await {
            Ok(gpu) => {
                let remark = format!("drawn by {}", gpu.name());
                (Some(gpu), remark)
            }
            Err(reason) => (None, by_cpu(&reason, is_interruptible)),
        };
        let mailbox = Arc::new(Mailbox::fed_between_work(waits_outside));
        let tell = |told| {
            let Some(Message { text, bytes }) = news(told) else { return };
            POST.with_borrow(|post| {
                let post = post.as_ref()?;
                // A page that has gone takes nothing.
                post.call2(&JsValue::NULL, &text.into(), &Uint8Array::from(&bytes[..])).ok()
            });
        };
        tell(News::Remark { text: remark });
        Self { studio: Studio::new(mailbox.clone(), Arc::new(tell), gpu), mailbox }
    }

    /// Takes a message of the page in; `is_other_work` if it is about something else than eye and time.
    ///
    /// # Errors
    /// Messages that cannot be read.
    pub fn receive(&self, text: String, bytes: Vec<u8>, is_other_work: bool) -> Result<(), JsError> {
        let [all, other] = RECEIVED.get();
        RECEIVED.set([all.wrapping_add(1), other.wrapping_add(i32::from(is_other_work))]);
        match read_request(Message { text, bytes })? {
            Request::Order(order) => self.mailbox.send(order),
            Request::Wish(wish) => self.mailbox.wish(wish),
        }
        Ok(())
    }

    /// Does the next piece of work. Returns after how many milliseconds there is to be another turn; below 0: not
    /// before something is received.
    pub fn turn(&mut self) -> f64 {
        if self.studio.turn(Some(Duration::ZERO)) == Turn::Over {
            return -1.0;
        }
        self.studio.patience().map_or(-1.0, |patience| patience.as_secs_f64() * 1e3)
    }
}
