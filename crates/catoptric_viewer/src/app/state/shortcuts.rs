//! Keys that are pressed together.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

/// Opens a file. The command key is Ctrl, on Macs Cmd.
pub(in crate::app) const OPEN: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::O);
/// Saves the scene.
pub(in crate::app) const SAVE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::S);
/// Saves the picture.
pub(in crate::app) const SAVE_PICTURE: KeyboardShortcut = KeyboardShortcut::new(COMMAND_SHIFT, Key::S);
/// Takes the last change back.
pub(in crate::app) const UNDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Z);
/// Makes it again.
pub(in crate::app) const REDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Y);
/// Makes it again, as well.
pub(in crate::app) const REDO_ALSO: KeyboardShortcut = KeyboardShortcut::new(COMMAND_SHIFT, Key::Z);

const COMMAND_SHIFT: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };
