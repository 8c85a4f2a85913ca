//! Settings of objects by name, over the materials of the file: roles, and blends of mirrors.

use super::name_pattern::NamePattern;
use super::{AlphaMode, Blend, Material, Role};
use crate::error::SceneError;

/// Blends every mirror whose node or material name matches.
#[derive(Clone, Debug)]
pub struct BlendRule {
    pattern: NamePattern,
    blend: Blend,
}

impl BlendRule {
    /// A rule for `pattern`: a name or a glob, as of roles.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] when the pattern is too large.
    pub fn new(pattern: &str, blend: Blend) -> Result<Self, SceneError> {
        Ok(Self { pattern: NamePattern::read("blend", pattern)?, blend })
    }

    /// The pattern as it was given.
    pub fn pattern(&self) -> &str {
        self.pattern.text()
    }

    /// The blend that it gives.
    pub(super) fn blend(&self) -> Blend {
        self.blend
    }

    /// Returns true if the rule is for a node or material of these names.
    pub fn matches(&self, node: &str, material: &str) -> bool {
        self.pattern.matches(node, material)
    }
}

/// Gives a role to every object whose node or material name matches.
#[derive(Clone, Debug)]
pub struct RoleRule {
    pattern: NamePattern,
    role: Role,
    ior: Option<f32>,
}

impl RoleRule {
    /// A rule for `pattern` (a name, or a glob with `*`, `?`, `[...]`, `{a,b}`); the index of refraction is for lenses.
    pub fn new(pattern: &str, role: Role, ior: Option<f32>) -> Result<Self, SceneError> {
        let invalid = |problem: String| SceneError::invalid("role", pattern, problem);
        let names = NamePattern::read("role", pattern)?;
        if let Some(ior) = ior.filter(|ior| !(0.1..=10.0).contains(ior)) {
            return Err(invalid(format!("the index of refraction {ior} is outside 0.1 to 10")));
        }
        Ok(Self { pattern: names, role, ior })
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
        self.pattern.text()
    }

    /// The role that it gives.
    pub fn role(&self) -> Role {
        self.role
    }

    /// The index of refraction that it gives, if any.
    pub fn ior(&self) -> Option<f32> {
        self.ior
    }

    /// Returns true if the rule is for a node or material of these names.
    pub fn matches(&self, node: &str, material: &str) -> bool {
        self.pattern.matches(node, material)
    }

    /// The material with the rule's role.
    pub fn apply(&self, material: &Material) -> Material {
        Material {
            role: self.role,
            ior: self.ior.unwrap_or(material.ior),
            schlick: false,
            blend: material.blend.filter(|_| self.role == Role::Reflector),
            coat: if self.role == Role::Coated { material.coat } else { 0.0 },
            // A role takes the place of lobes, and of veils.
            lobes: None,
            alpha_mode: match material.alpha_mode {
                AlphaMode::Blend => AlphaMode::Mask(0.5),
                other => other,
            },
            mirror_roughness: if self.role == material.role { material.mirror_roughness } else { 0.0 },
            ..material.clone()
        }
    }
}
