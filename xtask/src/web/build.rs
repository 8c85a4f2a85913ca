//! Builds the folder.

use crate::command::{root, run};
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where the program is compiled to.
pub(crate) const TARGET: &str = "wasm32-unknown-unknown";

/// Compiles the viewer and puts it with its page into `dist`, which is returned.
pub(super) fn build() -> Result<PathBuf> {
    let tool = bindgen()?;
    // All browsers of the last years have these instructions.
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--locked", "-p", "catoptric_viewer", "--profile", "web", "--target", TARGET]);
    run(cargo.env("RUSTFLAGS", "-C target-feature=+simd128"))
        .context("the viewer cannot be built (`rustup target add wasm32-unknown-unknown` is needed once)")?;
    let dist = dist();
    if dist.exists() {
        std::fs::remove_dir_all(&dist).with_context(|| format!("cannot remove {}", dist.display()))?;
    }
    copy(&root().join("crates/catoptric_viewer/web"), &dist)?;
    let program = target().join(TARGET).join("web/catoptric_viewer.wasm");
    let words = ["--target", "web", "--no-typescript", "--remove-name-section", "--remove-producers-section"];
    run(Command::new(tool).args(words).arg("--out-dir").arg(&dist).arg(program))?;
    println!("{}", dist.display());
    Ok(dist)
}

/// The folder of the files.
fn dist() -> PathBuf {
    root().join("dist")
}

/// The folder of compiled things.
fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// wasm-bindgen's tool in the version of its library, installed if it is not there.
fn bindgen() -> Result<PathBuf> {
    let lock = std::fs::read_to_string(root().join("Cargo.lock")).context("cannot read Cargo.lock")?;
    let after = lock.split_once("name = \"wasm-bindgen\"\nversion = \"").map(|(_, after)| after);
    let Some((version, _)) = after.and_then(|after| after.split_once('"')) else {
        bail!("Cargo.lock names no wasm-bindgen");
    };
    let folder = target().join("tools").join(format!("wasm-bindgen-{version}"));
    let tool = folder.join("bin").join(format!("wasm-bindgen{}", std::env::consts::EXE_SUFFIX));
    if !tool.exists() {
        let words = ["install", "wasm-bindgen-cli", "--version", version, "--no-default-features", "--root"];
        run(Command::new(env!("CARGO")).args(words).arg(&folder))?;
    }
    Ok(tool)
}

/// Copies a folder with everything in it.
fn copy(from: &Path, to: &Path) -> Result<()> {
    std::fs::create_dir_all(to).with_context(|| format!("cannot make {}", to.display()))?;
    for entry in std::fs::read_dir(from).with_context(|| format!("cannot read {}", from.display()))? {
        let entry = entry?;
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy(&path, &target)?;
        } else {
            std::fs::copy(&path, &target).with_context(|| format!("cannot write {}", target.display()))?;
        }
    }
    Ok(())
}
