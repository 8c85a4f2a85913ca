//! Lines and words of `.obj` and `.mtl` files, as programs of thirty years have written them.

use std::borrow::Cow;

/// The text of a file: UTF-8, UTF-16 with a byte order mark, or else Latin-1. The mark is left out.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let utf16 = |bytes: &[u8], number: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| number([pair[0], pair[1]])).collect();
        Cow::Owned(String::from_utf16_lossy(&units))
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        _ => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            match std::str::from_utf8(bytes) {
                Ok(text) => Cow::Borrowed(text),
                Err(_) => Cow::Owned(bytes.iter().map(|byte| char::from(*byte)).collect()),
            }
        }
    }
}

/// A keyword and its arguments.
pub(super) struct Statement<'a> {
    /// Trimmed, never empty.
    text: Cow<'a, str>,
    /// The number of its first line, from 1.
    pub(super) line: usize,
}

impl Statement<'_> {
    pub(super) fn keyword(&self) -> &str {
        self.text.split(char::is_whitespace).next().unwrap_or_default()
    }

    /// All that follows the keyword, with what may be a comment: names hold number signs.
    pub(super) fn rest(&self) -> &str {
        self.text.split_once(char::is_whitespace).map_or("", |(_, rest)| rest.trim())
    }

    /// The words after the keyword, up to a comment.
    pub(super) fn words(&self) -> impl Iterator<Item = &str> {
        self.text.split_whitespace().skip(1).take_while(|word| !word.starts_with('#'))
    }
}

/// The statements of a text, without empty lines and comments. Lines end with LF, CR or both; one that ends with a
/// backslash goes on in the next.
pub(super) fn statements(text: &str) -> impl Iterator<Item = Statement<'_>> {
    let mut rest = text;
    let mut number = 0;
    std::iter::from_fn(move || {
        while !rest.is_empty() {
            let mut text = Cow::Borrowed(next_line(&mut rest));
            number += 1;
            let line = number;
            while let Some(begin) = text.strip_suffix('\\').filter(|_| !rest.is_empty()) {
                text = Cow::Owned(format!("{begin} {}", next_line(&mut rest)));
                number += 1;
            }
            if !(text.is_empty() || text.starts_with('#')) {
                return Some(Statement { text, line });
            }
        }
        None
    })
}

/// Takes the next line, trimmed, off a text.
fn next_line<'a>(rest: &mut &'a str) -> &'a str {
    let end = rest.find(['\n', '\r']).unwrap_or(rest.len());
    let (line, after) = rest.split_at(end);
    let break_length = if after.starts_with("\r\n") { 2 } else { after.len().min(1) };
    *rest = &after[break_length..];
    line.trim()
}

/// A number as it stands, or with a decimal comma, or as C libraries print what is none; `None`: the word is no number.
pub(super) fn number(word: &str) -> Option<f64> {
    if let Ok(number) = word.parse() {
        return Some(number);
    }
    let lower = word.to_ascii_lowercase();
    let unsigned = lower.trim_start_matches(['-', '+']);
    if unsigned.starts_with("nan") || unsigned.starts_with("1.#ind") || unsigned.starts_with("1.#qnan") {
        return Some(f64::NAN);
    }
    if unsigned.starts_with("1.#inf") {
        return Some(if lower.starts_with('-') { f64::NEG_INFINITY } else { f64::INFINITY });
    }
    let (whole, decimals) = word.split_once(',')?;
    let is_number = decimals.starts_with(|first: char| first.is_ascii_digit()) && !whole.contains('.');
    format!("{whole}.{decimals}").parse().ok().filter(|_| is_number)
}

/// Lines that were mended or left out: the first few by name, then their count.
#[derive(Default)]
pub(super) struct LineWarnings {
    told: Vec<String>,
    untold: usize,
}

impl LineWarnings {
    /// The most lines that are named.
    const MOST: usize = 5;

    pub(super) fn add(&mut self, line: usize, problem: impl FnOnce() -> String) {
        if self.told.len() < Self::MOST {
            self.told.push(format!("line {line}: {}", problem()));
        } else {
            self.untold += 1;
        }
    }

    /// The warnings, each after the name of the file.
    pub(super) fn into_warnings(self, file: &str) -> impl Iterator<Item = String> {
        let rest = (self.untold > 0).then(|| format!("and {} lines more", self.untold));
        self.told.into_iter().chain(rest).map(move |warning| format!("{file}: {warning}"))
    }
}
