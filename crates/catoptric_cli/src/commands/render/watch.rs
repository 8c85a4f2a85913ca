//! `catoptric render --watch`: the picture again whenever files of the scene change.

use super::inputs::{files_of, of_render, stamp_of};
use crate::args::RenderArgs;
use crate::failure::{Failure, written};
use crate::parse::FileOrStream;
use crate::scene_source::built_in;
use crate::terminal::Terminal;
use clap::ArgMatches;
use std::io::Write;
use std::thread::sleep;
use std::time::Duration;

/// Files are looked at so often.
const INTERVAL: Duration = Duration::from_millis(300);
/// Draws, and draws again after every change, until a signal ends the program.
pub(crate) fn run(args: &RenderArgs, options: &ArgMatches, terminal: &Terminal) -> Result<String, Failure> {
    if built_in(&args.scene.scene).is_some() {
        return Err(Failure::usage(format!("--watch: {} is no file that could change", args.scene.scene.display())));
    }
    if args.output == FileOrStream::Stream {
        return Err(Failure::usage("--watch: -o - has room for one picture; name a file"));
    }
    loop {
        // Before the picture: what changes while it is drawn is not missed.
        let before = files_of(of_render(args));
        match super::run(args, options, terminal) {
            Ok(text) => {
                let mut stdout = std::io::stdout().lock();
                written(stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()))?;
            }
            Err(failure @ Failure::Usage(_)) => return Err(failure),
            // The next change may mend it.
            Err(failure @ Failure::Input(_)) => {
                failure.report();
            }
        }
        let count = before.len();
        terminal.say(&format!("watching {count} file{}; Ctrl-C ends", if count == 1 { "" } else { "s" }));
        while before.iter().all(|(path, stamp)| stamp_of(path) == *stamp) {
            sleep(INTERVAL);
        }
    }
}
