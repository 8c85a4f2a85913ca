//! `catoptric view`: starts the viewer.

use crate::args::ViewerArgs;
use crate::failure::{Failure, Output};
use std::env::{self, consts::EXE_SUFFIX};
use std::path::PathBuf;
use std::process::Command;

const NAME: &str = "catoptric_viewer";
/// The variable that names the viewer's file.
const VARIABLE: &str = "CATOPTRIC_VIEWER";
const REMEDY: &str = "build it with `cargo build --release --locked -p catoptric_viewer`, or install it with \
                      `cargo install --path crates/catoptric_viewer`";

pub(crate) fn run(args: &ViewerArgs) -> Result<Output, Failure> {
    let program = find()?;
    let words = args.words.iter().skip_while(|word| *word == "--");
    let mut viewer = Command::new(&program);
    // The viewer's help names what was typed.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::arg0(&mut viewer, "catoptric view");
    let ended = viewer.args(words).status();
    let ended = ended.map_err(|error| Failure::input(format!("{}: cannot start it: {error}", program.display())))?;
    let code = ended.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1);
    Ok(Output { text: String::new(), code })
}

/// The file that the variable names, else the one beside this program, else the first on `PATH`.
fn find() -> Result<PathBuf, Failure> {
    if let Some(named) = env::var_os(VARIABLE) {
        let named = PathBuf::from(named);
        let problem = || format!("{VARIABLE}={}: there is no such file; {REMEDY}", named.display());
        return named.is_file().then(|| named.clone()).ok_or_else(|| Failure::input(problem()));
    }
    let own = env::current_exe().ok().and_then(|own| Some(own.parent()?.to_owned()));
    let path = env::var_os("PATH").unwrap_or_default();
    // Never from the folder that the program happens to run in.
    let folders = own.into_iter().chain(env::split_paths(&path).filter(|folder| folder.is_absolute()));
    let found = folders.map(|folder| folder.join(format!("{NAME}{EXE_SUFFIX}"))).find(|file| file.is_file());
    let problem = || Failure::input(format!("the viewer {NAME} is neither beside this program nor on PATH: {REMEDY}"));
    found.ok_or_else(problem)
}
