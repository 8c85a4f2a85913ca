//! Roles that users give to objects by name, over the materials of the file.

use super::{Material, Role};
use crate::error::SceneError;
use globset::{Glob, GlobMatcher};

/// Gives a role to every object whose node or material name matches.
#[derive(Clone, Debug)]
pub struct RoleRule {
    pattern: String,
    matcher: GlobMatcher,
    role: Role,
    ior: Option<f32>,
}

impl RoleRule {
    /// A rule for `pattern` (a name, or a glob with `*`, `?`, `[...]`, `{a,b}`); the index of refraction is for lenses.
    pub fn new(pattern: &str, role: Role, ior: Option<f32>) -> Result<Self, SceneError> {
        let invalid = |problem: String| SceneError::invalid("role", pattern, problem);
        // A name that is no valid glob can still be meant literally.
        let glob = Glob::new(pattern)
            .or_else(|_| Glob::new(&globset::escape(pattern)))
            .map_err(|error| invalid(format!("is neither a name nor a glob: {error}")))?;
        if let Some(ior) = ior.filter(|ior| !(0.1..=10.0).contains(ior)) {
            return Err(invalid(format!("the index of refraction {ior} is outside 0.1 to 10")));
        }
        Ok(Self { pattern: pattern.into(), matcher: glob.compile_matcher(), role, ior })
    }

    /// Reads `GLOB` or `GLOB:IOR`.
    pub fn parse_lens(text: &str) -> Result<Self, SceneError> {
        match text.rsplit_once(':').and_then(|(pattern, ior)| Some((pattern, ior.trim().parse().ok()?))) {
            Some((pattern, ior)) => Self::new(pattern, Role::Lens, Some(ior)),
            None => Self::new(text, Role::Lens, None),
        }
    }

    /// The pattern as it was given.
    pub fn pattern(&self) -> &str {
        &self.pattern
    }

    /// Whether the rule is for a node or material of these names.
    pub fn matches(&self, node: &str, material: &str) -> bool {
        node == self.pattern
            || material == self.pattern
            || (!node.is_empty() && self.matcher.is_match(node))
            || (!material.is_empty() && self.matcher.is_match(material))
    }

    /// The material with the rule's role.
    pub fn apply(&self, material: &Material) -> Material {
        Material {
            role: self.role,
            ior: self.ior.unwrap_or(material.ior),
            schlick: false,
            coat: if self.role == Role::Coated { material.coat } else { 0.0 },
            ..material.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_globs_and_indices_of_refraction() {
        let rule = RoleRule::parse_lens("Glass*:1.7").unwrap();
        assert!(rule.matches("GlassBall", "") && rule.matches("", "Glass") && !rule.matches("Ball", ""));
        assert_eq!(rule.apply(&Material::default()).ior, 1.7);
        let literal = RoleRule::new("a[1", Role::Reflector, None).unwrap();
        assert!(literal.matches("a[1", ""));
        assert!(RoleRule::parse_lens("x:99").is_err());
        assert_eq!(RoleRule::parse_lens("na:me").unwrap().pattern(), "na:me");
    }
}
