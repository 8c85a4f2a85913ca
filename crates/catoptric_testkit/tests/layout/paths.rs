//! The paths that the code of a file names.

use crate::tokens::{Token, tokens};
use std::collections::HashSet;

/// A path as it is written, such as `super::Scene`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Mention {
    /// The module that it stands in, such as `scene::view`; the crate's root is empty.
    pub(crate) module: String,
    pub(crate) path: Vec<String>,
    pub(crate) line: usize,
    pub(crate) kind: Kind,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// `scene::View` in an expression or type.
    Inline,
    /// `use super::scene::View as Camera`, which gives the module that name. A `pub use` alone is for others: the file
    /// itself uses it only where it has the name again.
    Import { name: String, is_used: bool },
    /// A `use` within a function.
    LocalImport { name: String },
}

impl Mention {
    /// The file only hands on what the path names.
    pub(crate) fn is_re_export(&self) -> bool {
        matches!(self.kind, Kind::Import { is_used: false, .. })
    }
}

/// A file's code without its tests.
#[derive(Debug, Default)]
pub(crate) struct Source {
    pub(crate) mentions: Vec<Mention>,
    /// Modules that lie in the file itself.
    pub(crate) inner: Vec<String>,
    /// Modules that are declared for tests alone.
    pub(crate) tests: Vec<String>,
}

impl Source {
    /// Reads a file's text, which is that of `module`.
    pub(crate) fn read(module: &str, text: &str) -> Self {
        let scopes = vec![(module.to_owned(), 0)];
        let mut reader =
            Reader { tokens: tokens(text), at: 0, depth: 0, scopes, words: HashSet::new(), source: Self::default() };
        while let Some(token) = reader.token(0) {
            reader.step(token);
        }
        for mention in &mut reader.source.mentions {
            if let Kind::Import { name, is_used } = &mut mention.kind {
                *is_used |= reader.words.contains(name.as_str());
            }
        }
        reader.source
    }
}

/// The name of a module's part.
pub(crate) fn child(module: &str, name: &str) -> String {
    if module.is_empty() { name.to_owned() } else { format!("{module}::{name}") }
}

struct Reader<'a> {
    tokens: Vec<Token<'a>>,
    at: usize,
    /// Open braces.
    depth: usize,
    /// The modules that the place lies in, from the file's, with the open braces in which they lie.
    scopes: Vec<(String, usize)>,
    /// The first words of paths in expressions and types.
    words: HashSet<&'a str>,
    source: Source,
}

