//! Typed access to the keys of a TOML table, with errors that name the line.

use catoptric_core::error::{SceneError, did_you_mean};
use glam::Vec3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Line numbers by fields.
pub(super) type Lines = std::collections::BTreeMap<String, usize>;

/// The text of a scene file, to find lines in.
#[derive(Clone, Copy)]
pub(super) struct Text<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
}

impl Text<'_> {
    /// The number of the line that holds a byte.
    pub(super) fn line(&self, byte: usize) -> usize {
        self.text.as_bytes()[..byte.min(self.text.len())].iter().filter(|byte| **byte == b'\n').count() + 1
    }

    /// An error at a byte of the text.
    pub(super) fn invalid(&self, byte: usize, field: &str, problem: impl Into<String>) -> SceneError {
        SceneError::invalid(self.file, format!("line {}: {field}", self.line(byte)), problem)
    }
}

/// A table whose keys are taken one by one; keys left at the end are unknown.
pub(super) struct Keys<'t, 'i> {
    text: Text<'t>,
    /// The table's name in the file, with a dot at its end; empty for the whole file.
    prefix: String,
    /// The start of the table.
    begin: usize,
    entries: Vec<(String, usize, &'t Spanned<DeValue<'i>>)>,
    /// The keys that were asked for, with their places if they were given.
    known: Vec<(&'static str, Option<usize>)>,
}

impl<'t, 'i> Keys<'t, 'i> {
    pub(super) fn new(text: Text<'t>, prefix: &str, begin: usize, table: &'t DeTable<'i>) -> Self {
        let entry = |(key, value): (&Spanned<std::borrow::Cow<'i, str>>, &'t Spanned<DeValue<'i>>)| {
            (key.get_ref().to_string(), key.span().start, value)
        };
        Self { text, prefix: prefix.into(), begin, entries: table.iter().map(entry).collect(), known: Vec::new() }
    }

    /// A table that must be one.
    pub(super) fn of_value(text: Text<'t>, name: &str, value: &'t Spanned<DeValue<'i>>) -> Result<Self, SceneError> {
        match value.get_ref().as_table() {
            Some(table) => Ok(Self::new(text, &format!("{name}."), value.span().start, table)),
            None => Err(text.invalid(value.span().start, name, format!("must be a table, not {}", kind_of(value)))),
        }
    }

    /// The span of the table's start in the text.
    pub(super) fn begin(&self) -> usize {
        self.begin
    }

    /// The full name of one of the table's keys.
    pub(super) fn field(&self, key: &str) -> String {
        format!("{}{key}", self.prefix)
    }

    /// An error about one of the table's keys, whether it was given or not.
    pub(super) fn invalid(&self, key: &str, problem: impl Into<String>) -> SceneError {
        self.text.invalid(self.begin, &self.field(key), problem)
    }

    /// The error about a key that is missing; if another one that nobody knows is like it, that one is at fault.
    pub(super) fn missing(&self, key: &str, problem: impl Into<String>) -> SceneError {
        let hints = self.entries.iter().map(|(name, begin, _)| (name, *begin, did_you_mean(name, [key])));
        match hints
            .filter(|(name, _, hint)| !hint.is_empty() && self.known.iter().all(|(known, _)| known != name))
            .min()
        {
            Some((name, begin, hint)) => self.wrong(name, begin, format!("unknown key{hint}")),
            None => self.invalid(key, problem),
        }
    }

    /// An error about a key at its place.
    pub(super) fn wrong(&self, key: &str, byte: usize, problem: impl Into<String>) -> SceneError {
        self.text.invalid(byte, &self.field(key), problem)
    }

    /// An error about a key, at its place if it was taken, else the table's.
    pub(super) fn blame(&self, key: &str, problem: impl Into<String>) -> SceneError {
        let begin = self.known.iter().find(|(known, _)| *known == key).and_then(|(_, begin)| *begin);
        self.wrong(key, begin.unwrap_or(self.begin), problem)
    }

    /// Returns true if a key is given, and not taken yet.
    pub(super) fn has(&self, key: &str) -> bool {
        self.entries.iter().any(|(name, ..)| name == key)
    }

    /// Takes a key's value as it stands, and where it stands.
    pub(super) fn take(&mut self, key: &'static str) -> Option<(usize, &'t Spanned<DeValue<'i>>)> {
        let found = self.entries.iter().position(|(name, ..)| name == key);
        let found = found.map(|index| self.entries.swap_remove(index));
        self.known.push((key, found.as_ref().map(|(_, begin, _)| *begin)));
        found.map(|(_, begin, value)| (begin, value))
    }

    pub(super) fn string(&mut self, key: &'static str) -> Result<Option<Located<String>>, SceneError> {
        let Some((begin, value)) = self.take(key) else { return Ok(None) };
        match value.get_ref().as_str() {
            Some(text) => Ok(Some(Located { begin, value: text.into() })),
            None => Err(self.wrong(key, begin, format!("must be a text, not {}", kind_of(value)))),
        }
    }

    pub(super) fn boolean(&mut self, key: &'static str) -> Result<Option<Located<bool>>, SceneError> {
        let Some((begin, value)) = self.take(key) else { return Ok(None) };
        match value.get_ref().as_bool() {
            Some(value) => Ok(Some(Located { begin, value })),
            None => Err(self.wrong(key, begin, format!("must be true or false, not {}", kind_of(value)))),
        }
    }

