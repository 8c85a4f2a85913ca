//! Points from files, a part at a time.

use super::npy::Header;
use crate::failure::Failure;
use crate::parse::FileOrStream;
use csv::{ByteRecord, ReaderBuilder, Trim};
use glam::DVec3;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek};

/// Coordinates beyond this are taken for slips, as in scenes: squares of distances must stay finite.
const MAX_COORDINATE: f64 = 1e12;

/// A file of points that is being read.
pub(super) struct Points {
    name: String,
    total_bytes: u64,
    source: Source,
}

enum Source {
    Csv(Box<CsvPoints>),
    Npy(NpyPoints),
}

struct CsvPoints {
    reader: csv::Reader<File>,
    /// The columns of x, y and z.
    columns: [usize; 3],
    record: ByteRecord,
}

struct NpyPoints {
    reader: BufReader<File>,
    kind: NumberKind,
    rows: u64,
    next: u64,
}

/// The storage of a number.
#[derive(Clone, Copy)]
struct NumberKind {
    double: bool,
    big_endian: bool,
}

impl Points {
    /// Opens a `.csv` or `.npy` file, or standard input with CSV, and checks its header.
    pub(super) fn open(input: &FileOrStream) -> Result<Self, Failure> {
        let name = input.input_name();
        let fail = |error: io::Error| Failure::input(format!("{name}: cannot read it: {error}"));
        let file = input.open().map_err(fail)?;
        let metadata = file.metadata().map_err(fail)?;
        if metadata.is_dir() {
            return Err(Failure::input(format!("{name}: cannot read it: it is a folder")));
        }
        let is_array = input.has_extension("npy");
        let source = if is_array { NpyPoints::open(file).map(Source::Npy) } else { CsvPoints::open(file) };
        let source = source.map_err(|problem| Failure::input(format!("{name}: {problem}")))?;
        Ok(Self { name, total_bytes: metadata.len(), source })
    }

    /// The size of the file.
    pub(super) fn total_bytes(&self) -> u64 {
        self.total_bytes
    }

    /// About how much of it has been read.
    pub(super) fn bytes_read(&self) -> u64 {
        match &self.source {
            Source::Csv(csv) => csv.reader.position().byte(),
            Source::Npy(npy) => npy.next * npy.kind.row_bytes() as u64,
        }
    }

    /// The next points, at most `count`; empty at the end.
    pub(super) fn read(&mut self, count: usize) -> Result<Vec<DVec3>, Failure> {
        let mut points = Vec::new();
        while points.len() < count {
            let next = match &mut self.source {
                Source::Csv(csv) => csv.next(),
                Source::Npy(npy) => npy.next(),
            };
            match next {
                Ok(Some(point)) => points.push(point),
                Ok(None) => break,
                Err(problem) => {
                    // Lines are counted only for messages.
                    let line = match &mut self.source {
                        Source::Csv(csv) => csv.line(),
                        Source::Npy(_) => String::new(),
                    };
                    return Err(Failure::input(format!("{}: {line}{problem}", self.name)));
                }
            }
        }
        Ok(points)
    }
}

/// A coordinate that paths can be searched for.
fn checked(value: f64) -> Result<f64, String> {
    if value.abs() <= MAX_COORDINATE {
        Ok(value)
    } else if value.is_finite() {
        Err(format!("{value:e} is not between -1e12 and 1e12"))
    } else {
        Err(format!("`{value}` is not a finite number"))
    }
}

impl CsvPoints {
    fn open(file: File) -> Result<Source, String> {
        // Rows may have more or fewer cells than the header, as long as x, y and z are there.
        let mut reader = ReaderBuilder::new().flexible(true).trim(Trim::All).buffer_capacity(1 << 16).from_reader(file);
        let header = reader.byte_headers().map_err(|error| csv_problem(&error))?.clone();
        let mut columns = [0; 3];
        for (column, name) in columns.iter_mut().zip(["x", "y", "z"]) {
            let mut places = (0..header.len()).filter(|&index| &header[index] == name.as_bytes());
            let given = || {
                let names: Vec<_> = header.iter().map(String::from_utf8_lossy).collect();
                if names.is_empty() { "nothing".to_owned() } else { names.join(",") }
            };
            *column = places.next().ok_or_else(|| {
                format!("line 1: the header has no column `{name}`; it needs x, y and z and has {}", given())
            })?;
            if places.next().is_some() {
                return Err(format!("line 1: the header has two columns `{name}`"));
            }
        }
        Ok(Source::Csv(Box::new(Self { reader, columns, record: ByteRecord::new() })))
    }

