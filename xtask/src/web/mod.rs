//! The viewer as a folder of static files, served and tested.
#![expect(clippy::print_stdout, reason = "what chores have come to is printed")]

mod build;
mod chromium;
mod serve;
mod test;

use anyhow::{Result, bail};
use std::path::{Path, PathBuf};

/// What `cargo run -p xtask -- web ...` asks for.
pub(crate) fn run(words: &[String]) -> Result<()> {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        [] => build::build().map(drop),
        ["--serve"] => serve::serve(&build::build()?, serve::PORT),
        ["--serve", port] => match port.parse() {
            Ok(port) => serve::serve(&build::build()?, port),
            Err(_) => bail!("--serve {port}: a port is a number up to 65535"),
        },
        ["--test"] => test::test(&build::build()?, ""),
        // One that was built before, and the tests whose names have a word.
        ["--test", folder] => test::test(Path::new(folder), ""),
        ["--test", folder, word] => test::test(Path::new(folder), word),
        _ => bail!("`web` takes nothing, --serve [PORT] or --test [FOLDER [WORD]]"),
    }
}

/// The folder of the files.
fn dist() -> PathBuf {
    crate::root().join("dist")
}
