//! Points from files, a part at a time.

use super::npy::Header;
use crate::failure::Failure;
use crate::parse::{FileOrStream, JSON_LINES};
use csv::{ByteRecord, ReaderBuilder, Trim};
use glam::DVec3;
use serde::Deserialize;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};

/// Coordinates beyond this are taken for slips, as in scenes: squares of distances must stay finite.
const MAX_COORDINATE: f64 = 1e12;

/// The longest line of JSON, in bytes.
const MOST_LINE: u64 = 1 << 16;

/// Points that are being read.
pub(super) struct Points {
    name: String,
    total_bytes: u64,
    source: Source,
}

enum Source {
    Csv(Box<CsvPoints>),
    JsonLines(JsonPoints),
    Npy(NpyPoints),
    /// Points that are known already.
    List(std::vec::IntoIter<DVec3>),
}

struct CsvPoints {
    reader: csv::Reader<File>,
    /// The columns of x, y and z.
    columns: [usize; 3],
    /// Runs of blanks lie between cells.
    runs: bool,
    /// The record is a row of points that waits for its turn.
    waits: bool,
    record: ByteRecord,
}

struct JsonPoints {
    reader: BufReader<File>,
    text: Vec<u8>,
    line: u64,
    bytes: u64,
}

/// A point as a line of JSON; other keys are ignored.
#[derive(Deserialize)]
#[serde(untagged)]
enum JsonPoint {
    Named {
        #[serde(alias = "X")]
        x: f64,
        #[serde(alias = "Y")]
        y: f64,
        #[serde(alias = "Z")]
        z: f64,
    },
    Listed([f64; 3]),
}

struct NpyPoints {
    file: File,
    /// Where its numbers begin.
    start: u64,
    kind: NumberKind,
    by_columns: bool,
    rows: u64,
    next: u64,
    /// The rows that are read together with the next one.
    block: Vec<u8>,
}

/// The storage of a number.
#[derive(Clone, Copy)]
struct NumberKind {
    format: Format,
    bytes: usize,
    big_endian: bool,
}

#[derive(Clone, Copy)]
enum Format {
    Float,
    Signed,
    Unsigned,
}

impl Points {
    /// Points that are known already.
    pub(super) fn listed(points: Vec<DVec3>) -> Self {
        let name = "the grid".to_owned();
        Self { name, total_bytes: points.len() as u64, source: Source::List(points.into_iter()) }
    }

