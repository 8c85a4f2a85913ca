//! Dialogues about files. They run beside the window, which goes on.

use std::path::Path;
use std::sync::mpsc::{Receiver, channel};

/// Writes a file to a path; an error says what went wrong.
pub(super) type Write = Box<dyn FnOnce(&Path) -> Result<(), String> + Send>;

/// What becomes of a file that is saved or chosen: the path, or a problem; nothing if the user has changed their mind.
pub(in crate::app) type Outcome = Receiver<Result<std::path::PathBuf, String>>;

/// Asks where to save a file, and saves it.
pub(super) fn save(name: &str, extension: &'static str, write: Write) -> Outcome {
    let (sender, outcome) = channel();
    let dialogue = rfd::FileDialog::new().set_file_name(name).add_filter(extension, &[extension]);
    std::thread::spawn(move || {
        if let Some(path) = dialogue.save_file() {
            // The window may be gone by then.
            let _ = sender.send(write(&path).map(|()| path));
        }
    });
    outcome
}

/// Asks for a scene to be opened.
pub(in crate::app) fn open() -> Outcome {
    let (sender, outcome) = channel();
    let dialogue = rfd::FileDialog::new().add_filter("scenes", &["glb", "gltf", "obj", "toml"]);
    std::thread::spawn(move || {
        if let Some(path) = dialogue.pick_file() {
            let _ = sender.send(Ok(path));
        }
    });
    outcome
}
