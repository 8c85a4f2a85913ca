//! Rows of found paths, as text or as an array.

use super::npy::RowWriter;
use crate::failure::text::{MOST_OF_NAME, begins_formula};
use crate::parse::FileOrStream;
use catoptric::methods::path_query::FoundPath;
use catoptric::methods::projector::SpecularPath;
use catoptric::scene::Scene;
use glam::{DVec2, DVec3};
use std::fmt::Write as _;
use std::io::{self, Seek, Write};

/// The columns of the output, and the writer of its rows.
pub(super) struct Table {
    format: Format,
    order: usize,
    jacobian: bool,
    /// Kinds and names of each path.
    paths: Vec<[String; 2]>,
    /// The longest names, in bytes.
    names_width: usize,
    /// Where the scene's origin lies in the coordinates of its file.
    origin: DVec3,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Csv,
    Npy,
}

/// A path that was found.
pub(super) struct Row<'a> {
    /// The point's row in the input.
    pub(super) point: u64,
    pub(super) path: &'a FoundPath,
    pub(super) image: Option<DVec2>,
}

/// A value of a row.
enum Cell<'a> {
    Whole(u64),
    Number(f64),
    /// Text, and its width in arrays.
    Text(&'a str, usize),
    Empty,
}

impl Table {
    pub(super) fn new(
        output: &FileOrStream,
        paths: &[SpecularPath],
        scene: &Scene,
        order: usize,
        jacobian: bool,
    ) -> Self {
        let format = if output.has_extension("npy") { Format::Npy } else { Format::Csv };
        let names = |path: &SpecularPath| match format {
            Format::Csv => path.names(scene),
            Format::Npy => cut(path.names(scene), MOST_OF_NAME * order),
        };
        let paths: Vec<[String; 2]> = paths.iter().map(|path| [path.kinds(), names(path)]).collect();
        let names_width = paths.iter().map(|[_, names]| names.len()).max().unwrap_or(0).max(1);
        Self { format, order, jacobian, paths, names_width, origin: scene.origin }
    }

    /// The names of the columns.
    fn columns(&self) -> Vec<String> {
        let mut names: Vec<String> =
            ["point", "kinds", "path", "focal_index", "path_length", "residual", "image_x", "image_y"]
                .map(String::from)
                .to_vec();
        names.extend((1..=self.order).flat_map(|bounce| ["x", "y", "z"].map(|axis| format!("{axis}{bounce}"))));
        if self.jacobian {
            names.extend((1..=3).flat_map(|row| (1..=3).map(move |column| format!("j{row}{column}"))));
        }
        names
    }

    /// Calls `cell` for every cell of a row.
    fn cells(&self, row: &Row<'_>, mut cell: impl FnMut(Cell<'_>)) {
        let path = row.path;
        let [kinds, names] = &self.paths[path.path as usize];
        cell(Cell::Whole(row.point));
        cell(Cell::Text(kinds, self.order));
        cell(Cell::Text(names, self.names_width));
        cell(Cell::Whole(path.focal_index.into()));
        cell(Cell::Number(path.optical_length));
        cell(Cell::Number(path.residual));
        for coordinate in row.image.map_or([None; 2], |image| image.to_array().map(Some)) {
            cell(coordinate.map_or(Cell::Empty, Cell::Number));
        }
        for (index, at) in path.bounce_points[..self.order].iter().enumerate() {
            for coordinate in (*at + self.origin).to_array() {
                cell(if index < path.bounce_count { Cell::Number(coordinate) } else { Cell::Empty });
            }
        }
        if self.jacobian {
            for row in path.jacobian.transpose().to_cols_array() {
                cell(Cell::Number(row));
            }
        }
    }

    /// An empty list of rows.
    pub(super) fn rows(&self) -> Rows<'_> {
        let text = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        Rows { table: self, text, number: String::new(), array: Vec::new() }
    }

    /// Starts the file.
    pub(super) fn begin<W: Write + Seek>(&self, mut writer: W) -> io::Result<Sink<W>> {
        match self.format {
            Format::Csv => {
                let mut header = csv::Writer::from_writer(&mut writer);
                header.write_record(self.columns())?;
                header.flush()?;
                drop(header);
                Ok(Sink::Csv(writer))
            }
            Format::Npy => {
                let column = |name: String| {
                    let (kind, bytes) = match name.as_str() {
                        "point" | "focal_index" => ("<u8".to_owned(), 8),
                        "kinds" => (format!("|S{}", self.order), self.order),
                        "path" => (format!("|S{}", self.names_width), self.names_width),
                        _ => ("<f8".to_owned(), 8),
                    };
                    (name, kind, bytes)
                };
                let columns: Vec<_> = self.columns().into_iter().map(column).collect();
                Ok(Sink::Npy(RowWriter::new(writer, &columns)?))
            }
        }
    }
}

/// Rows that wait to be written.
pub(super) struct Rows<'a> {
    table: &'a Table,
    text: csv::Writer<Vec<u8>>,
    number: String,
    array: Vec<u8>,
}

impl Rows<'_> {
    pub(super) fn push(&mut self, row: &Row<'_>) {
        let Self { table, text, number, array } = self;
        match table.format {
            // Writing into memory does not fail.
            Format::Csv => {
                table.cells(row, |cell| {
                    number.clear();
                    let cell = match cell {
                        Cell::Text(text, _) if begins_formula(text) => {
                            let _ = write!(number, "'{text}");
                            number.as_str()
                        }
                        Cell::Text(text, _) => text,
                        Cell::Whole(value) => {
                            let _ = write!(number, "{value}");
                            number.as_str()
                        }
                        // The shortest text that reads as the same number.
                        Cell::Number(value) => {
                            let _ = write!(number, "{value:?}");
                            number.as_str()
                        }
                        Cell::Empty => "",
                    };
                    let _ = text.write_field(cell);
                });
                let _ = text.write_record(None::<&[u8]>);
            }
            Format::Npy => table.cells(row, |cell| match cell {
                Cell::Whole(value) => array.extend(value.to_le_bytes()),
                Cell::Number(value) => array.extend(value.to_le_bytes()),
                Cell::Empty => array.extend(f64::NAN.to_le_bytes()),
                Cell::Text(text, width) => {
                    let end = array.len() + width;
                    array.extend(&text.as_bytes()[..text.len().min(width)]);
                    array.resize(end, 0);
                }
            }),
        }
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        match self.table.format {
            Format::Csv => self.text.into_inner().unwrap_or_default(),
            Format::Npy => self.array,
        }
    }
}

/// Text of at most so many bytes: every row of an array has room for the longest.
fn cut(mut text: String, most: usize) -> String {
    let end = (0..=most.min(text.len())).rev().find(|end| text.is_char_boundary(*end));
    text.truncate(end.unwrap_or(0));
    text
}

/// The file that is being written.
pub(super) enum Sink<W: Write + Seek> {
    Csv(W),
    Npy(RowWriter<W>),
}

impl<W: Write + Seek> Sink<W> {
    pub(super) fn write(&mut self, rows: &[u8]) -> io::Result<()> {
        match self {
            Self::Csv(writer) => writer.write_all(rows),
            Self::Npy(writer) => writer.write(rows),
        }
    }

    pub(super) fn finish(self) -> io::Result<()> {
        match self {
            Self::Csv(mut writer) => writer.flush(),
            Self::Npy(writer) => writer.finish(),
        }
    }
}
