//! NumPy's array files (NEP 1), as far as points and rows need them.
//!
//! The crates for them parse their headers with a general parser of Python literals, which brings code that needs an
//! assembler to build; headers of plain arrays are one line in a fixed form.

use std::io::{self, BufRead, Seek, SeekFrom, Write};

const MAGIC: &[u8] = b"\x93NUMPY";

/// The longest header that is read; those of plain arrays have about a hundred bytes.
const MAX_HEADER: usize = 4096;

/// Digits that are kept free for the number of rows.
const COUNT_WIDTH: usize = 20;

/// The header of an array file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    /// The kind of its numbers, such as `<f8`; empty for structured arrays.
    pub(super) kind: String,
    /// Columns are stored one after the other.
    pub(super) by_columns: bool,
    pub(super) shape: Vec<u64>,
}

impl Header {
    /// Reads up to where the array's numbers start.
    pub(super) fn read(reader: &mut impl BufRead) -> Result<Self, String> {
        let mut take = |count: usize| {
            let mut bytes = vec![0; count];
            reader.read_exact(&mut bytes).map(|()| bytes).map_err(|error| match error.kind() {
                io::ErrorKind::UnexpectedEof => "it is no NPY file: it ends in its header".to_owned(),
                _ => format!("cannot read it: {error}"),
            })
        };
        let start = take(8)?;
        if !start.starts_with(MAGIC) {
            return Err("it is no NPY file".into());
        }
        let length = match start[6] {
            1 => take(2)?.iter().rev().fold(0, |length, byte| length << 8 | usize::from(*byte)),
            2 | 3 => take(4)?.iter().rev().fold(0, |length, byte| length << 8 | usize::from(*byte)),
            version => return Err(format!("it is an NPY file of version {version}, which is not known")),
        };
        if length > MAX_HEADER {
            return Err("its header is too long for a plain array".into());
        }
        let text = String::from_utf8_lossy(&take(length)?).replace('"', "'");
        Self::parse(&text).ok_or_else(|| format!("its header is not that of an array: {}", text.trim()))
    }

    fn parse(text: &str) -> Option<Self> {
        let value = |key: &str| Some(text.split_once(&format!("'{key}':"))?.1.trim_start());
        let kind = match value("descr")?.strip_prefix('\'') {
            Some(rest) => rest.split_once('\'')?.0.to_owned(),
            None => String::new(),
        };
        let by_columns = match value("fortran_order")? {
            order if order.starts_with("True") => true,
            order if order.starts_with("False") => false,
            _ => return None,
        };
        let (sides, _) = value("shape")?.strip_prefix('(')?.split_once(')')?;
        let sides = sides.split(',').map(str::trim).filter(|side| !side.is_empty());
        let shape = sides.map(str::parse).collect::<Result<Vec<u64>, _>>().ok()?;
        Some(Self { kind, by_columns, shape })
    }
}

/// Writes a structured array of rows whose number follows at the end.
pub(super) struct RowWriter<W: Write + Seek> {
    writer: W,
    start: u64,
    /// The columns, as Python writes them.
    kinds: String,
    row_bytes: usize,
    rows: u64,
}

impl<W: Write + Seek> RowWriter<W> {
    /// Starts an array with these columns: their names, kinds and bytes.
    pub(super) fn new(mut writer: W, columns: &[(String, String, usize)]) -> io::Result<Self> {
        let kinds: Vec<String> = columns.iter().map(|(name, kind, _)| format!("('{name}', '{kind}')")).collect();
        let row_bytes = columns.iter().map(|(_, _, bytes)| bytes).sum();
        let start = writer.stream_position()?;
        let mut array = Self { writer, start, kinds: format!("[{}]", kinds.join(", ")), row_bytes, rows: 0 };
        array.write_header()?;
        Ok(array)
    }

    /// The header, of the same length for every number of rows.
    fn write_header(&mut self) -> io::Result<()> {
        let Self { kinds, rows, .. } = self;
        let count = format!("{rows},");
        let mut text = format!("{{'descr': {kinds}, 'fortran_order': False, 'shape': ({count}), }}");
        // Padded with spaces so that the numbers start at a multiple of 64 bytes.
        let unpadded = text.len() - count.len() + COUNT_WIDTH + 1;
        let length = (10 + unpadded + 1).next_multiple_of(64) - 10;
        text.extend(std::iter::repeat_n(' ', length - 1 - text.len()));
        text.push('\n');
        let length = u16::try_from(length).map_err(|_| io::Error::other("the array has too many columns"))?;
        self.writer.write_all(MAGIC)?;
        self.writer.write_all(&[1, 0])?;
        self.writer.write_all(&length.to_le_bytes())?;
        self.writer.write_all(text.as_bytes())
    }

    /// Appends whole rows.
    pub(super) fn write(&mut self, rows: &[u8]) -> io::Result<()> {
        self.rows += (rows.len() / self.row_bytes) as u64;
        self.writer.write_all(rows)
    }

    /// Writes how many rows there are.
    pub(super) fn finish(mut self) -> io::Result<()> {
        self.writer.seek(SeekFrom::Start(self.start))?;
        self.write_header()?;
        self.writer.seek(SeekFrom::End(0))?;
        self.writer.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn headers_as_numpy_writes_them() {
        let header = Header::parse("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 3), }   \n");
        assert_eq!(header, Some(Header { kind: "<f8".into(), by_columns: false, shape: vec![3, 3] }));
        let header = Header::parse("{'descr': '>f4', 'fortran_order': True, 'shape': (7,), }");
        assert_eq!(header, Some(Header { kind: ">f4".into(), by_columns: true, shape: vec![7] }));
        let header = Header::parse("{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (), }");
        assert_eq!(header, Some(Header { kind: String::new(), by_columns: false, shape: vec![] }));
        for broken in ["", "{}", "{'descr': '<f8', 'fortran_order': 1, 'shape': (1,)}", "{'descr': '<f8"] {
            assert_eq!(Header::parse(broken), None, "{broken}");
        }
        let overflow = "{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999999999, 3), }";
        assert_eq!(Header::parse(overflow), None);
    }

    #[test]
    fn arrays_of_rows_know_their_number_at_the_end() {
        let columns = [("a".to_owned(), "<u2".to_owned(), 2), ("b".to_owned(), "|S3".to_owned(), 3)];
        let mut file = Cursor::new(Vec::new());
        let mut writer = RowWriter::new(&mut file, &columns).unwrap();
        writer.write(b"\x01\x00abc\x02\x00de\x00").unwrap();
        writer.write(b"\x03\x00f\x00\x00").unwrap();
        writer.finish().unwrap();
        let bytes = file.into_inner();
        let start = bytes.len() - 15;
        assert!(start.is_multiple_of(64) && bytes[start - 1] == b'\n');
        assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"));
        assert_eq!(usize::from(u16::from_le_bytes([bytes[8], bytes[9]])) + 10, start);
        let text = std::str::from_utf8(&bytes[10..start]).unwrap();
        let expected = "{'descr': [('a', '<u2'), ('b', '|S3')], 'fortran_order': False, 'shape': (3,), }";
        assert_eq!(text.trim_end(), expected);
        assert_eq!(Header::read(&mut &bytes[..]).unwrap().shape, [3]);
    }
}
