//! The program in a page: the window on the page's thread, and the studio in a worker, which is a second instance of
//! the same module.

mod accessible;
mod line;
mod page;
mod worker;

use wasm_bindgen::prelude::wasm_bindgen;

/// Puts the words of a panic where JavaScript finds them: `catoptricPanic` of the page or the worker.
#[wasm_bindgen]
#[expect(unreachable_pub, reason = "JavaScript reaches it")]
pub fn install_panic_hook() {
    std::panic::set_hook(Box::new(|panic| {
        // There is nothing that could be done about a failure of this.
        let _ = js_sys::Reflect::set(&js_sys::global(), &"catoptricPanic".into(), &panic.to_string().into());
    }));
}