    fn next(&mut self) -> Result<Option<DVec3>, String> {
        if !self.reader.read_byte_record(&mut self.record).map_err(|error| csv_problem(&error))? {
            return Ok(None);
        }
        let mut point = DVec3::ZERO;
        for (axis, &column) in self.columns.iter().enumerate() {
            let number = match self.record.get(column) {
                None => Err("the row has no such cell".to_owned()),
                Some(cell) => {
                    let text = String::from_utf8_lossy(cell);
                    text.parse().map_err(|_| format!("`{text}` is not a number")).and_then(checked)
                }
            };
            point[axis] = number.map_err(|problem| format!("{}: {problem}", ["x", "y", "z"][axis]))?;
        }
        Ok(Some(point))
    }

    /// The position at which the last row starts, for messages; there is no next row then. The reader's own count is
    /// off after empty lines.
    fn line(&mut self) -> String {
        let inner: usize = self.record.iter().flatten().filter(|byte| **byte == b'\n').count();
        let end = self.reader.position().byte();
        let file = self.reader.get_mut();
        let lines = file.rewind().and_then(|()| line_at(&mut BufReader::new(file).take(end)));
        lines.map_or(String::new(), |line| format!("line {}: ", line.saturating_sub(inner as u64)))
    }
}

/// The number, from 1, of the line in which the last text of a file stands.
fn line_at(reader: &mut impl BufRead) -> io::Result<u64> {
    let (mut line, mut last) = (1, 1);
    loop {
        let bytes = reader.fill_buf()?;
        if bytes.is_empty() {
            return Ok(last);
        }
        for byte in bytes {
            match byte {
                b'\n' => line += 1,
                b'\r' => {}
                _ => last = line,
            }
        }
        let length = bytes.len();
        reader.consume(length);
    }
}

fn csv_problem(error: &csv::Error) -> String {
    format!("cannot read it: {error}")
}

impl NumberKind {
    fn of(kind: &str) -> Option<Self> {
        let big_endian = kind.starts_with('>');
        match kind {
            "<f8" | ">f8" => Some(Self { double: true, big_endian }),
            "<f4" | ">f4" => Some(Self { double: false, big_endian }),
            _ => None,
        }
    }

    fn row_bytes(self) -> usize {
        if self.double { 24 } else { 12 }
    }

    /// The number of an axis in the bytes of a row.
    fn number(self, row: &[u8; 24], axis: usize) -> f64 {
        let mut bytes = [0; 8];
        let size = self.row_bytes() / 3;
        bytes[..size].copy_from_slice(&row[axis * size..(axis + 1) * size]);
        if self.big_endian {
            bytes[..size].reverse();
        }
        if self.double {
            f64::from_le_bytes(bytes)
        } else {
            let [a, b, c, d, ..] = bytes;
            f32::from_le_bytes([a, b, c, d]).into()
        }
    }
}

impl NpyPoints {
    fn open(file: File) -> Result<Self, String> {
        let mut reader = BufReader::with_capacity(1 << 16, file);
        let header = Header::read(&mut reader)?;
        let [rows, 3] = header.shape[..] else {
            let sides: Vec<String> = header.shape.iter().map(u64::to_string).collect();
            return Err(format!("the array's shape must be N x 3, not {}", sides.join(" x ")));
        };
        if header.by_columns {
            return Err("the array is stored column by column; save it in C order".into());
        }
        let kind = NumberKind::of(&header.kind)
            .ok_or_else(|| format!("the array must be of f4 or f8 numbers, not {}", header.kind))?;
        Ok(Self { reader, kind, rows, next: 0 })
    }

    fn next(&mut self) -> Result<Option<DVec3>, String> {
        if self.next == self.rows {
            return Ok(None);
        }
        let mut row = [0; 24];
        let read = self.reader.read_exact(&mut row[..self.kind.row_bytes()]);
        read.map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => format!("row {}: the file ends early", self.next),
            _ => format!("cannot read it: {error}"),
        })?;
        let mut point = DVec3::ZERO;
        for axis in 0..3 {
            let number = checked(self.kind.number(&row, axis));
            point[axis] =
                number.map_err(|problem| format!("row {}: {}: {problem}", self.next, ["x", "y", "z"][axis]))?;
        }
        self.next += 1;
        Ok(Some(point))
    }
}
