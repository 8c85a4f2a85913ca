//! Keys and their actions.

use super::state::Viewer;
use super::state::grip::Tool;
use super::state::shortcuts::{OPEN, REDO, REDO_ALSO, SAVE, SAVE_PICTURE, UNDO};
use super::take_away;
use eframe::egui::{Context, Key, KeyboardShortcut};

impl Viewer {
    pub(super) fn follow_keys(&mut self, ctx: &Context) {
        if ctx.egui_wants_keyboard_input() {
            return;
        }
        let pressed = |shortcut: &KeyboardShortcut| ctx.input_mut(|input| input.consume_shortcut(shortcut));
        // Keys with shift first, as the others take them, too.
        if pressed(&REDO_ALSO) || pressed(&REDO) {
            self.redo();
        }
        if pressed(&UNDO) {
            self.undo();
        }
        if pressed(&SAVE_PICTURE) {
            take_away::save_picture(self, "png");
        }
        if pressed(&SAVE) {
            take_away::save_scene(self);
        }
        if pressed(&OPEN) {
            take_away::open(self);
        }
        // Keys held with the command key are the system's.
        if !ctx.input(|input| input.modifiers.command || input.modifiers.alt) {
            self.follow_plain_keys(ctx);
        }
    }

    fn follow_plain_keys(&mut self, ctx: &Context) {
        let pressed = |key: Key| ctx.input(|input| input.key_pressed(key));
        if pressed(Key::F) {
            self.frame_all();
        }
        if pressed(Key::Space) {
            self.clock.toggle();
        }
        if pressed(Key::P) {
            self.toggle_panels();
        }
        if pressed(Key::X) {
            self.toggle_split();
        }
        if pressed(Key::H) {
            self.toggle_heat();
        }
        if pressed(Key::M) {
            self.tool = if self.tool == Tool::Turn { Tool::Move } else { Tool::Turn };
        }
        if pressed(Key::Escape) {
            self.shown.picked = None;
        }
        let digits =
            [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];
        if let Some(index) = digits.into_iter().position(pressed) {
            self.take_camera(index);
        }
    }

    /// Takes the last change of the scene back.
    pub(super) fn undo(&mut self) {
        match self.history.undo() {
            Some(changes) => self.changes = changes,
            None => self.note("nothing to undo: no object was changed"),
        }
    }

    /// Makes the last change again that was taken back.
    pub(super) fn redo(&mut self) {
        match self.history.redo() {
            Some(changes) => self.changes = changes,
            None => self.note("nothing to do again"),
        }
    }
}
