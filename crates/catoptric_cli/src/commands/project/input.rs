//! Points from files, a part at a time.

use crate::failure::Failure;
use csv::{ByteRecord, ReaderBuilder, Trim};
use glam::DVec3;
use npyz::{NpyFile, NpyHeader, NpyReader, Order};
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::{Path, PathBuf};

/// Coordinates beyond this are taken for slips, as in scenes: squares of distances must stay finite.
const MAX_COORDINATE: f64 = 1e12;

/// The longest header of an array file that is looked at; those of plain arrays have about a hundred bytes.
const MAX_HEADER: usize = 4096;

/// A file of points that is being read.
pub(super) struct Points {
    path: PathBuf,
    total_bytes: u64,
    source: Source,
}

enum Source {
    Csv(Box<CsvPoints>),
    Npy(NpyPoints),
}

struct CsvPoints {
    reader: csv::Reader<File>,
    /// Where x, y and z stand in a row.
    columns: [usize; 3],
    record: ByteRecord,
}

struct NpyPoints {
    numbers: Numbers,
    bytes_a_number: u64,
    rows: u64,
    next: u64,
}

enum Numbers {
    Single(NpyReader<f32, BufReader<File>>),
    Double(NpyReader<f64, BufReader<File>>),
}

impl Points {
    /// Opens a `.csv` or `.npy` file and checks its header.
    pub(super) fn open(path: &Path) -> Result<Self, Failure> {
        let fail = |error: std::io::Error| Failure::input(format!("{}: cannot read it: {error}", path.display()));
        let file = File::open(path).map_err(fail)?;
        let metadata = file.metadata().map_err(fail)?;
        if metadata.is_dir() {
            return Err(Failure::input(format!("{}: cannot read it: it is a folder", path.display())));
        }
        let is_array = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("npy"));
        let source = if is_array { NpyPoints::open(file).map(Source::Npy) } else { CsvPoints::open(file) };
        let source = source.map_err(|problem| Failure::input(format!("{}: {problem}", path.display())))?;
        Ok(Self { path: path.into(), total_bytes: metadata.len(), source })
    }

    /// The size of the file.
    pub(super) fn total_bytes(&self) -> u64 {
        self.total_bytes
    }

    /// About how much of it has been read.
    pub(super) fn bytes_read(&self) -> u64 {
        match &self.source {
            Source::Csv(csv) => csv.reader.position().byte(),
            Source::Npy(npy) => npy.next * 3 * npy.bytes_a_number,
        }
    }

    /// The next points, at most `count`; none at the end.
    pub(super) fn read(&mut self, count: usize) -> Result<Vec<DVec3>, Failure> {
        let mut points = Vec::new();
        while points.len() < count {
            let next = match &mut self.source {
                Source::Csv(csv) => csv.next(),
                Source::Npy(npy) => npy.next(),
            };
            match next.map_err(|problem| Failure::input(format!("{}: {problem}", self.path.display())))? {
                Some(point) => points.push(point),
                None => break,
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
            point[axis] = number.map_err(|problem| {
                let line = self.record.position().map_or(0, csv::Position::line);
                format!("line {line}: {}: {problem}", ["x", "y", "z"][axis])
            })?;
        }
        Ok(Some(point))
    }
}

fn csv_problem(error: &csv::Error) -> String {
    match error.position() {
        Some(position) => format!("line {}: {error}", position.line()),
        None => format!("cannot read it: {error}"),
    }
}

impl NpyPoints {
    fn open(file: File) -> Result<Self, String> {
        let mut reader = BufReader::with_capacity(1 << 16, file);
        check_header(&mut reader)?;
        let header = NpyHeader::from_reader(&mut reader).map_err(|error| error.to_string())?;
        let shape = header.shape().to_vec();
        let [rows, 3] = shape[..] else {
            let sides: Vec<String> = shape.iter().map(u64::to_string).collect();
            return Err(format!("the array's shape must be N x 3, not {}", sides.join(" x ")));
        };
        if header.order() != Order::C {
            return Err("the array is stored column by column; save it in C order".into());
        }
        let (numbers, bytes_a_number) = match NpyFile::with_header(header, reader).try_data::<f64>() {
            Ok(numbers) => (Numbers::Double(numbers), 8),
            Err(file) => {
                let kind = file.dtype().descr();
                let numbers = file.try_data::<f32>();
                let numbers = numbers.map_err(|_| format!("the array must be of f4 or f8 numbers, not {kind}"))?;
                (Numbers::Single(numbers), 4)
            }
        };
        Ok(Self { numbers, bytes_a_number, rows, next: 0 })
    }

    fn next(&mut self) -> Result<Option<DVec3>, String> {
        if self.next == self.rows {
            return Ok(None);
        }
        let mut point = DVec3::ZERO;
        for axis in 0..3 {
            let number = match &mut self.numbers {
                Numbers::Single(numbers) => numbers.next().map(|number| number.map(f64::from)),
                Numbers::Double(numbers) => numbers.next(),
            };
            let number = match number {
                Some(Ok(number)) => checked(number),
                Some(Err(error)) => Err(format!("cannot read it: {error}")),
                None => Err("the file ends early".into()),
            };
            point[axis] =
                number.map_err(|problem| format!("row {}: {}: {problem}", self.next, ["x", "y", "z"][axis]))?;
        }
        self.next += 1;
        Ok(Some(point))
    }
}

/// Refuses headers that no plain array has, before they are parsed: deep nesting, and sizes whose product overflows.
fn check_header(reader: &mut BufReader<File>) -> Result<(), String> {
    let fail = |error: std::io::Error| format!("cannot read it: {error}");
    let mut start = [0; MAX_HEADER];
    let mut length = 0;
    while length < MAX_HEADER {
        match reader.read(&mut start[length..]).map_err(fail)? {
            0 => break,
            read => length += read,
        }
    }
    reader.rewind().map_err(fail)?;
    let start = &start[..length];
    if !start.starts_with(b"\x93NUMPY") || length < 12 {
        return Err("it is no NPY file".into());
    }
    let (text_start, text_length) = match start[6] {
        1 => (10, u32::from(u16::from_le_bytes([start[8], start[9]]))),
        _ => (12, u32::from_le_bytes([start[8], start[9], start[10], start[11]])),
    };
    let text = (text_start as u64 + u64::from(text_length) <= length as u64)
        .then(|| &start[text_start..text_start + text_length as usize])
        .ok_or("its header is cut short or too long for a plain array")?;
    let digits = text.iter().filter(|byte| byte.is_ascii_digit()).count();
    let brackets = text.iter().filter(|byte| b"([{".contains(byte)).count();
    if digits > 18 || brackets > 4 {
        return Err("it holds no plain array of N x 3 numbers".into());
    }
    Ok(())
}
