//! Where the points of `project` come from.

use super::FileOrStream;
use clap::builder::{PathBufValueParser, TypedValueParser};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The extensions of files with one JSON object a line.
pub(crate) const JSON_LINES: [&str; 2] = ["jsonl", "ndjson"];

/// A table, or a grid on the surfaces of objects.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PointSource {
    Table(FileOrStream),
    Grid(Grid),
}

impl PointSource {
    /// The table's path; `None` for a grid and for standard input.
    pub(crate) fn path(&self) -> Option<&Path> {
        match self {
            Self::Table(table) => table.path(),
            Self::Grid(_) => None,
        }
    }
}

/// A grid as it is asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grid {
    /// The name or glob of nodes or materials.
    pub(crate) node: String,
    /// The distance of neighbouring points along two axes of the world, in scene units.
    pub(crate) step: f64,
}

impl Grid {
    /// The word before a grid in place of a file.
    pub(crate) const PREFIX: &str = "grid:";
}

impl FromStr for Grid {
    type Err = String;

    /// Reads `NODE:STEP`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (node, step) = text.rsplit_once(':').ok_or("write a grid as grid:NODE:STEP, such as grid:board:0.01")?;
        let step = step.parse().ok().filter(|step: &f64| (1e-9..=1e9).contains(step));
        let step =
            step.ok_or("the step of a grid must be a number from 1e-9 to 1e9, in scene units: grid:NODE:STEP")?;
        Ok(Self { node: node.to_owned(), step })
    }
}

/// Reads the name of a table.
pub(crate) fn table_path() -> impl TypedValueParser<Value = FileOrStream> {
    PathBufValueParser::new().try_map(table)
}

/// Reads the name of a table, or a grid.
pub(crate) fn points() -> impl TypedValueParser<Value = PointSource> {
    PathBufValueParser::new().try_map(|path| match path.to_str().and_then(|text| text.strip_prefix(Grid::PREFIX)) {
        Some(grid) => grid.parse().map(PointSource::Grid),
        None => table(path).map(PointSource::Table),
    })
}

/// Reads the name of a camera's file.
pub(crate) fn camera_path() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match is_camera(&path) {
        true => Ok(path),
        false => Err("the name must end in .json"),
    })
}

/// True for names of cameras' files.
pub(crate) fn is_camera(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"))
}

pub(super) fn table(path: PathBuf) -> Result<FileOrStream, String> {
    let table = FileOrStream::from(path);
    let is_known = |extension: &&str| table.has_extension(extension);
    match table == FileOrStream::Stream || ["csv", "npy"].iter().chain(&JSON_LINES).any(is_known) {
        true => Ok(table),
        false => Err("the name must end in .csv, .npy or .jsonl, or be `-`".into()),
    }
}