    /// Opens a file of a table, of JSON lines or of an array by its extension, or standard input with a table, and
    /// checks its header.
    pub(super) fn open(input: &FileOrStream) -> Result<Self, Failure> {
        let name = input.input_name();
        let fail = |error: io::Error| Failure::input(format!("{name}: cannot read it: {error}"));
        let file = input.open().map_err(fail)?;
        let metadata = file.metadata().map_err(fail)?;
        if metadata.is_dir() {
            return Err(Failure::input(format!("{name}: cannot read it: it is a folder")));
        }
        let is_array = input.has_extension("npy");
        let is_json = JSON_LINES.iter().any(|extension| input.has_extension(extension));
        let source = match is_array {
            true => NpyPoints::open(file).map(Source::Npy),
            false if is_json => Ok(Source::JsonLines(JsonPoints::new(file))),
            false => CsvPoints::open(file),
        };
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
            Source::JsonLines(json) => json.bytes,
            Source::List(points) => self.total_bytes - points.len() as u64,
            Source::Npy(npy) => npy.next * 3 * npy.kind.bytes as u64,
        }
    }

    /// The next points, at most `count`; empty at the end.
    pub(super) fn read(&mut self, count: usize) -> Result<Vec<DVec3>, Failure> {
        let mut points = Vec::new();
        while points.len() < count {
            let next = match &mut self.source {
                Source::Csv(csv) => csv.next(),
                Source::JsonLines(json) => json.next(),
                Source::List(points) => Ok(points.next()),
                Source::Npy(npy) => npy.next(),
            };
            match next {
                Ok(Some(point)) => points.push(point),
                Ok(None) => break,
                Err(problem) => {
                    // Lines are counted only for messages.
                    let line = match &mut self.source {
                        Source::Csv(csv) => csv.line(),
                        Source::JsonLines(json) => format!("line {}: ", json.line),
                        Source::Npy(_) | Source::List(_) => String::new(),
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
    fn open(mut file: File) -> Result<Source, String> {
        let separator = separator(&mut file).map_err(|error| format!("cannot read it: {error}"))?;
        // Rows may have more or fewer cells than the header, as long as x, y and z are there.
        let mut reader = ReaderBuilder::new()
            .flexible(true)
            .trim(Trim::All)
            .has_headers(false)
            .delimiter(separator)
            .comment(Some(b'#'))
            .buffer_capacity(1 << 16)
            .from_reader(file);
        let mut record = ByteRecord::new();
        reader.read_byte_record(&mut record).map_err(|error| csv_problem(&error))?;
        let runs = separator == b' ';
        let cells: Vec<&[u8]> = record.iter().filter(|cell| !runs || !cell.is_empty()).collect();
        let is_number = |cell: &&[u8]| String::from_utf8_lossy(cell).parse::<f64>().is_ok();
        let is_headless = cells.len() >= 3 && cells[..3].iter().all(is_number);
        let columns = if is_headless { [0, 1, 2] } else { columns_of(&cells)? };
        Ok(Source::Csv(Box::new(Self { reader, columns, runs, waits: is_headless, record })))
    }

    fn next(&mut self) -> Result<Option<DVec3>, String> {
        // The first row of a table without header has been read.
        if !std::mem::take(&mut self.waits)
            && !self.reader.read_byte_record(&mut self.record).map_err(|error| csv_problem(&error))?
        {
            return Ok(None);
        }
        let mut point = DVec3::ZERO;
        for (axis, &column) in self.columns.iter().enumerate() {
            let cell = match self.runs {
                true => self.record.iter().filter(|cell| !cell.is_empty()).nth(column),
                false => self.record.get(column),
            };
            let number = match cell {
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

impl JsonPoints {
    fn new(file: File) -> Self {
        Self { reader: BufReader::with_capacity(1 << 16, file), text: Vec::new(), line: 0, bytes: 0 }
    }

    fn next(&mut self) -> Result<Option<DVec3>, String> {
        loop {
            self.text.clear();
            let read = self.reader.by_ref().take(MOST_LINE).read_until(b'\n', &mut self.text);
            let read = read.map_err(|error| format!("cannot read it: {error}"))? as u64;
            if read == 0 {
                return Ok(None);
            }
            self.line += 1;
            self.bytes += read;
            if read == MOST_LINE && !self.text.ends_with(b"\n") {
                return Err(format!("the line is longer than {MOST_LINE} bytes"));
            }
            let text = self.text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&self.text).trim_ascii();
            if text.is_empty() {
                continue;
            }
            let [x, y, z] = match serde_json::from_slice(text) {
                Ok(JsonPoint::Named { x, y, z } | JsonPoint::Listed([x, y, z])) => [x, y, z].map(checked),
                Err(_) => {
                    return Err("a point is {\"x\": 1, \"y\": 2, \"z\": 3} or [1, 2, 3], on a line of its own".into());
                }
            };
            return Ok(Some(DVec3::new(x?, y?, z?)));
        }
    }
}

/// The bytes of a table's beginning in which its separator is looked for.
const BEGINNING: u64 = 1 << 16;

/// The separator of a table's cells: the first of these that its first row has. The file is at its start again.
fn separator(file: &mut File) -> io::Result<u8> {
    let mut beginning = Vec::new();
    file.by_ref().take(BEGINNING).read_to_end(&mut beginning)?;
    file.rewind()?;
    let mut lines = beginning.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with(b"#")).unwrap_or_default();
    Ok([b';', b',', b'\t', b' '].into_iter().find(|separator| first.contains(separator)).unwrap_or(b','))
}

/// The columns of x, y and z in a header, in letters of either case.
fn columns_of(header: &[&[u8]]) -> Result<[usize; 3], String> {
    let mut columns = [0; 3];
    for (column, name) in columns.iter_mut().zip(["x", "y", "z"]) {
        let is_named = |cell: &[u8]| cell.trim_ascii().eq_ignore_ascii_case(name.as_bytes());
        let mut places = (0..header.len()).filter(|&index| is_named(header[index]));
        let given = || {
            let names: Vec<_> = header.iter().map(|cell| String::from_utf8_lossy(cell)).collect();
            if names.is_empty() { "nothing".to_owned() } else { names.join(",") }
        };
        *column = places.next().ok_or_else(|| {
            format!(
                "line 1: the header has no column `{name}`; it needs x, y and z and has {} (rows of numbers need none)",
                given()
            )
        })?;
        if places.next().is_some() {
            return Err(format!("line 1: the header has two columns `{name}`"));
        }
    }
    Ok(columns)
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
        let (order, rest) = kind.split_at_checked(1)?;
        let (letter, bytes) = rest.split_at_checked(1)?;
        let bytes: usize = bytes.parse().ok()?;
        let format = match (letter, bytes) {
            ("f", 4 | 8) => Format::Float,
            ("i", 1 | 2 | 4 | 8) => Format::Signed,
            ("u", 1 | 2 | 4 | 8) => Format::Unsigned,
            _ => return None,
        };
        matches!(order, "<" | ">" | "|").then_some(Self { format, bytes, big_endian: order == ">" })
    }

    fn number(self, bytes: &[u8]) -> f64 {
        let mut number = [0; 8];
        number[..self.bytes].copy_from_slice(bytes);
        if self.big_endian {
            number[..self.bytes].reverse();
        }
        let whole = u64::from_le_bytes(number);
        match (self.format, self.bytes) {
            (Format::Float, 4) => f32::from_bits(whole as u32).into(),
            (Format::Float, _) => f64::from_bits(whole),
            (Format::Unsigned, _) => whole as f64,
            // With the sign in front.
            (Format::Signed, bytes) => ((whole << (64 - 8 * bytes)) as i64 >> (64 - 8 * bytes)) as f64,
        }
    }
}

/// Rows that are read together.
const ROWS: u64 = 4096;

impl NpyPoints {
    fn open(file: File) -> Result<Self, String> {
        let mut reader = BufReader::with_capacity(1 << 16, file);
        let header = Header::read(&mut reader)?;
        let [rows, 3] = header.shape[..] else {
            let sides: Vec<String> = header.shape.iter().map(u64::to_string).collect();
            return Err(format!("the array's shape must be N x 3, not {}", sides.join(" x ")));
        };
        let kind = NumberKind::of(&header.kind)
            .ok_or_else(|| format!("the array must be of f4 or f8 or whole numbers, not {}", header.kind))?;
        let start = reader.stream_position().map_err(|error| format!("cannot read it: {error}"))?;
        let file = reader.into_inner();
        Ok(Self { file, start, kind, by_columns: header.by_columns, rows, next: 0, block: Vec::new() })
    }

    fn next(&mut self) -> Result<Option<DVec3>, String> {
        if self.next == self.rows {
            return Ok(None);
        }
        let within = (self.next % ROWS) as usize;
        if within == 0 {
            self.read_block()?;
        }
        let (size, row) = (self.kind.bytes, self.next);
        let count = (self.rows - (row - within as u64)).min(ROWS) as usize;
        let mut point = DVec3::ZERO;
        for axis in 0..3 {
            let place = size * if self.by_columns { axis * count + within } else { 3 * within + axis };
            let bytes = self.block.get(place..place + size).ok_or_else(|| format!("row {row}: the file ends early"))?;
            let number = checked(self.kind.number(bytes));
            point[axis] = number.map_err(|problem| format!("row {row}: {}: {problem}", ["x", "y", "z"][axis]))?;
        }
        self.next += 1;
        Ok(Some(point))
    }

    /// Reads the next rows: together, or from each of three columns. What the file lacks is missing at the end.
    fn read_block(&mut self) -> Result<(), String> {
        let (size, count) = (self.kind.bytes as u64, (self.rows - self.next).min(ROWS));
        self.block.clear();
        let parts: Vec<(u64, u64)> = match self.by_columns {
            true => (0..3).map(|axis| ((axis * self.rows + self.next) * size, count * size)).collect(),
            false => vec![(3 * self.next * size, 3 * count * size)],
        };
        for (place, length) in parts {
            let place = self.start.saturating_add(place);
            let read = self.file.seek(SeekFrom::Start(place));
            let read = read.and_then(|_| self.file.by_ref().take(length).read_to_end(&mut self.block));
            read.map_err(|error| format!("cannot read it: {error}"))?;
        }
        Ok(())
    }
}
