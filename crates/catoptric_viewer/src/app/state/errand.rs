//! A program at work beside the window, in a process of its own. The window waits for nothing of it.

use eframe::egui::Context;
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::Instant;
use tempfile::TempDir;

/// The answer of a program of the window's version to `--version`.
const VERSION: &str = concat!("catoptric ", env!("CARGO_PKG_VERSION"));

/// The kinds of errands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::app) enum Task {
    /// A comparison of the shown picture with the reference: a folder with a page.
    Report,
    /// The left side's precomputation.
    Bake,
}

/// A program at work.
pub(in crate::app) struct Errand {
    pub(in crate::app) task: Task,
    /// The file or folder that it makes.
    pub(in crate::app) target: PathBuf,
    program: Child,
    /// Holds the scene file that it reads.
    _folder: TempDir,
    lines: Receiver<String>,
    /// Reads these; returns what is to be said of the program if it has failed. Taken then.
    reader: Option<JoinHandle<Option<String>>>,
    /// The present stage and its share.
    pub(in crate::app) stage: (String, Option<f32>),
    /// The last words that are no progress.
    last_words: String,
    pub(in crate::app) since: Instant,
    is_called_off: bool,
}

/// A line of progress, as the program prints them.
#[derive(serde::Deserialize)]
struct Line {
    subject: String,
    stage: String,
    done: u64,
    of: u64,
}

impl Task {
    pub(in crate::app) fn word(self) -> &'static str {
        match self {
            Self::Report => "report:",
            Self::Bake => "bake:",
        }
    }
}

impl Errand {
    /// Starts the program with some words; `folder` holds what it reads.
    ///
    /// # Errors
    /// Programs that cannot be started.
    pub(in crate::app) fn begin(
        task: Task,
        target: &Path,
        program: &Path,
        (folder, mut words): (TempDir, Vec<OsString>),
        window: Option<Context>,
    ) -> Result<Self, String> {
        words.push("--progress=lines".into());
        let file = program.to_path_buf();
        let mut program = niced(program)
            .args(words)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{}: {error}", program.display()))?;
        let (sender, lines) = channel();
        let said = program.stderr.take();
        let reader = std::thread::spawn(move || {
            let wake_up = || window.iter().for_each(Context::request_repaint);
            said.into_iter().for_each(|said| read_lines(BufReader::new(said), &sender, wake_up));
            let remark = other_version(&file);
            // The end of lines is the end of all.
            drop(sender);
            wake_up();
            remark
        });
        let (stage, since, is_called_off) = ((String::new(), None), Instant::now(), false);
        let (target, last_words, reader) = (target.to_path_buf(), String::new(), Some(reader));
        Ok(Self { task, target, program, _folder: folder, lines, reader, stage, last_words, since, is_called_off })
    }

    /// How it has ended, with a remark or a problem; `None` while it goes on.
    pub(in crate::app) fn end(&mut self) -> Option<Result<String, String>> {
        loop {
            match self.lines.try_recv() {
                Ok(line) => match serde_json::from_str(&line) {
                    Ok(Line { subject, stage, done, of }) => {
                        let share = (of > 0).then(|| done as f32 / of as f32);
                        self.stage = (format!("{subject} {stage}"), share);
                    }
                    // Units of bakes are told in JSON, too.
                    Err(_) if line.starts_with('{') => {}
                    Err(_) => self.last_words = line,
                },
                Err(TryRecvError::Empty) => return None,
                // Nothing is said after the end.
                Err(TryRecvError::Disconnected) => break,
            }
        }
        let code = match self.program.try_wait() {
            Ok(None) => return None,
            Ok(Some(status)) => status.code(),
            Err(error) => return Some(Err(format!("{} {error}", self.task.word()))),
        };
        let words = self.last_words.trim_start_matches("error: ");
        Some(match (self.task, code) {
            _ if self.is_called_off => Err(format!("{} stopped", self.task.word())),
            (_, Some(0)) => Ok(String::new()),
            // Some method has failed; the report says why.
            (Task::Report, Some(1)) if self.target.join("report.html").is_file() => Ok(format!("; {words}")),
            _ => {
                let remark = self.reader.take().and_then(|reader| reader.join().ok()).flatten();
                Err(format!("{} {words}{}", self.task.word(), remark.unwrap_or_default()))
            }
        })
    }

    /// Ends it, with time to tidy up where the system knows how to ask for that.
    pub(in crate::app) fn call_off(&mut self) {
        self.is_called_off = true;
        #[cfg(unix)]
        if let Some(id) = i32::try_from(self.program.id()).ok().and_then(rustix::process::Pid::from_raw) {
            // The program may have ended by itself.
            let _ = rustix::process::kill_process(id, rustix::process::Signal::TERM);
        }
        #[cfg(not(unix))]
        let _ = self.program.kill();
    }
}

impl Drop for Errand {
    fn drop(&mut self) {
        // Nobody would hear of it any more.
        if let Ok(None) = self.program.try_wait() {
            self.call_off();
        }
    }
}

/// A command of low priority, where there are such: drawing comes first.
fn niced(program: &Path) -> Command {
    let has_nice = cfg!(unix) && Path::new("/usr/bin/nice").is_file();
    if !has_nice {
        return Command::new(program);
    }
    let mut command = Command::new("/usr/bin/nice");
    command.arg("-n").arg("10").arg(program);
    command
}

/// Hands lines on until there are no more, and wakes the window up for each.
fn read_lines(lines: impl BufRead, sender: &Sender<String>, wake_up: impl Fn()) {
    for line in lines.lines().map_while(Result::ok) {
        if sender.send(line).is_err() {
            return;
        }
        wake_up();
    }
}

/// Returns a remark about a program that is not of the window's version.
fn other_version(program: &Path) -> Option<String> {
    let answer = Command::new(program).arg("--version").stdin(Stdio::null()).output();
    let is_same = answer.is_ok_and(|answer| answer.stdout.trim_ascii() == VERSION.as_bytes());
    (!is_same).then(|| format!("; {} is not `{VERSION}`, which belongs to this viewer", program.display()))
}