    /// A finite number, whole or not.
    pub(super) fn number(&mut self, key: &'static str) -> Result<Option<Located<f64>>, SceneError> {
        let Some((begin, value)) = self.take(key) else { return Ok(None) };
        match number_of(value.get_ref()) {
            Some(value) => Ok(Some(Located { begin, value })),
            None => Err(self.wrong(key, begin, format!("must be a finite number, not {}", kind_of(value)))),
        }
    }

    /// A colour whose channels are from 0 to `most`.
    pub(super) fn color(&mut self, key: &'static str, most: f64) -> Result<Option<Vec3>, SceneError> {
        match self.numbers::<3>(key)? {
            Some(at) if !at.value.iter().all(|share| (0.0..=most).contains(share)) => {
                Err(self.wrong(key, at.begin, format!("{:?}; allowed is 0 to {most}", at.value)))
            }
            at => Ok(at.map(|at| Vec3::from(at.value.map(|share| share as f32)))),
        }
    }

    /// `N` finite numbers.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        key: &'static str,
    ) -> Result<Option<Located<[f64; N]>>, SceneError> {
        let list = self.number_list(key, N)?;
        Ok(list.and_then(|Located { begin, value }| Some(Located { begin, value: value.try_into().ok()? })))
    }

    /// Finite numbers of a given count.
    pub(super) fn number_list(
        &mut self,
        key: &'static str,
        count: usize,
    ) -> Result<Option<Located<Vec<f64>>>, SceneError> {
        let Some((begin, value)) = self.take(key) else { return Ok(None) };
        match list_of(value).filter(|numbers| numbers.len() == count) {
            Some(value) => Ok(Some(Located { begin, value })),
            None => Err(self.wrong(key, begin, format!("must be {count} finite numbers in brackets"))),
        }
    }

    /// A finite number, or up to so many in brackets.
    pub(super) fn one_or_more(
        &mut self,
        key: &'static str,
        most: usize,
    ) -> Result<Option<Located<Vec<f64>>>, SceneError> {
        let Some((begin, value)) = self.take(key) else { return Ok(None) };
        let list = number_of(value.get_ref()).map(|number| vec![number]).or_else(|| list_of(value));
        match list.filter(|numbers| (1..=most).contains(&numbers.len())) {
            Some(value) => Ok(Some(Located { begin, value })),
            None => Err(self.wrong(key, begin, format!("must be a finite number, or up to {most} in brackets"))),
        }
    }

    /// `N` finite numbers that a value is.
    pub(super) fn numbers_of<const N: usize>(value: &Spanned<DeValue<'_>>) -> Option<[f64; N]> {
        list_of(value)?.try_into().ok()
    }

    /// A table in this one.
    pub(super) fn table(&mut self, key: &'static str) -> Result<Option<Keys<'t, 'i>>, SceneError> {
        let name = self.field(key);
        self.take(key).map(|(_, value)| Self::of_value(self.text, &name, value)).transpose()
    }

    /// The tables `[[key]]`.
    pub(super) fn tables(&mut self, key: &'static str) -> Result<Vec<Keys<'t, 'i>>, SceneError> {
        let Some((begin, value)) = self.take(key) else { return Ok(Vec::new()) };
        let wrong = || self.text.invalid(begin, key, format!("must be written as [[{key}]], once for each"));
        let list = value.get_ref().as_array().ok_or_else(wrong)?;
        list.iter().map(|entry| Self::of_value(self.text, key, entry)).collect()
    }

    /// All keys that are left, with the places of their names, in the order of the file.
    pub(super) fn rest(mut self) -> Vec<(String, usize, &'t Spanned<DeValue<'i>>)> {
        self.entries.sort_by_key(|(_, begin, _)| *begin);
        self.entries
    }

    /// Ends the table: every key that was not taken is unknown.
    pub(super) fn finish(self) -> Result<(), SceneError> {
        let names: Vec<&str> = self.known.iter().map(|(name, _)| *name).collect();
        let known = names.join(", ");
        let (text, prefix) = (self.text, self.prefix.clone());
        match self.rest().first() {
            Some((key, begin, _)) => {
                let hint = did_you_mean(key, names);
                let problem = format!("unknown key{hint}; known are: {known}");
                Err(text.invalid(*begin, &format!("{prefix}{key}"), problem))
            }
            None => Ok(()),
        }
    }
}

/// A value and where its key stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Located<T> {
    pub(super) begin: usize,
    pub(super) value: T,
}

fn number_of(value: &DeValue<'_>) -> Option<f64> {
    let number = match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64),
        _ => None,
    };
    number.filter(|number: &f64| number.is_finite())
}

fn list_of(value: &Spanned<DeValue<'_>>) -> Option<Vec<f64>> {
    value.get_ref().as_array()?.iter().map(|number| number_of(number.get_ref())).collect()
}

fn kind_of(value: &Spanned<DeValue<'_>>) -> String {
    match value.get_ref() {
        DeValue::Float(float) => format!("`{}`", float.as_str()),
        DeValue::Integer(integer) => format!("`{}`", integer.as_str()),
        DeValue::String(text) => format!("the text \"{text}\""),
        other => format!("a value of the kind {}", other.type_str()),
    }
}
