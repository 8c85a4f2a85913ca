//! Patterns of names, for rules about nodes and materials.

use crate::error::SceneError;
use globset::{Glob, GlobMatcher};

/// A name of nodes or materials, or a glob with `*`, `?`, `[...]`, `{a,b}`.
#[derive(Clone, Debug)]
pub(super) struct NamePattern {
    text: String,
    matcher: GlobMatcher,
}

impl NamePattern {
    /// A pattern as the part `kind` of a scene names it.
    pub(super) fn read(kind: &str, text: &str) -> Result<Self, SceneError> {
        let invalid = |error| SceneError::invalid(kind, text, format!("is neither a name nor a glob: {error}"));
        Self::new(text).map_err(invalid)
    }

    /// The pattern as it was given.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    fn new(text: &str) -> Result<Self, globset::Error> {
        // A name that is no valid glob is still matched literally.
        let glob = Glob::new(text).or_else(|_| Glob::new(&globset::escape(text)))?;
        Ok(Self { text: text.into(), matcher: glob.compile_matcher() })
    }

    pub(super) fn matches(&self, node: &str, material: &str) -> bool {
        // Objects without any name are still among everything, which `*` matches.
        let has_name = !(node.is_empty() && material.is_empty());
        let is_match = |name: &str| !(has_name && name.is_empty()) && self.matcher.is_match(name);
        node == self.text || material == self.text || is_match(node) || is_match(material)
    }
}
