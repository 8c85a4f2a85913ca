//! The command lines of `catoptric diff`, `explain` and `view`, and of commands that print alone.

use crate::parse;
use clap::{Args, ValueHint};
use std::ffi::OsString;
use std::path::PathBuf;

#[derive(Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct JsonArgs {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct DiffArgs {
    /// The picture to be measured: .png or .exr
    #[arg(value_name = "A", value_parser = parse::file(), value_hint = ValueHint::FilePath, help_heading = "Pictures")]
    #[arg(display_order = 0)]
    pub(crate) test: PathBuf,
    /// The picture that it is measured against, of the same size
    #[arg(value_name = "B", value_parser = parse::file(), value_hint = ValueHint::FilePath, help_heading = "Pictures")]
    #[arg(display_order = 1)]
    pub(crate) reference: PathBuf,
    /// Write a picture of where they differ: FLIP from black over purple and orange to yellow (.png)
    #[arg(long, short, value_name = "FILE", value_parser = parse::png_path(), value_hint = ValueHint::FilePath)]
    #[arg(help_heading = "Output")]
    pub(crate) output: Option<PathBuf>,
    /// End with exit code 3 if the mean of FLIP, 0 to 1, is greater than this
    #[arg(long, value_name = "X", value_parser = parse::share, help_heading = "Output")]
    pub(crate) max_flip: Option<f64>,
    #[command(flatten)]
    pub(crate) format: JsonArgs,
}

#[derive(Args)]
pub(crate) struct ExplainArgs {
    /// The method; `catoptric methods` lists them
    #[arg(value_name = "METHOD", help_heading = "Method")]
    pub(crate) method: String,
    #[command(flatten)]
    pub(crate) format: JsonArgs,
}

#[derive(Args)]
pub(crate) struct ViewerArgs {
    /// A scene, and options of the viewer: `catoptric view -- --help` lists them
    #[arg(
        value_name = "SCENE or OPTION",
        trailing_var_arg = true,
        allow_hyphen_values = true,
        help_heading = "Viewer"
    )]
    pub(crate) words: Vec<OsString>,
}
