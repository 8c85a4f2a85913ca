//! The words and marks of Rust code.

/// A word (a name or keyword), `::`, `..`, or one other mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Token<'a> {
    pub(crate) text: &'a str,
    /// Counted from 1.
    pub(crate) line: usize,
}

impl Token<'_> {
    pub(crate) fn is_word(&self) -> bool {
        self.text.starts_with(starts_word)
    }
}

/// The tokens of a text; comments, strings, characters, lifetimes and numbers are left out.
pub(crate) fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut found = Vec::new();
    let mut line = 1;
    let mut rest = text;
    while !rest.is_empty() {
        let (length, is_token) = piece(rest);
        let (piece, after) = rest.split_at(length);
        if is_token {
            found.push(Token { text: piece, line });
        }
        line += piece.matches('\n').count();
        rest = after;
    }
    found
}

fn starts_word(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

fn continues_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The bytes of the first piece of a text that is not empty, and if it is a token.
fn piece(text: &str) -> (usize, bool) {
    let mut chars = text.chars();
    let first = chars.next().unwrap_or_default();
    let until = |is_end: fn(char) -> bool| text.find(is_end).unwrap_or(text.len());
    if text.starts_with("//") {
        (until(|c| c == '\n'), false)
    } else if text.starts_with("/*") {
        (block_comment(text), false)
    } else if let Some(length) = string(text) {
        (length, false)
    } else if first == '\'' {
        (character_or_lifetime(text), false)
    } else if first.is_ascii_digit() {
        let end = until(|c| !continues_word(c));
        // The point of `1.5`, not that of `1..2` or of `1.max(2)`.
        let fraction = text[end..].strip_prefix('.').filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
        (end + usize::from(fraction.is_some()), false)
    } else if starts_word(first) {
        (until(|c| !continues_word(c)), true)
    } else if text.starts_with("::") || text.starts_with("..") {
        (2, true)
    } else {
        (first.len_utf8(), !first.is_whitespace())
    }
}

/// The bytes of the comment that a text begins with; comments may be nested.
fn block_comment(text: &str) -> usize {
    let mut depth = 0;
    let mut at = 0;
    while let Some(step) = text[at..].find(['/', '*']) {
        at += step;
        let (change, length) = match &text.as_bytes()[at..(at + 2).min(text.len())] {
            b"/*" => (1, 2),
            b"*/" => (-1, 2),
            _ => (0, 1),
        };
        depth += change;
        at += length;
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

/// The bytes of the string that a text begins with.
fn string(text: &str) -> Option<usize> {
    let plain = text.strip_prefix(['b', 'c']).unwrap_or(text);
    if let Some(raw) = plain.strip_prefix('r') {
        let unmarked = raw.trim_start_matches('#');
        let content = unmarked.strip_prefix('"')?;
        let end = format!("\"{}", &raw[..raw.len() - unmarked.len()]);
        let after = content.find(&end).map_or("", |at| &content[at + end.len()..]);
        return Some(text.len() - after.len());
    }
    let mut rest = plain.strip_prefix('"')?;
    while let Some(at) = rest.find(['"', '\\']) {
        let mut after = rest[at..].chars();
        let is_end = after.next() == Some('"');
        if !is_end {
            after.next();
        }
        rest = after.as_str();
        if is_end {
            return Some(text.len() - rest.len());
        }
    }
    Some(text.len())
}

/// The bytes of `'a'`, `'\n'` or of the lifetime `'a`.
fn character_or_lifetime(text: &str) -> usize {
    let mut chars = text.chars().skip(1);
    match (chars.next(), chars.next()) {
        (Some('\\'), Some(escaped)) => {
            let begin = 2 + escaped.len_utf8();
            text[begin..].find('\'').map_or(text.len(), |end| begin + end + 1)
        }
        (Some(character), Some('\'')) => character.len_utf8() + 2,
        _ => 1,
    }
}
