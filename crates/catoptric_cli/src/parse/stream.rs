//! The word `-` in the place of a file: standard input or output.

use crate::failure::{self, Failure};
use catoptric::output;
use catoptric_options::parse::{STREAM, no_stream};
use clap::builder::{PathBufValueParser, StringValueParser, TypedValueParser};
use std::fs::File;
use std::io::{self, BufWriter, Seek};
use std::path::{Path, PathBuf};

/// A file, or a standard stream: standard input of what is read, standard output of what is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FileOrStream {
    File(PathBuf),
    Stream,
}

impl From<PathBuf> for FileOrStream {
    fn from(path: PathBuf) -> Self {
        if path.as_os_str() == STREAM { Self::Stream } else { Self::File(path) }
    }
}

impl FileOrStream {
    /// The file's path; `None` for a standard stream.
    pub(crate) fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Stream => None,
        }
    }

    /// True for files whose names end so, in letters of either case.
    pub(crate) fn has_extension(&self, wanted: &str) -> bool {
        self.path().and_then(Path::extension).is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
    }

    /// Name in messages about an output.
    pub(crate) fn output_name(&self) -> String {
        self.path().map_or("standard output".into(), |path| path.display().to_string())
    }

    /// Name in messages about an input.
    pub(crate) fn input_name(&self) -> String {
        self.path().map_or("standard input".into(), |path| path.display().to_string())
    }

    /// True if two outputs are one file, or both standard output.
    pub(crate) fn is_same_output(&self, other: &Self) -> bool {
        match (self.path(), other.path()) {
            (Some(one), Some(other)) => output::is_same_file(one, other),
            (one, other) => one == other,
        }
    }

    /// Writes the output through `fill`: whole, or not at all when something fails.
    pub(crate) fn write(&self, fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> Result<(), Failure> {
        match self {
            Self::File(path) => Ok(output::write_file(path, fill)?),
            Self::Stream => failure::written(output::write_stream(&mut io::stdout().lock(), fill)),
        }
    }

    /// Opens the input; standard input is first copied into a nameless file, which can be read twice.
    pub(crate) fn open(&self) -> io::Result<File> {
        let Self::File(path) = self else {
            let mut file = tempfile::tempfile()?;
            io::copy(&mut io::stdin().lock(), &mut file)?;
            file.rewind()?;
            return Ok(file);
        };
        File::open(path)
    }
}

/// Reads a file, or `-` for standard output.
pub(crate) fn file_or_stream() -> impl TypedValueParser<Value = FileOrStream> {
    PathBufValueParser::new().map(FileOrStream::from)
}

/// Reads the place of a bake, which may be an address.
pub(crate) fn place() -> impl TypedValueParser<Value = String> {
    StringValueParser::new().try_map(no_stream)
}
