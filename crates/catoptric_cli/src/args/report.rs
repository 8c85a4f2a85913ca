//! The command line of the report that `catoptric compare` writes.

use crate::parse::{self, Region};
use clap::{Args, ValueHint};
use std::path::PathBuf;

#[derive(Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct ReportArgs {
    /// Folder for the report: report.html, one file with all pictures inside, and report.json; created if absent
    #[arg(long, value_name = "DIR", value_parser = parse::file())]
    pub(crate) report: PathBuf,
    /// Also write the pictures, the maps of differences and the plot as files of their own, beside the page
    #[arg(long)]
    pub(crate) pictures: bool,
    /// Also show this part of all pictures side by side, enlarged: the left top corner and the size, in pixels. With
    /// --pictures it is the file crop.png, too, in the page's order
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse::region)]
    pub(crate) crop: Option<Region>,
    /// Write the table to this file as comma-separated values, with all digits
    #[arg(long, value_name = "FILE", value_parser = parse::file(), value_hint = ValueHint::FilePath)]
    pub(crate) csv: Option<PathBuf>,
    /// Write the table to this file as a LaTeX tabular, rounded as in the page; it needs no package
    #[arg(long, value_name = "FILE", value_parser = parse::file(), value_hint = ValueHint::FilePath)]
    pub(crate) latex: Option<PathBuf>,
}
