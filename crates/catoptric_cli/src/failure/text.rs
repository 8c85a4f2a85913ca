//! Text of files, as a terminal may get it.
//!
//! Names and values of files are printed in messages and lists. Control characters among them would set the terminal's
//! title, hide lines or fill the clipboard, and names can be of any length: both are taken care of where text is
//! printed.

use std::borrow::Cow;
use std::fmt::Write;

/// The most characters of a message at its beginning and end: what lies between belongs to a value that is quoted.
const ENDS_OF_MESSAGE: [usize; 2] = [3000, 1000];
/// The most characters of a name in a list.
pub(crate) const MOST_OF_NAME: usize = 60;

/// Text without characters that a terminal obeys, other than the ends of lines and tabs; others are shown as
/// `\u{1b}`.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    match text.contains(is_obeyed) {
        true => Cow::Owned(escaped(text, |number| format!("\\u{{{number:x}}}"))),
        false => Cow::Borrowed(text),
    }
}

/// The same for text of JSON, whose strings it leaves as they are.
pub(crate) fn printable_json(text: String) -> String {
    // All of them lie below U+10000.
    if text.contains(is_obeyed) { escaped(&text, |number| format!("\\u{number:04x}")) } else { text }
}

/// A message of one line, cut where it is very long.
pub(crate) fn one_line(message: &str) -> String {
    printable(&cut(message, ENDS_OF_MESSAGE)).replace('\n', "\\u{a}")
}

/// A message of some lines, cut where it is very long.
pub(crate) fn some_lines(message: &str) -> String {
    printable(&cut(message, ENDS_OF_MESSAGE)).into_owned()
}

/// A name in a list, cut where it is long.
pub(crate) fn name(name: &str) -> String {
    printable(&cut(name, [MOST_OF_NAME, 0])).replace(['\n', '\t'], " ")
}

/// True for text that spreadsheets would take for a formula: an apostrophe before it tells them that it is text.
pub(crate) fn begins_formula(text: &str) -> bool {
    text.starts_with(['=', '+', '-', '@', '\t', '\r'])
}

/// The first and last characters of a text, and the number of those between.
fn cut(text: &str, [first, last]: [usize; 2]) -> Cow<'_, str> {
    if text.len() <= first + last {
        return Cow::Borrowed(text);
    }
    let count = text.chars().count();
    if count <= first + last {
        return Cow::Borrowed(text);
    }
    let at = |number: usize| text.char_indices().nth(number).map_or(text.len(), |(at, _)| at);
    let (begin, end) = (&text[..at(first)], &text[at(count - last)..]);
    Cow::Owned(format!(
        "{begin}... ({} more characters){}{end}",
        count - first - last,
        if last > 0 { " ..." } else { "" }
    ))
}

fn escaped(text: &str, escape: impl Fn(u32) -> String) -> String {
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        if is_obeyed(character) {
            let _ = shown.write_str(&escape(character.into()));
        } else {
            shown.push(character);
        }
    }
    shown
}

/// Controls (C0, DEL, C1), separators of lines and what changes the direction of writing.
fn is_obeyed(character: char) -> bool {
    let is_direction = matches!(character,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    (character.is_control() && !matches!(character, '\n' | '\t')) || is_direction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_left_that_a_terminal_obeys() {
        let evil = "a\u{1b}]0;title\u{7}b\u{9b}31m\u{7f}\u{202e}\r\u{0}";
        assert_eq!(printable(evil), r"a\u{1b}]0;title\u{7}b\u{9b}31m\u{7f}\u{202e}\u{d}\u{0}");
        assert_eq!(printable("ä\tß\n日本"), "ä\tß\n日本");
        assert_eq!(one_line("a\nerror: b"), r"a\u{a}error: b");
    }

    #[test]
    fn json_stays_the_same_json() {
        let value = serde_json::json!({ "name": "\u{1b}[31m\u{7f}\u{9b}\u{202e}é" });
        let text = printable_json(serde_json::to_string(&value).expect("it is JSON"));
        assert!(!text.contains(is_obeyed), "{text}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).expect("it is JSON"), value);
    }

    #[test]
    fn long_names_are_cut() {
        assert_eq!(name(&"x".repeat(MOST_OF_NAME)), "x".repeat(MOST_OF_NAME));
        assert_eq!(name(&"é".repeat(100)), format!("{}... (40 more characters)", "é".repeat(60)));
    }
}