impl<'a> Reader<'a> {
    fn token(&self, ahead: usize) -> Option<Token<'a>> {
        self.tokens.get(self.at + ahead).copied()
    }

    fn text(&self, ahead: usize) -> &'a str {
        self.token(ahead).map_or("", |token| token.text)
    }

    fn is_word(&self, ahead: usize) -> bool {
        self.token(ahead).is_some_and(|token| token.is_word())
    }

    fn module(&self) -> &str {
        self.scopes.last().map_or("", |(module, _)| module)
    }

    fn step(&mut self, token: Token<'a>) {
        match token.text {
            "#" if self.text(1) == "[" => self.attribute(),
            "{" => {
                self.depth += 1;
                self.at += 1;
            }
            "}" => {
                self.depth = self.depth.saturating_sub(1);
                while self.scopes.len() > 1 && self.scopes.last().is_some_and(|(_, depth)| *depth > self.depth) {
                    self.scopes.pop();
                }
                self.at += 1;
            }
            "pub" => {
                self.visibility();
                if self.text(0) == "use" {
                    self.import(true);
                }
            }
            // Not the `use<'a>` of a type.
            "use" if self.text(1) != "<" => self.import(false),
            "mod" if self.is_word(1) => self.declaration(),
            _ if token.is_word() => self.inline(token),
            _ => self.at += 1,
        }
    }

    /// Passes `pub`, `pub(crate)` and `pub(in super::super)`.
    fn visibility(&mut self) {
        self.at += 1;
        if self.text(0) == "(" && ["crate", "super", "self", "in"].contains(&self.text(1)) {
            while !["", ")"].contains(&self.text(0)) {
                self.at += 1;
            }
            self.at += 1;
        }
    }

    /// Passes the beginning of an attribute, and what `#[cfg(test)]` stands before.
    fn attribute(&mut self) {
        self.at += 2;
        let is_test = (0..5).map(|ahead| self.text(ahead)).eq(["cfg", "(", "test", ")", "]"]);
        if !is_test {
            return;
        }
        self.at += 5;
        // Further attributes.
        while self.text(0) == "#" {
            let end = self.tokens[self.at..].iter().position(|token| token.text == "]");
            self.at = end.map_or(self.tokens.len(), |length| self.at + length + 1);
        }
        if self.text(0) == "pub" {
            self.visibility();
        }
        if self.text(0) == "mod" {
            self.source.tests.push(child(self.module(), self.text(1)));
        }
        self.skip_item();
    }

    /// Passes all up to the brace or semicolon that ends an item.
    fn skip_item(&mut self) {
        let is_import = self.text(0) == "use";
        let mut depth = 0;
        while let Some(token) = self.token(0) {
            match token.text {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" if depth == 0 => return,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
            self.at += 1;
            if depth == 0 && (token.text == ";" || (token.text == "}" && !is_import)) {
                return;
            }
        }
    }

    /// `mod name {`, whose content is read, or `mod name;`, which imports nothing.
    fn declaration(&mut self) {
        let module = child(self.module(), self.text(1));
        if self.text(1) == "tests" {
            self.source.tests.push(module);
            self.skip_item();
            return;
        }
        self.at += 2;
        if self.text(0) == "{" {
            self.depth += 1;
            self.at += 1;
            self.source.inner.push(module.clone());
            self.scopes.push((module, self.depth));
        }
    }

    fn import(&mut self, is_public: bool) {
        self.at += 1;
        if self.text(0) == "::" {
            self.at += 1;
        }
        self.tree(Vec::new(), is_public);
    }

    /// A part of a `use` tree, such as `a::{b, c::d}`, behind `path`.
    fn tree(&mut self, mut path: Vec<String>, is_public: bool) {
        loop {
            match self.token(0) {
                Some(Token { text: "{", .. }) => {
                    self.at += 1;
                    while !["", "}"].contains(&self.text(0)) {
                        let begin = self.at;
                        self.tree(path.clone(), is_public);
                        self.at += usize::from(self.text(0) == "," || self.at == begin);
                    }
                    self.at += 1;
                    return;
                }
                // In macros.
                Some(Token { text: "$", .. }) if self.text(1) == "crate" => self.at += 1,
                Some(token) if token.is_word() || token.text == "*" => {
                    path.push(token.text.to_owned());
                    self.at += 1;
                    if self.text(0) != "::" {
                        return self.leaf(path, token.line, is_public);
                    }
                    self.at += 1;
                }
                _ => return,
            }
        }
    }

    /// The end of a branch of a `use` tree.
    fn leaf(&mut self, mut path: Vec<String>, line: usize, is_public: bool) {
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        let mut name = path.last().cloned().unwrap_or_default();
        if self.text(0) == "as" {
            name = self.text(1).to_owned();
            self.at += 2;
        }
        let is_local = self.scopes.last().is_some_and(|(_, depth)| *depth != self.depth);
        let kind = if is_local { Kind::LocalImport { name } } else { Kind::Import { name, is_used: !is_public } };
        self.source.mentions.push(Mention { module: self.module().to_owned(), path, line, kind });
    }

    /// A path in an expression or type; names alone are none.
    fn inline(&mut self, first: Token<'a>) {
        let before = self.at.checked_sub(1).map_or("", |before| self.tokens[before].text);
        let mut path = vec![first.text.to_owned()];
        self.at += 1;
        while self.text(0) == "::" && self.is_word(1) {
            path.push(self.text(1).to_owned());
            self.at += 2;
        }
        // The rest of `<T as Trait>::Item`, fields and methods, macros' variables.
        let is_rest = ["::", "."].contains(&before) || (before == "$" && first.text != "crate");
        if is_rest {
            return;
        }
        self.words.insert(first.text);
        if path.len() > 1 {
            let module = self.module().to_owned();
            self.source.mentions.push(Mention { module, path, line: first.line, kind: Kind::Inline });
        }
    }
}
