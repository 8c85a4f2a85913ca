//! Asks for paths: by the system's dialogue, or in the window where no service shows one.

use super::super::state::Viewer;
use super::super::state::question::{Answer, Asked, Purpose, Question, free};
use super::files;
use crate::studio::order::{Opening, Source};
use eframe::egui::{Align2, Context, Window};
use std::path::PathBuf;
use std::sync::mpsc::{TryRecvError, channel};
use std::time::{Duration, Instant};

/// Nobody calls a dialogue off so soon: one that ends by then was never shown.
const SOONEST: Duration = Duration::from_millis(400);

impl Viewer {
    /// Has paths asked for in the window, whatever dialogues the system may have.
    pub fn ask_in_window(&mut self) {
        self.has_dialogues = false;
    }

    /// Asks for a path.
    pub(in crate::app) fn ask(&mut self, purpose: Purpose) {
        let asked = if self.has_dialogues {
            let (sender, answer) = channel();
            let (dialogue, window) = (purpose.dialogue(), self.window.clone());
            std::thread::spawn(move || {
                // The window may be gone by then.
                let _ = sender.send(dialogue());
                window.iter().for_each(Context::request_repaint);
            });
            Asked::Dialogue(answer, Instant::now())
        } else {
            self.asked_in_window(&purpose)
        };
        self.questions.push(Question { purpose, asked });
    }

    /// The question in the window, with a path that is proposed.
    fn asked_in_window(&self, purpose: &Purpose) -> Asked {
        let own = match &self.source {
            Source::File(file) => std::path::absolute(file).ok().and_then(|file| Some(file.parent()?.to_path_buf())),
            _ => None,
        };
        let folder = own.or_else(|| std::env::current_dir().ok()).unwrap_or_default();
        let path = free(&folder.join(purpose.name()));
        Asked::Window { path: path.display().to_string(), problem: String::new(), is_new: true }
    }

    /// True while a dialogue of the system is open, or is being waited for.
    pub(in crate::app) fn has_dialogue(&self) -> bool {
        self.questions.iter().any(|question| matches!(question.asked, Asked::Dialogue(..)))
    }

    /// Asks in the window what dialogues ask that have not been answered.
    pub(in crate::app) fn give_dialogues_up(&mut self) {
        for mut question in std::mem::take(&mut self.questions) {
            if matches!(question.asked, Asked::Dialogue(..)) {
                question.asked = self.asked_in_window(&question.purpose);
            }
            self.questions.push(question);
        }
    }

    /// Learns what dialogues have come to.
    pub(in crate::app) fn follow_dialogues(&mut self) {
        for question in std::mem::take(&mut self.questions) {
            let Asked::Dialogue(answer, since) = &question.asked else {
                self.questions.push(question);
                continue;
            };
            match answer.try_recv() {
                Ok(Some(path)) => self.take_path(question.purpose, path),
                Ok(None) if since.elapsed() < SOONEST => {
                    self.has_dialogues = false;
                    self.ask(question.purpose);
                }
                Ok(None) | Err(TryRecvError::Disconnected) => {}
                Err(TryRecvError::Empty) => self.questions.push(question),
            }
        }
    }

    /// Does what a path was asked for.
    fn take_path(&mut self, purpose: Purpose, path: PathBuf) {
        match purpose {
            Purpose::Open => self.open_file(&path),
            Purpose::Environment => self.light(Opening { environment: Some(path), ..self.opened.clone() }),
            Purpose::Save { make, .. } => self.saves.push(files::write(path, make, self.window.clone())),
            Purpose::Task(task) => self.send_errand(task, &path),
        }
    }

    /// Shows the first question that is asked in the window.
    pub(in crate::app) fn show_question(&mut self, ctx: &Context) {
        let is_here = |question: &Question| matches!(question.asked, Asked::Window { .. });
        let Some(index) = self.questions.iter().position(is_here) else { return };
        let question = &mut self.questions[index];
        let window = Window::new(question.purpose.title()).collapsible(false).resizable(false);
        let width = (ctx.content_rect().width() - 40.0).clamp(120.0, 460.0);
        let window = window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).default_width(width).max_width(width);
        match window.show(ctx, |ui| question.show(ui, width)).and_then(|shown| shown.inner).unwrap_or(Answer::None) {
            Answer::None => {}
            Answer::Cancel => drop(self.questions.remove(index)),
            Answer::Path(path) => {
                let question = self.questions.remove(index);
                self.take_path(question.purpose, path);
            }
        }
    }
}
