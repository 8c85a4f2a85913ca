//! Rows of found paths: as text, as JSON, or as an array.

use super::npy::RowWriter;
use crate::failure::text::{MOST_OF_NAME, begins_formula};
use crate::parse::{FileOrStream, JSON_LINES};
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
    /// The points' coordinates are columns, too.
    with_points: bool,
    /// Kinds and names of each path; at the end those of the straight line from eye to point, which are empty.
    paths: Vec<[String; 2]>,
    /// The longest names, in bytes.
    names_width: usize,
    /// The names of the scene's objects.
    objects: Vec<String>,
    /// The longest of them, in bytes.
    objects_width: usize,
    /// Where the scene's origin lies in the coordinates of its file.
    origin: DVec3,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Csv,
    JsonLines,
    Npy,
}

/// A path that was found.
pub(super) struct Row<'a> {
    /// The point's row in the input.
    pub(super) point: u64,
    /// The point, in the coordinates of the scene's file.
    pub(super) place: DVec3,
    pub(super) path: &'a FoundPath,
    pub(super) image: Option<DVec2>,
    /// The image is within the picture; `None` without a picture.
    pub(super) in_picture: Option<bool>,
    /// The object that hides the point from the eye along the path.
    pub(super) blocked_by: Option<u32>,
}

/// A value of a row.
enum Cell<'a> {
    Whole(u64),
    Number(f64),
    /// Yes or no, where it may be absent.
    Flag(bool),
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
        [jacobian, with_points]: [bool; 2],
    ) -> Self {
        let format = match output {
            _ if output.has_extension("npy") => Format::Npy,
            _ if JSON_LINES.iter().any(|extension| output.has_extension(extension)) => Format::JsonLines,
            _ => Format::Csv,
        };
        let short = |names: String, count| if format == Format::Npy { cut(names, MOST_OF_NAME * count) } else { names };
        let mut paths: Vec<[String; 2]> =
            paths.iter().map(|path| [path.kinds(), short(path.names(scene), order)]).collect();
        paths.push(Default::default());
        let objects: Vec<String> =
            scene.objects.iter().map(|object| short(SpecularPath::name_in_paths(&object.name), 1)).collect();
        let names_width = paths.iter().map(|[_, names]| names.len()).max().unwrap_or(0).max(1);
        let objects_width = objects.iter().map(String::len).max().unwrap_or(0).max(1);
        let origin = scene.origin;
        Self { format, order, jacobian, with_points, paths, names_width, objects, objects_width, origin }
    }

    /// The index, among paths, of the straight line from eye to point.
    pub(super) fn straight(&self) -> u32 {
        self.paths.len() as u32 - 1
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
        names.extend(["visible", "in_picture", "blocked_by"].map(String::from));
        if self.with_points {
            names.extend(["point_x", "point_y", "point_z"].map(String::from));
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
            for number in path.jacobian.transpose().to_cols_array() {
                cell(if path.bounce_count > 0 { Cell::Number(number) } else { Cell::Empty });
            }
        }
        cell(Cell::Whole(row.blocked_by.is_none().into()));
        cell(row.in_picture.map_or(Cell::Empty, Cell::Flag));
        let blocker = row.blocked_by.map_or("", |object| &self.objects[object as usize]);
        cell(Cell::Text(blocker, self.objects_width));
        if self.with_points {
            row.place.to_array().into_iter().for_each(|coordinate| cell(Cell::Number(coordinate)));
        }
    }

    /// An empty list of rows.
    pub(super) fn rows(&self) -> Rows<'_> {
        let text = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        let columns = if self.format == Format::JsonLines { self.columns() } else { Vec::new() };
        Rows { table: self, columns, text, number: String::new(), array: Vec::new() }
    }

    /// Starts the file.
    pub(super) fn begin<W: Write + Seek>(&self, mut writer: W) -> io::Result<Sink<W>> {
        match self.format {
            Format::Csv => {
                let mut header = csv::Writer::from_writer(&mut writer);
                header.write_record(self.columns())?;
                header.flush()?;
                drop(header);
                Ok(Sink::Text(writer))
            }
            Format::JsonLines => Ok(Sink::Text(writer)),
            Format::Npy => {
                let column = |name: String| {
                    let (kind, bytes) = match name.as_str() {
                        "point" | "focal_index" | "visible" => ("<u8".to_owned(), 8),
                        "kinds" => (format!("|S{}", self.order), self.order),
                        "path" => (format!("|S{}", self.names_width), self.names_width),
                        "blocked_by" => (format!("|S{}", self.objects_width), self.objects_width),
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
    /// The names of the columns, for JSON.
    columns: Vec<String>,
    text: csv::Writer<Vec<u8>>,
    number: String,
    array: Vec<u8>,
}

impl Rows<'_> {
    pub(super) fn push(&mut self, row: &Row<'_>) {
        let Self { table, columns, text, number, array } = self;
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
                        Cell::Flag(flag) => {
                            if flag {
                                "1"
                            } else {
                                "0"
                            }
                        }
                        Cell::Empty => "",
                    };
                    let _ = text.write_field(cell);
                });
                let _ = text.write_record(None::<&[u8]>);
            }
            Format::JsonLines => {
                let mut names = columns.iter();
                table.cells(row, |cell| {
                    let start = if array.last().is_none_or(|byte| *byte == b'\n') { '{' } else { ',' };
                    let name = names.next().map_or("", String::as_str);
                    let _ = write!(array, "{start}\"{name}\":");
                    let _ = match cell {
                        Cell::Whole(value) => write!(array, "{value}"),
                        Cell::Flag(flag) => write!(array, "{}", u8::from(flag)),
                        Cell::Text(text, _) => serde_json::to_writer(&mut *array, text).map_err(io::Error::from),
                        Cell::Number(value) if value.is_finite() => write!(array, "{value:?}"),
                        Cell::Number(_) | Cell::Empty => array.write_all(b"null"),
                    };
                });
                array.extend(b"}\n");
            }
            Format::Npy => table.cells(row, |cell| match cell {
                Cell::Whole(value) => array.extend(value.to_le_bytes()),
                Cell::Number(value) => array.extend(value.to_le_bytes()),
                Cell::Flag(flag) => array.extend(f64::from(u8::from(flag)).to_le_bytes()),
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
            Format::JsonLines | Format::Npy => self.array,
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
    Text(W),
    Npy(RowWriter<W>),
}

impl<W: Write + Seek> Sink<W> {
    pub(super) fn write(&mut self, rows: &[u8]) -> io::Result<()> {
        match self {
            Self::Text(writer) => writer.write_all(rows),
            Self::Npy(writer) => writer.write(rows),
        }
    }

    pub(super) fn finish(self) -> io::Result<()> {
        match self {
            Self::Text(mut writer) => writer.flush(),
            Self::Npy(writer) => writer.finish(),
        }
    }
}
