//! Files to be saved and opened. Dialogues run beside the window, which goes on.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};

/// Makes a file's content, told the path where it will be.
pub(super) type Make = Box<dyn FnOnce(&Path) -> Result<Vec<u8>, String> + Send>;

/// A scene that was chosen.
#[derive(Clone, Debug)]
pub(in crate::app) enum Chosen {
    /// A file on this machine.
    #[cfg_attr(target_family = "wasm", expect(dead_code, reason = "browsers show no paths"))]
    Path(PathBuf),
    /// Names and contents of files.
    #[cfg_attr(not(target_family = "wasm"), expect(dead_code, reason = "paths tell more"))]
    Contents(Vec<(String, Vec<u8>)>),
}

/// What becomes of a file that is saved: its path, or a problem; nothing if the user has changed their mind.
pub(in crate::app) type Saved = Receiver<Result<PathBuf, String>>;

/// What becomes of a choice: a scene or a problem; nothing if the user has changed their mind.
pub(in crate::app) type Choice = Receiver<Result<Chosen, String>>;

/// Asks where to save a file, and saves it.
pub(super) fn save(name: &str, extension: &'static str, make: Make) -> Saved {
    let (sender, saved) = channel();
    system::save(name, extension, make, sender);
    saved
}

/// Asks for a scene to be opened.
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
    done: Sender<Result<Chosen, String>>,
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
    let _ = done.send(contents.map(Chosen::Contents));
}

#[cfg(not(target_family = "wasm"))]
mod system {
    use super::{Chosen, Make, Path, PathBuf, Sender};
    use std::io::Write;

    pub(super) fn save(name: &str, extension: &'static str, make: Make, done: Sender<Result<PathBuf, String>>) {
        let dialogue = rfd::FileDialog::new().set_file_name(name).add_filter(extension, &[extension]);
        let write = move |path: &Path| {
            let content = make(path)?;
            let written = catoptric::output::write_file(path, |writer| writer.write_all(&content));
            written.map_err(|error| error.to_string())
        };
        std::thread::spawn(move || {
            if let Some(path) = dialogue.save_file() {
                // The window may be gone by then.
                let _ = done.send(write(&path).map(|()| path));
            }
        });
    }

    pub(super) fn open(done: Sender<Result<Chosen, String>>) {
        let dialogue = rfd::FileDialog::new()
            .add_filter("scenes and bakes", &["glb", "gltf", "obj", "ply", "stl", "toml", "bake"]);
        std::thread::spawn(move || {
            if let Some(path) = dialogue.pick_file() {
                let _ = done.send(Ok(Chosen::Path(path)));
            }
        });
    }
}

#[cfg(target_family = "wasm")]
mod system {
    use super::{Chosen, Make, Path, PathBuf, Sender};
    use js_sys::{Array, Uint8Array};
    use wasm_bindgen::prelude::Closure;
    use wasm_bindgen::{JsCast, JsValue};
    use wasm_bindgen_futures::JsFuture;

    pub(super) fn save(name: &str, _extension: &'static str, make: Make, done: Sender<Result<PathBuf, String>>) {
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

    pub(super) fn open(done: Sender<Result<Chosen, String>>) {
        if choose(done.clone()).is_err() {
            let _ = done.send(Err("the browser shows no dialogue; drop a file onto the picture to open it".into()));
        }
    }

    /// Shows the browser's dialogue.
    fn choose(done: Sender<Result<Chosen, String>>) -> Result<(), JsValue> {
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
