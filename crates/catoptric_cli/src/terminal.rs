//! Messages of the program while it works.

use crate::args::{Global, ProgressChoice};
use crate::failure::{self, text};
use crate::parse::FileOrStream;
use catoptric::progress::{Cancelled, Progress};
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::HashSet;
use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Work that is over sooner shows no bar.
const PATIENCE: Duration = Duration::from_secs(2);
/// The time between lines of progress.
const BETWEEN_LINES: Duration = Duration::from_millis(100);
/// More warnings than this are counted, not printed, without `--verbose`.
const MAX_WARNINGS: usize = 12;

/// Messages and progress on standard error.
pub(crate) struct Terminal {
    quiet: bool,
    pub(crate) verbose: bool,
    bars: bool,
    lines: bool,
    start: Instant,
    stage: Mutex<Stage>,
}

#[derive(Default)]
struct Stage {
    /// The subject of the stages, such as a method.
    subject: String,
    name: String,
    bar: Option<ProgressBar>,
    /// When the last line was printed.
    last_line: Option<Instant>,
}

impl Terminal {
    pub(crate) fn new(global: &Global) -> Self {
        let lines = global.progress == ProgressChoice::Lines;
        Self {
            quiet: global.quiet,
            verbose: global.verbose > 0,
            bars: !global.quiet && !lines && std::io::stderr().is_terminal(),
            lines,
            start: Instant::now(),
            stage: Mutex::default(),
        }
    }

    /// A line for the user on standard output, unless only errors are wanted.
    pub(crate) fn unless_quiet(&self, line: String) -> String {
        if self.quiet { String::new() } else { line }
    }

    /// The closing lines of a command: for standard output, or on standard error where an output went to the former.
    pub(crate) fn closing(&self, lines: String, outputs: &[FileOrStream]) -> String {
        if !outputs.contains(&FileOrStream::Stream) {
            return self.unless_quiet(lines);
        }
        self.say(lines.trim_end());
        String::new()
    }

    /// Says errors that do not end the work, even when quiet.
    pub(crate) fn errors(&self, errors: &[String]) {
        for error in errors {
            failure::say(format_args!("error: {}", text::one_line(error)));
        }
    }

    /// A line for the user on standard error, unless only errors are wanted.
    pub(crate) fn say(&self, line: &str) {
        if !self.quiet {
            failure::say(text::printable(line));
        }
    }

    /// The same above the progress bar, where one is shown.
    pub(crate) fn say_above(&self, line: &str) {
        match self.stage.lock().ok().and_then(|stage| stage.bar.clone()) {
            Some(bar) if !self.quiet => bar.println(text::printable(line)),
            _ => self.say(line),
        }
    }

    /// Prints a value as a line of JSON on standard error, if lines are wanted; returns false if not.
    pub(crate) fn tell(&self, value: &impl serde::Serialize) -> bool {
        match serde_json::to_string(value) {
            Ok(line) if self.lines => failure::say(text::printable_json(line)),
            _ => return false,
        }
        true
    }

    /// Prints each warning once.
    pub(crate) fn warn<'a>(&self, warnings: impl IntoIterator<Item = &'a String>) {
        if self.quiet {
            return;
        }
        let mut seen = HashSet::new();
        let distinct: Vec<&String> = warnings.into_iter().filter(|warning| seen.insert(warning.as_str())).collect();
        let shown = if self.verbose { distinct.len() } else { MAX_WARNINGS.min(distinct.len()) };
        for warning in &distinct[..shown] {
            failure::say(format_args!("warning: {}", text::one_line(warning)));
        }
        if shown < distinct.len() {
            failure::say(format_args!("warning: {} more; -v shows them", distinct.len() - shown));
        }
    }

    /// Names what the next stages belong to.
    pub(crate) fn set_subject(&self, subject: &str) {
        if let Ok(mut stage) = self.stage.lock() {
            stage.subject = subject.into();
        }
    }
}

impl Terminal {
    /// Shows a stage's bar, or removes it when the stage is complete.
    fn show(&self, stage: &mut Stage, name: &str, done: u64, of: u64) {
        if stage.name != name || (of > 0 && done >= of) {
            stage.clear();
        }
        if of > 0 && done >= of {
            return;
        }
        stage.name.replace_range(.., name);
        let message = format!("{} {name}", stage.subject).trim().to_owned();
        let bar = stage.bar.get_or_insert_with(|| {
            let (bar, template) = match of {
                // The number of steps is unknown.
                0 => (ProgressBar::new_spinner(), "{msg} {spinner} {pos} steps, {elapsed}"),
                _ => (ProgressBar::new(of), "{msg} {wide_bar} {percent:>3} % {eta} left"),
            };
            let bar = bar.with_message(message);
            match ProgressStyle::with_template(template) {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            }
        });
        bar.set_position(done);
    }
}

impl Stage {
    /// Prints how far a stage is, if the last line is some time ago or was about another one.
    fn print_line(&mut self, name: &str, done: u64, of: u64) {
        let is_due = self.last_line.is_none_or(|last| last.elapsed() >= BETWEEN_LINES);
        if is_due || self.name != name {
            self.name.replace_range(.., name);
            self.last_line = Some(Instant::now());
            let line = serde_json::json!({ "subject": self.subject, "stage": name, "done": done, "of": of });
            failure::say(text::printable_json(line.to_string()));
        }
    }

    fn clear(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Progress for Terminal {
    fn at(&self, name: &str, done: u64, of: u64) -> Result<(), Cancelled> {
        let shows_bar = self.bars && self.start.elapsed() >= PATIENCE;
        if shows_bar || self.lines {
            // Whoever cannot have the lock now leaves the drawing to the next one: workers must not wait for a
            // terminal.
            if let Ok(mut stage) = self.stage.try_lock() {
                match self.lines {
                    true => stage.print_line(name, done, of),
                    false => self.show(&mut stage, name, done, of),
                }
            }
        }
        Ok(())
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        if let Ok(stage) = self.stage.get_mut() {
            stage.clear();
        }
    }
}
