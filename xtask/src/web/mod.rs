//! The viewer as a folder of static files, served and tested.

mod build;
mod chromium;
mod serve;
mod test;

pub(crate) use build::TARGET;
pub(crate) use chromium::installed;

use anyhow::{Result, bail};

/// Runs `cargo xtask web ...`.
pub(crate) fn run(words: &[&str]) -> Result<()> {
    match *words {
        [] => build::build().map(drop),
        ["--serve"] => serve::serve(&build::build()?, serve::PORT),
        ["--serve", port] => match port.parse() {
            Ok(port) => serve::serve(&build::build()?, port),
            Err(_) => bail!("--serve {port}: a port is a number up to 65535"),
        },
        ["--test", ref rest @ ..] => test::run(rest),
        _ => bail!("`web` takes nothing, --serve [PORT] or --test [FOLDER [WORD]] [--graphics KIND]"),
    }
}
