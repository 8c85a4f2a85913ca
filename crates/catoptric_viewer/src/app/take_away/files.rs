//! Files to be saved and opened. Dialogues run beside the window, which goes on.

#[cfg(target_family = "wasm")]
use super::super::state::file::{Choice, Contents};
use super::super::state::file::{Make, Saved};
#[cfg(target_family = "wasm")]
use std::path::Path;
use std::path::PathBuf;
#[cfg(target_family = "wasm")]
use std::sync::mpsc::Sender;
use std::sync::mpsc::channel;

/// Saves a file where the browser does.
#[cfg(target_family = "wasm")]
pub(super) fn save(name: &str, make: Make) -> Saved {
    let (sender, saved) = channel();
    system::save(name, make, sender);
    saved
}

/// Asks for a scene to be opened.
#[cfg(target_family = "wasm")]
pub(in crate::app) fn open() -> Choice {
    let (sender, choice) = channel();
    system::open(sender);
    choice
}

/// The contents of files that were dropped, which browsers give later.
#[cfg(target_family = "wasm")]
pub(in crate::app) fn read_dropped(files: Vec<eframe::egui::DroppedFileHandle>) -> Choice {
    let (sender, choice) = channel();
    let read = files.into_iter().map(|file| {
        let name = file.path().display().to_string();
        (name, async move { file.bytes_async().await.map_err(|problem| problem.to_string()) })
    });
    wasm_bindgen_futures::spawn_local(gather(read, sender));
    choice
}

/// Reads files, one after the other, and tells their contents or the first problem.
#[cfg(target_family = "wasm")]
async fn gather<Read: Future<Output = Result<Vec<u8>, String>>>(
    files: impl Iterator<Item = (String, Read)>,
    done: Sender<Result<Contents, String>>,
) {
    let mut contents = Ok(Vec::new());
    for (name, read) in files {
        match (&mut contents, read.await) {
            (Ok(all), Ok(content)) => all.push((name, content)),
            (Ok(_), Err(problem)) => contents = Err(format!("{name}: {problem}")),
            (Err(_), _) => break,
        }
    }
    // The window may be gone by then.
    let _ = done.send(contents);
}

/// Makes a file's content and writes it, whole or not at all, beside the window.
#[cfg(not(target_family = "wasm"))]
pub(super) fn write(path: PathBuf, make: Make, window: Option<eframe::egui::Context>) -> Saved {
    use std::io::Write;
    let (sender, saved) = channel();
    std::thread::spawn(move || {
        let written = make(&path).and_then(|content| {
            let written = catoptric::output::write_file(&path, |writer| writer.write_all(&content));
            written.map_err(|error| format!("{error}; choose another place"))
        });
        // The window may be gone by then.
        let _ = sender.send(written.map(|()| path));
        window.iter().for_each(eframe::egui::Context::request_repaint);
    });
    saved
}

#[cfg(target_family = "wasm")]
mod system {
    use super::{Contents, Make, Path, PathBuf, Sender};
    use js_sys::{Array, Uint8Array};
    use wasm_bindgen::prelude::Closure;
    use wasm_bindgen::{JsCast, JsValue};
    use wasm_bindgen_futures::JsFuture;

    pub(super) fn save(name: &str, make: Make, done: Sender<Result<PathBuf, String>>) {
        let path = Path::new(name);
        let words = |_: JsValue| format!("the browser does not save `{name}`");
        let saved = make(path).and_then(|content| download(name, &content).map_err(words));
        // The window may be gone by then.
        let _ = done.send(saved.map(|()| path.to_path_buf()));
    }

    /// Hands bytes to the browser as a download.
    fn download(name: &str, content: &[u8]) -> Result<(), JsValue> {
        let parts = Array::of1(&Uint8Array::from(content));
        let url = web_sys::Url::create_object_url_with_blob(&web_sys::Blob::new_with_u8_array_sequence(&parts)?)?;
        let document = web_sys::window().and_then(|window| window.document()).ok_or(JsValue::NULL)?;
        let anchor: web_sys::HtmlAnchorElement = document.create_element("a")?.unchecked_into();
        anchor.set_href(&url);
        anchor.set_download(name);
        anchor.click();
        web_sys::Url::revoke_object_url(&url)
    }

    pub(super) fn open(done: Sender<Result<Contents, String>>) {
        if choose(done.clone()).is_err() {
            let _ = done.send(Err("the browser shows no dialogue; drop a file onto the picture to open it".into()));
        }
    }

    /// Shows the browser's dialogue.
    fn choose(done: Sender<Result<Contents, String>>) -> Result<(), JsValue> {
        let document = web_sys::window().and_then(|window| window.document()).ok_or(JsValue::NULL)?;
        let input: web_sys::HtmlInputElement = document.create_element("input")?.unchecked_into();
        input.set_type("file");
        input.set_multiple(true);
        let chosen = input.clone();
        let read = Closure::once_into_js(move || {
            let files = chosen.files();
            let all = move |index| files.as_ref().and_then(|files| files.get(index));
            let read = (0..).map_while(all).map(|file| {
                let content = JsFuture::from(file.array_buffer());
                let read = async move { content.await.map_err(|problem| format!("{problem:?}")) };
                (file.name(), async move { Ok(Uint8Array::new(&read.await?).to_vec()) })
            });
            wasm_bindgen_futures::spawn_local(super::gather(read, done));
        });
        input.set_onchange(Some(read.unchecked_ref()));
        input.click();
        Ok(())
    }
}
