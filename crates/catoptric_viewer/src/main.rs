//! The program `catoptric_viewer`: a scene in a window, or in a page.

#[cfg(not(target_family = "wasm"))]
mod native;
#[cfg(target_family = "wasm")]
mod web;

#[cfg(not(target_family = "wasm"))]
fn main() -> std::process::ExitCode {
    native::main()
}

/// The page and its worker call what they need.
#[cfg(target_family = "wasm")]
fn main() {}
